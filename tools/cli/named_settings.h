// NAME:KEY=VALUE,...: a thing in a file by its name, and described options of it, in one word of the command line.
#pragma once

#include <volcaustic/options.h>

#include <functional>
#include <string>
#include <string_view>

namespace volcaustic::cli {

/// A visitor of described fields (volcaustic/options.h) that sets the one called `key`.
class FieldSetter {
public:
  FieldSetter(std::string_view key, std::string_view value) : mKey(key), mValue(value) {}

  void operator()(const char* name, int& field, const FieldDoc& doc);
  void operator()(const char* name, double& field, const FieldDoc& doc);
  /// Three numbers as 0.1/0.2/0.3, or one for all.
  void operator()(const char* name, Rgb& field, const FieldDoc& doc);

  [[nodiscard]] bool known() const { return mKnown; } ///< a field of that name was visited
  [[nodiscard]] bool good() const { return mGood; }   ///< and the value was in its range
  [[nodiscard]] const std::string& keys() const { return mKeys; }

private:
  bool isCalled(std::string_view name);

  std::string_view mKey, mValue;
  bool mKnown = false, mGood = false;
  std::string mKeys; ///< all that were visited
};

/// Sets what `text` says and returns its NAME, which may hold colons. `visit` has a setter visit the fields there are;
/// `ior` is another word for index. \throws Error(Usage) "FLAG TEXT: ..." with the keys there are.
std::string nameAndSettings(const char* flag, const std::string& text, const std::function<void(FieldSetter&)>& visit);

} // namespace volcaustic::cli
