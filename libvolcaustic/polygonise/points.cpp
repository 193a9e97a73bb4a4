#include "polygonise/points.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// Calls body(points, begin) for batch after batch.
template <class Body>
void eachBatch(const PointArrays& points, const Body& body) {
  for (std::size_t begin = 0; begin < points.size(); begin += kShapeBatch) {
    const auto count = static_cast<int>(std::min<std::size_t>(points.size() - begin, kShapeBatch));
    body(ShapePoints{points.x.data() + begin, points.y.data() + begin, points.z.data() + begin, count}, begin);
  }
}

} // namespace

void PointEvaluator::values(const PointArrays& points, std::vector<double>& values) {
  values.resize(points.size());
  eachBatch(points, [&](const ShapePoints& batch, std::size_t begin) {
    mProgram.values(batch, values.data() + begin, mScratch);
  });
  mCount += points.size();
}

void PointEvaluator::gradients(const PointArrays& points, ValueArrays& values) {
  values.value.resize(points.size());
  values.gradient.resize(points.size());
  eachBatch(points, [&](const ShapePoints& batch, std::size_t begin) {
    PointArrays& g = values.gradient;
    mProgram.gradients(
        batch, {values.value.data() + begin, {g.x.data() + begin, g.y.data() + begin, g.z.data() + begin}}, mScratch);
  });
  mCount += points.size();
}

void PointEvaluator::parts(const PointArrays& points, std::vector<std::uint32_t>& parts) {
  parts.resize(points.size());
  eachBatch(points, [&](const ShapePoints& batch, std::size_t begin) {
    mProgram.parts(batch, parts.data() + begin, mScratch);
  });
  mCount += points.size();
}

} // namespace volcaustic
