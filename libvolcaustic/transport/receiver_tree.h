// The hierarchy of boxes over the triangles of receivers.
#pragma once

#include "kernels/receivers.h"

#include <cstdint>
#include <vector>

namespace volcaustic {

struct ReceiverTree {
  std::vector<kernels::ReceiverNode> nodes;
  std::vector<std::int32_t> order; ///< numbers of the triangles, in the order in which leaves hold them
};

/// By the surface area heuristic over bins (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
/// 2007); the same tree every time. Boxes are padded by 2^-20 of the largest coordinate, so that what single precision
/// does to a ray and its corners does not move a hit out of its box.
ReceiverTree receiverTree(const std::vector<kernels::ReceiverTriangle>& triangles);

} // namespace volcaustic
