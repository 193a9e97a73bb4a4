// One trilinear lookup of n and grad n, scalar: our bricks against NanoVDB's read accessor, on a glass ball of radius
// 45 voxels in 256^3. In order along parallel rays, one voxel apart, and at random places of the ball's box.
//   build/bench/bin/bench_lookup
// Label: the largest difference between NanoVDB's n or grad n and ours over all points.

#include "support/fields.h"
#include "support/solids.h"
#include "volcaustic/openvdb.h"
#include "volume/flatten.h"

#include <benchmark/benchmark.h>
#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/tools/Prune.h>
#include <random>

namespace volcaustic::test {
namespace {

using kernels::FieldVoxel;
using kernels::Float3;

constexpr int kResolution = 256;
constexpr float kRadius = 45, kCentre = 128;
constexpr std::size_t kPoints = 1 << 20;

using FieldTree = openvdb::tree::Tree4<openvdb::Vec4f, 5, 4, 3>::Type;
using FieldGrid = openvdb::Grid<FieldTree>;
using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

/// The same field in each layout.
struct Fields {
  FlatMediumStorage ours;
  Handle packed;          ///< one grid of (n, grad n)
  Handle index, gradient; ///< a grid each
};

const Fields& fields() {
  static const Fields all = [] {
    openvdb::initialize();
    Body body;
    const double h = 1.0 / kResolution;
    body.mesh = ball({kCentre * h, kCentre * h, kCentre * h}, kRadius * h, 115);
    const Medium medium = buildMedium(std::span(&body, 1), {}, unitCube(kResolution));

    FlatMediumStorage ours = flattenMedium(medium, {}, {});
    FieldGrid packed(openvdb::Vec4f(1, 0, 0, 0));
    openvdb::FloatGrid index(1);
    openvdb::Vec3SGrid gradient;
    auto toPacked = packed.getAccessor();
    auto toIndex = index.getAccessor();
    auto toGradient = gradient.getAccessor();
    openvdb::CoordBBox box = medium.grids().index->evalActiveVoxelBoundingBox();
    box.expand(2);
    for (auto ijk = box.begin(); ijk; ++ijk) {
      const openvdb::Coord c = *ijk;
      const auto f = kernels::sampleField(ours.view(), Float3(c.x() + .5f, c.y() + .5f, c.z() + .5f));
      const openvdb::Vec4f field(f.n, f.gradient.x, f.gradient.y, f.gradient.z);
      if (field != packed.background()) toPacked.setValue(c, field);
      if (f.n != index.background()) toIndex.setValue(c, f.n);
      if (const openvdb::Vec3f g(field[1], field[2], field[3]); g != gradient.background()) toGradient.setValue(c, g);
    }
    openvdb::tools::prune(packed.tree());
    openvdb::tools::prune(index.tree());
    return Fields{std::move(ours), nanovdb::openToNanoVDB<nanovdb::HostBuffer, FieldTree>(packed),
                  nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree>(index),
                  nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::Vec3STree>(gradient)};
  }();
  return all;
}

/// Points of the ball's box, with the width of the skin around it. Rays are as far apart as those of 1024^2 photons.
std::vector<Float3> points(bool coherent) {
  constexpr float kLow = kCentre - kRadius - 6, kHigh = kCentre + kRadius + 6;
  const Float3 along = kernels::normalize(Float3(.15f, .1f, -1));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(kLow, kHigh);
  std::vector<Float3> all;
  Float3 start{kLow, kCentre - 10, kHigh};
  while (all.size() < kPoints) {
    if (!coherent) {
      all.emplace_back(place(random), place(random), place(random));
      continue;
    }
    for (Float3 p = start; p.z > kLow; p += along) all.push_back(p);
    start.x += .25f;
    if (start.x > kHigh) start = {kLow, start.y + .25f, kHigh};
  }
  return all;
}

/// The eight voxel centres around a point: value(i, j, k) of each, and the weights.
template <class Value>
FieldVoxel trilinear(const Float3& p, const Value& value) {
  const Float3 q = p - Float3(0.5f);
  const int i = static_cast<int>(std::floor(q.x)), j = static_cast<int>(std::floor(q.y)),
            k = static_cast<int>(std::floor(q.z));
  const float tx = q.x - static_cast<float>(i), ty = q.y - static_cast<float>(j), tz = q.z - static_cast<float>(k);
  const auto row = [&](int x, int y) { return mix(value(x, y, k), value(x, y, k + 1), tz); };
  return mix(mix(row(i, j), row(i, j + 1), ty), mix(row(i + 1, j), row(i + 1, j + 1), ty), tx);
}

struct OurBricks {
  kernels::FlatMedium medium = fields().ours.view();
  FieldVoxel operator()(const Float3& p) const {
    const auto f = kernels::sampleField(medium, p);
    return {f.n, f.gradient.x, f.gradient.y, f.gradient.z};
  }
};

struct PackedNanoVdb {
  nanovdb::DefaultReadAccessor<nanovdb::Vec4f> accessor = fields().packed.grid<nanovdb::Vec4f>()->getAccessor();
  FieldVoxel operator()(const Float3& p) const {
    return trilinear(p, [&](int i, int j, int k) -> FieldVoxel {
      const nanovdb::Vec4f& v = accessor.getValue({i, j, k});
      return {v[0], v[1], v[2], v[3]};
    });
  }
};

struct TwoNanoVdb {
  nanovdb::DefaultReadAccessor<float> index = fields().index.grid<float>()->getAccessor();
  nanovdb::DefaultReadAccessor<nanovdb::Vec3f> gradient = fields().gradient.grid<nanovdb::Vec3f>()->getAccessor();
  FieldVoxel operator()(const Float3& p) const {
    return trilinear(p, [&](int i, int j, int k) -> FieldVoxel {
      const nanovdb::Vec3f& g = gradient.getValue({i, j, k});
      return {index.getValue({i, j, k}), g[0], g[1], g[2]};
    });
  }
};

float largestDifference(const FieldVoxel& a, const FieldVoxel& b) {
  return std::max(std::max(std::abs(a.n - b.n), std::abs(a.gx - b.gx)),
                  std::max(std::abs(a.gy - b.gy), std::abs(a.gz - b.gz)));
}

template <class Layout>
void Lookup(benchmark::State& state) {
  const std::vector<Float3> at = points(state.range(0) != 0);
  const Layout layout;
  const OurBricks ours;
  float difference = 0;
  for (const Float3& p : at) difference = std::max(difference, largestDifference(layout(p), ours(p)));
  if (difference > 1e-5f) state.SkipWithError("the layouts do not hold the same field");
  state.SetLabel(std::to_string(difference));

  for (auto _ : state) {
    FieldVoxel sum{0, 0, 0, 0};
    for (const Float3& p : at) {
      const FieldVoxel f = layout(p);
      sum = {sum.n + f.n, sum.gx + f.gx, sum.gy + f.gy, sum.gz + f.gz};
    }
    benchmark::DoNotOptimize(sum);
  }
  state.counters["lookup"] = benchmark::Counter(
      static_cast<double>(at.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK(Lookup<OurBricks>)->ArgName("coherent")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK(Lookup<PackedNanoVdb>)->ArgName("coherent")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK(Lookup<TwoNanoVdb>)->ArgName("coherent")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace volcaustic::test
