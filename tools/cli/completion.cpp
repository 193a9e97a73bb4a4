// completion: a script that lets bash complete subcommands, flags and files.
#include "common.h"

#include <cstdio>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

/// The words that may follow `command`: its subcommands and flags.
std::string wordsAfter(const CLI::App& command) {
  std::string words;
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    words += sub->get_name() + " ";
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) words += "--" + name + " ";
  return words;
}

/// A case branch for `command` and each of its subcommands; `path` is how it is typed.
std::string caseBranches(const CLI::App& command, const std::string& path) {
  std::string branches = fmt::format("    \"{}\") words=\"{}\" ;;\n", path, wordsAfter(command));
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    branches += caseBranches(*sub, path.empty() ? sub->get_name() : path + " " + sub->get_name());
  return branches;
}

std::string bashScript(const CLI::App& app) {
  return fmt::format(R"(# Completion of volcaustic for bash: source <(volcaustic completion bash)
_volcaustic() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" path="" words="" word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$word" in -*) break ;; esac
    case "$path" in ""|scene) path="${{path:+$path }}$word" ;; *) break ;; esac
  done
  case "$path" in
{}  esac
  COMPREPLY=($(compgen -W "$words" -- "$current"))
  case "$current" in -*) ;; *) COMPREPLY+=($(compgen -f -- "$current")) ;; esac
}}
complete -o filenames -F _volcaustic volcaustic
)",
                     caseBranches(app, ""));
}

} // namespace

void addCompletionCommand(CLI::App& app, Action& action) {
  CLI::App* completion = app.add_subcommand("completion", "print a script that completes commands in a shell");
  completion->require_subcommand(1);
  CLI::App* bash = completion->add_subcommand("bash", "for bash: source <(volcaustic completion bash)");
  bash->final_callback([&app, &action] {
    action = [&app] {
      std::fputs(bashScript(app).c_str(), stdout);
      return 0;
    };
  });
}

} // namespace volcaustic::cli
