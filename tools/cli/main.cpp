// The volcaustic program: parses the command line, runs one subcommand, and turns whatever happens into one line and an
// exit status (docs/cli.md).
#include "common.h"

#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <new>

namespace volcaustic::cli {

namespace {

void printLine(const std::string& line) { std::fprintf(stderr, "%s\n", oneLine(line).c_str()); }

/// "volcaustic scene check": the subcommands that were recognised.
std::string commandTyped(const CLI::App& app) {
  std::string command = "volcaustic";
  for (const CLI::App* at = &app; !at->get_subcommands().empty(); command += " " + at->get_name())
    at = at->get_subcommands().front();
  return command;
}

void printUsageError(const CLI::App& app, const CLI::ParseError& error) {
  const std::string command = commandTyped(app);
  printLine(fmt::format("{}: {}; see `{} --help`", command, error.what(), command));
}

void addHelpCommand(CLI::App& app, Action& action) {
  CLI::App* help = app.add_subcommand("help", "what a command does and what it takes");
  auto path = std::make_shared<std::vector<std::string>>();
  help->add_option("COMMAND", *path, "as `mesh2vdb` or `scene check`");
  help->final_callback([&app, &action, path] {
    action = [&app, path] {
      CLI::App* command = &app;
      for (const std::string& name : *path) {
        const auto next = command->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == name; });
        if (next.empty()) throw Error(ErrorKind::Usage, name + ": is not a command; see `volcaustic --help`");
        command = next.front();
      }
      // help() adds the command's own name to the words before it.
      std::string before;
      for (const CLI::App* parent = command->get_parent(); parent; parent = parent->get_parent())
        before = parent->get_name() + (before.empty() ? "" : " " + before);
      std::fputs(command->help(before).c_str(), stdout);
      return 0;
    };
  });
}

/// The first signal asks the running stage to stop; a second one ends the program at once.
void watchSignals() {
  struct sigaction interrupt {};
  interrupt.sa_handler = [](int) { gInterrupted = true; };
  interrupt.sa_flags = SA_RESETHAND;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &interrupt, nullptr);
}

int run(int argc, char** argv) {
  CLI::App app("Surfaces to sparse optical volumes, photons along curved rays, caustics as OpenVDB", "volcaustic");
  app.set_version_flag("--version", "volcaustic " VOLCAUSTIC_VERSION);
  app.require_subcommand(1);
  app.footer("Exit status: 0 done, 1 our fault, 2 wrong usage, 3 bad input, 4 device, 130 interrupted.");
  Action action;
  addMeshToVdbCommand(app, action);
  addVdbToMeshCommand(app, action);
  addShapeToMeshCommand(app, action);
  addRenderCommands(app, action);
  addViewCommand(app, action);
  addSimulateCommands(app, action);
  addInfoCommand(app, action);
  addCompareCommand(app, action);
  addConvertCommand(app, action);
  addSceneCommands(app, action);
  addBenchCommand(app, action);
  addDevicesCommand(app, action);
  addCompletionCommand(app, action);
  addHelpCommand(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& helpOrVersion) {
    return app.exit(helpOrVersion);
  } catch (const CLI::ParseError& error) {
    printUsageError(app, error);
    return kWrongUsage;
  }
  try {
    return action();
  } catch (const Error& error) {
    printLine(errorLine(error, commandTyped(app)));
    return statusOf(error.kind());
  } catch (const std::bad_alloc&) {
    printLine(commandTyped(app) +
              ": out of memory; lower the resolution, or set --memory-limit so that it is seen beforehand");
    return kBadInput;
  } catch (const std::exception& error) {
    printLine(fmt::format("volcaustic: internal error: {}", error.what()));
    return kOurFault;
  }
}

} // namespace

} // namespace volcaustic::cli

int main(int argc, char** argv) {
  volcaustic::cli::watchSignals();
  return volcaustic::cli::run(argc, argv);
}
