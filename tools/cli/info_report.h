// What `info` says of a file of each kind: tables on standard output, unless the job prints JSON, and the entry of the
// report in either case. Each throws Error like the reader of its kind.
#pragma once

#include "common.h"

namespace volcaustic::cli {

/// \param selfIntersections look for them, too: it costs more than all else that is said of a mesh
Json meshInfo(const std::string& path, bool selfIntersections, Job& job);
Json volumeInfo(const std::string& path, Job& job);
Json imageInfo(const std::string& path, Job& job);
Json sceneInfo(const std::string& path, Job& job);
Json shapeInfo(const std::string& path, Job& job);

} // namespace volcaustic::cli
