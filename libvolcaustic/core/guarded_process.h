// Code that may crash, hang or devour memory on a damaged file runs in a child process with limits; only bytes that it
// wrote on purpose come back.
#pragma once

#include "volcaustic/run_context.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <streambuf>
#include <string>

namespace volcaustic {

struct GuardLimits {
  std::uint64_t memoryBytes = 0; ///< what the child may allocate, and write, beyond what the process has already
  double cpuSeconds = 0;

  /// Limits for reading a file of `fileBytes`: enough for every honest one. Formats of sparse or compressed data blow
  /// up by a bounded factor, so a small file gets little memory whatever it claims.
  static GuardLimits forFile(std::uint64_t fileBytes, const RunContext& ctx);
};

/// The child's bytes, mapped read-only until destruction.
class GuardedBytes {
public:
  GuardedBytes() = default;
  /// Maps the whole of the file `descriptor`, which the caller may close. \throws Error(Internal).
  explicit GuardedBytes(int descriptor);
  ~GuardedBytes();
  GuardedBytes(GuardedBytes&& other) noexcept;
  GuardedBytes& operator=(GuardedBytes&& other) noexcept;
  [[nodiscard]] std::span<const char> bytes() const { return {mData, mSize}; }

private:
  const char* mData = nullptr;
  std::size_t mSize = 0;
};

/// A seekable input stream over bytes that somebody else owns.
class MemoryBuffer : public std::streambuf {
public:
  explicit MemoryBuffer(std::span<const char> bytes);

protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir origin, std::ios_base::openmode which) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode which) override;
};

/// Size of a regular file that can be opened for reading.
/// \throws Error(File) for one that is missing, unreadable, a folder, or no regular file (reading a pipe could hang).
std::uint64_t readableFileSize(const std::string& path);

/// Runs `parse` in a forked child, silent and serial, and returns what it wrote. `parse` must start no threads; locks
/// that other threads held at the fork stay locked in the child, which then makes no progress, is ended and started
/// once more. An Error thrown by `parse` arrives unchanged; any other exception, crash, exhausted limit or lack of
/// progress becomes Error(Input) "place: damaged: ...". The child never outlives the call nor the calling thread.
GuardedBytes runGuarded(const std::string& place, const GuardLimits& limits, const RunContext& ctx,
                        const std::function<void(std::ostream& out)>& parse);

} // namespace volcaustic
