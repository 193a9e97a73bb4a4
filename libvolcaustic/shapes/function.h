// The functions that shapes are made of: solids, and what displaces their surfaces.
#pragma once

#include "shapes/batch.h"
#include "shapes/interval.h"
#include "volcaustic/types.h"

namespace volcaustic {

/// A function of space. Safe to use from several threads.
class ShapeFunction {
public:
  virtual ~ShapeFunction() = default;

  /// Values, and gradients where they are wanted, at points of the function's own space. The value at a point is the
  /// same to the bit whatever the other points of the batch are, and whether gradients are wanted.
  virtual void evaluate(const ShapePoints& points, const ShapeValues& values) const = 0;

  /// Holds every value that evaluate() gives in the box, its roundings included. For a box that shrinks to a point it
  /// becomes that point's value, and boxes of any finite size are taken.
  [[nodiscard]] virtual Interval bound(const Box& box) const = 0;
};

} // namespace volcaustic
