// What every subcommand shares: its common options, the context it runs in, its words and its report.
#pragma once

#include "console.h"
#include "report.h"

#include <volcaustic/device.h>
#include <volcaustic/error.h>
#include <volcaustic/run_context.h>

#include <atomic>
#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace volcaustic::cli {

/// Set by SIGINT and SIGTERM; every run looks at it.
extern std::atomic<bool> gInterrupted;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

enum ExitStatus { kDone = 0, kOurFault = 1, kWrongUsage = 2, kBadInput = 3, kDeviceTrouble = 4, kInterrupted = 130 };
int statusOf(ErrorKind kind);
/// Whatever a library puts into its message, an error is one line.
std::string oneLine(std::string text);
/// The line that a person reads of it: usage and device errors begin with the command ("volcaustic mesh2vdb").
std::string errorLine(const Error& error, const std::string& command);

/// Filled in by the parser: what the chosen subcommand does. Returns the exit status.
using Action = std::function<int()>;

struct CommonOptions {
  int threads = 0;
  std::uint64_t seed = 0;
  std::string device = "auto";
  std::uint64_t memoryLimit = 0;
  bool quiet = false, verbose = false, json = false, progress = false;
  std::string jsonFile; ///< where the report goes as well, for commands whose own --json takes a file
};
inline constexpr const char* kCommonOptions = "Common options"; ///< their group in the help
/// A command that has declared a --json of its own keeps it.
void addCommonOptions(CLI::App& command, CommonOptions& options);

/// Adds a subcommand whose `Options` live as long as the parser. `declare` adds its flags, `run` does its work. Options
/// with a member `common` take the common options too.
template <class Options>
CLI::App* addCommand(CLI::App& parent, Action& action, const char* name, const char* text,
                     void (*declare)(CLI::App&, Options&), int (*run)(const Options&)) {
  CLI::App* command = parent.add_subcommand(name, text);
  auto options = std::make_shared<Options>();
  declare(*command, *options);
  if constexpr (requires { options->common; }) addCommonOptions(*command, options->common);
  command->final_callback([&action, options, run] { action = [options, run] { return run(*options); }; });
  return command;
}

/// One run of a subcommand.
class Job {
public:
  /// \throws Error(Device) when the device asked for cannot be used.
  Job(const char* command, const CommonOptions& options);

  [[nodiscard]] const RunContext& context() const { return mContext; }
  [[nodiscard]] Console& console() { return mConsole; }
  [[nodiscard]] bool json() const { return mJson; }
  /// What computes: the CPU, before tracesPhotons().
  [[nodiscard]] const std::string& device() const { return mDevice; }
  /// Says that the command traces photons, so that the device asked for takes part in it.
  void tracesPhotons();
  /// The report's fields that are this subcommand's own.
  [[nodiscard]] Json& report() { return mReport; }

  void addInput(const std::string& path) { mReport["inputs"].push_back(path); }
  void addOutput(const std::string& path) { mReport["outputs"].push_back(path); }
  void addStages(std::span<const StageRun> runs);
  /// Runs `body` and adds it to the report as a stage.
  template <class Body>
  auto timed(const char* stage, Body&& body) {
    const auto start = std::chrono::steady_clock::now();
    if constexpr (std::is_void_v<decltype(body())>) {
      body();
      addStage(stage, start);
    } else {
      auto result = body();
      addStage(stage, start);
      return result;
    }
  }

  /// Runs `body` for one file of several. What is wrong with that file alone (its content, its name, an option that
  /// does not fit it) is printed, noted as "error" in `entry` and kept for status(), and the other files get their
  /// turn.
  void attempt(Json& entry, const std::function<void()>& body);
  /// With --resume: says so and is true where the file is there.
  bool skips(bool resume, const std::string& output);
  /// The exit status of the first file that failed, or kDone.
  [[nodiscard]] int status() const { return mStatus; }

  /// Prints the report, or writes it to its file, when it was asked for.
  void finish();

private:
  void addStage(const char* stage, std::chrono::steady_clock::time_point start);

  Console mConsole;
  RunContext mContext;
  std::string mDevice = "cpu";
  bool mJson;
  std::string mJsonFile;
  Json mReport;
  int mStatus = kDone;
};

/// The commands, by file.
void addMeshToVdbCommand(CLI::App& app, Action& action);
void addVdbToMeshCommand(CLI::App& app, Action& action);
void addShapeToMeshCommand(CLI::App& app, Action& action);
void addRenderCommands(CLI::App& app, Action& action);
void addViewCommand(CLI::App& app, Action& action);
void addSimulateCommands(CLI::App& app, Action& action);
void addInfoCommand(CLI::App& app, Action& action);
void addCompareCommand(CLI::App& app, Action& action);
void addConvertCommand(CLI::App& app, Action& action);
void addSceneCommands(CLI::App& app, Action& action);
void addBenchCommand(CLI::App& app, Action& action);
void addDevicesCommand(CLI::App& app, Action& action);
void addCompletionCommand(CLI::App& app, Action& action);

} // namespace volcaustic::cli
