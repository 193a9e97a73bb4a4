// What a Shape points at: its node, and what is asked of it again and again.
#pragma once

#include "volcaustic/shape.h"

namespace volcaustic {

struct StoredShape {
  /// Instructions that a program may have.
  static constexpr std::uint64_t kLargest = 1'000'000;

  ShapeNode node;
  int depth;          ///< of nodes
  std::uint64_t size; ///< at least as many instructions as its program has, kLargest + 1 at most
  std::uint64_t hash;

  static const StoredShape& of(const Shape& shape) { return *shape.mStored; }
};

} // namespace volcaustic
