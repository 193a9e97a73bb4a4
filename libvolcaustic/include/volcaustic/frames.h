/// \file frames.h
/// Names of the files of a sequence: name.0001.ply, name.0002.ply, ...
#pragma once

#include "volcaustic/export.h"

#include <string>

namespace volcaustic {

/// True when the file name of `path` has a place for the frame number: a run of '#', or %d, %4d, %04d.
VOLCAUSTIC_API bool hasFramePlace(const std::string& path);
/// `path` with the place for the frame number replaced by the zero-padded number ("a.####.vdb" -> "a.0012.vdb").
VOLCAUSTIC_API std::string withFrame(const std::string& path, int frame);
/// `path`, with ".####" before its extension when it has no place for the frame number.
VOLCAUSTIC_API std::string framePattern(const std::string& path);

} // namespace volcaustic
