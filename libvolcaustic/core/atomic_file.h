// A file that appears whole or not at all.
#pragma once

#include <filesystem>

namespace volcaustic {

/// Names a temporary file beside `target` with the same extension; commit() renames it over the target, the destructor
/// removes it if that never happened. A killed run leaves the old file or none under the target's name.
class AtomicFile {
public:
  /// \throws Error(File) when the folder of `target` does not exist or cannot be written, or `target` is a folder.
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Write here.
  [[nodiscard]] const std::filesystem::path& path() const { return mTemporary; }
  void commit();

private:
  std::filesystem::path mTarget, mTemporary;
};

} // namespace volcaustic
