// Where the tests find the reference tables and the real files; tests that need them skip by name when they are absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

namespace volcaustic::test {

/// `relative` inside the shared folder (environment VOLCAUSTIC_SHARED, else ../shared beside the sources).
inline std::filesystem::path sharedPath(const std::string& relative) {
  const char* root = std::getenv("VOLCAUSTIC_SHARED");
  const std::filesystem::path base =
      root && *root ? std::filesystem::path(root) : std::filesystem::path(VOLCAUSTIC_SOURCE_DIR) / ".." / "shared";
  return base / relative;
}

/// A folder of its own for a test's files, removed at the end.
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "volcaustic-test-XXXXXX").string();
    mPath = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(mPath, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return mPath / name; }

private:
  std::filesystem::path mPath;
};

} // namespace volcaustic::test

/// Skips the running test, naming the file that is missing.
#define VOLCAUSTIC_NEED_SHARED(path)                                                                                   \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "not present: " << (path)
