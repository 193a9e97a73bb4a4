#include "simulation/flow.h"

namespace volcaustic {

namespace {

/// Sums of layers, added in their order: the same bits for any number of threads.
template <class Value>
double sumOverCells(const Flow& flow, const RunContext& ctx, const Value& value) {
  std::vector<double> layers(flow.cells[2]);
  parallelFor(flow.cells[2], 4, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t k = begin; k < end; ++k) {
      const float* c = flow.concentration.values().data() + flow.concentration.index(0, 0, static_cast<int>(k) + 1);
      for (std::size_t i = 0; i < flow.concentration.stride(2); ++i) layers[k] += value(c[i]);
    }
  });
  double sum = 0;
  for (const double layer : layers) sum += layer;
  return sum;
}

/// What the speed of one would bring through bottom and top, in cells of the second fluid per cell that it passes.
double inflow(const Flow& flow) {
  const Lattice &upwards = flow.velocity.component[2], &c = flow.concentration;
  double sum = 0;
  for (const int k : {0, flow.cells[2]})
    for (int j = 0; j < flow.cells[1]; ++j)
      for (int i = 0; i < flow.cells[0]; ++i) {
        const float speed = upwards.at(i, j, k);
        const double passing = static_cast<double>(speed) * c.at(i, j, speed > 0 ? k : k + 1);
        sum += k == 0 ? passing : -passing;
      }
  return sum;
}

} // namespace

void balance(Flow& next, const Flow& before, float cells, const RunContext& ctx) {
  const auto itself = [](float c) { return static_cast<double>(c); };
  const auto between = [](float c) { return static_cast<double>(c) * (1 - c); };
  const double there = sumOverCells(next, ctx, itself);
  const double expected = sumOverCells(before, ctx, itself) + before.owed + cells * inflow(before);
  const double room = sumOverCells(next, ctx, between);
  // Within one, values between 0 and 1 stay so, and in their order.
  const double factor = room > 0 ? std::clamp((expected - there) / room, -1., 1.) : 0;
  const auto add = static_cast<float>(factor);
  forEachRow(next.cells, ctx, [&](int j, int k) {
    for (int i = 0; i < next.cells[0]; ++i) {
      float& c = next.concentration.at(i, j, k + 1);
      c = std::clamp(c + add * c * (1 - c), 0.0f, 1.0f);
    }
  });
  next.owed = expected - there - factor * room;
}

} // namespace volcaustic
