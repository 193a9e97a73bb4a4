/// \file run_context.h
/// What travels with every long call: threads, seed, limits, progress, log and cancellation.
#pragma once

#include "volcaustic/export.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace volcaustic {

enum class LogLevel { Detail, Info, Warning };

/// Passed by const reference to each stage. Copyable; the callbacks may be called from any thread, one at a time.
struct VOLCAUSTIC_API RunContext {
  int threads = 0;               ///< CPU threads; 0 takes all of them. Results do not depend on it.
  std::uint64_t seed = 0;        ///< selects the jitter of photons and of pixel samples
  std::uint64_t memoryLimit = 0; ///< bytes that one call may allocate; 0 means three quarters of physical memory
  /// Where photons are traced: "auto" (a GPU when one is usable, else the CPU), "cpu" or with an instruction set
  /// "cpu:scalar", "cpu:avx2", "cpu:avx512", "cuda" or one of several "cuda:1", "hybrid" (both, balanced while it runs)
  /// or with the CPU's share of the rows "hybrid:0.2". "auto" falls back to the CPU when the GPU's memory does not do;
  /// any other throws Error(Device). Pictures are rendered there, too; of two devices, on the GPU.
  std::string device = "auto";
  /// Called with the stage's name and the fraction done, 0 to 1.
  std::function<void(std::string_view stage, double fraction)> onProgress;
  std::function<void(LogLevel, std::string_view line)> onLog;
  /// When set and true, the running call throws Error(Cancelled) soon.
  const std::atomic<bool>* cancel = nullptr;

  /// Reports progress and throws Error(Cancelled) when the caller asked to stop. Call it from one thread.
  void progress(std::string_view stage, double fraction) const;
  void throwIfCancelled() const;
  void log(LogLevel level, std::string_view line) const;
  void warn(std::string_view line) const { log(LogLevel::Warning, line); }
  /// The limit in force, in bytes: memoryLimit, or three quarters of physical memory.
  [[nodiscard]] std::uint64_t effectiveMemoryLimit() const;
  /// Throws Error(Input) naming `what` when `bytes` is beyond the limit in force.
  void requireMemory(std::uint64_t bytes, std::string_view what) const;
};

} // namespace volcaustic
