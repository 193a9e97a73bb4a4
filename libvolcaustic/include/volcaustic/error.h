/// \file error.h
/// The one exception type that volcaustic throws on purpose.
#pragma once

#include "volcaustic/export.h"

#include <stdexcept>
#include <string>

namespace volcaustic {

/// Who is at fault, and so what a program reports: see docs/formats.md for the exit status of each.
enum class ErrorKind {
  Usage,     ///< an option or argument is out of range or contradicts another
  Input,     ///< the content of a file, a scene or a mesh is wrong
  File,      ///< a file cannot be opened, read or written
  Device,    ///< no such device, or it ran out of memory
  Cancelled, ///< the caller asked to stop
  Internal,  ///< a defect of volcaustic itself
};

/// An error whose message starts with the place ("bunny.ply:17: ", "scene.json:/lights/0: "), says what is wrong and
/// what to try, all in one line.
class VOLCAUSTIC_API Error : public std::runtime_error {
public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), mKind(kind) {}
  [[nodiscard]] ErrorKind kind() const noexcept { return mKind; }

private:
  ErrorKind mKind;
};

} // namespace volcaustic
