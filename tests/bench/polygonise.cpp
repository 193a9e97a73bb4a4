// Triangles of functional objects, against the plain way by OpenVDB: the shape sampled as a level set in a narrow band
// around its surface, and volumeToMesh(). One thread each, CPU time. `error` is the greatest distance between triangles
// and surface in thousandths of the shape's size, `angle` and `angle1` the median and the first percentile of
// triangles' least angles.
//   build/bench/bin/bench_polygonise

#include "volcaustic/polygonise.h"
#include "volcaustic/openvdb.h"

#include <benchmark/benchmark.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic::test {
namespace {

Shape benchShape(std::int64_t index) {
  if (index == 0) return Shape::torus(.7, .3).rotated({20, 30, 0});
  if (index == 1)
    return Shape::unite({Shape::sphere(.5), Shape::ellipsoid({.9, .3, .4}).rotated({10, 40, 20}),
                         Shape::capsule({-.5, -.5, -.5}, {.6, .7, .4}, .2)},
                        .15);
  return (Shape::cuboid({1.6, 1.2, 1}) - Shape::sphere(.4).translated({.1, .1, .6})).rotated({20, 33, 47});
}

double distanceToSurface(const ShapeField& field, const Vec3d& p) {
  double value;
  Vec3d gradient;
  field.values({&p, 1}, {&value, 1});
  field.gradients({&p, 1}, {&gradient, 1});
  const double slope = std::hypot(gradient[0], gradient[1], gradient[2]);
  return slope > 0 ? std::abs(value) / slope : 0;
}

double leastAngle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d* corners[] = {&a, &b, &c};
  double least = 180;
  for (int k = 0; k < 3; ++k) {
    const Vec3d &p = *corners[k], &q = *corners[(k + 1) % 3], &r = *corners[(k + 2) % 3];
    double qq = 0, rr = 0, qr = 0;
    for (int i = 0; i < 3; ++i) {
      qq += (q[i] - p[i]) * (q[i] - p[i]);
      rr += (r[i] - p[i]) * (r[i] - p[i]);
      qr += (q[i] - p[i]) * (r[i] - p[i]);
    }
    least = std::min(least, std::acos(std::clamp(qr / std::sqrt(qq * rr), -1.0, 1.0)) * 180 / std::numbers::pi);
  }
  return least;
}

void report(benchmark::State& state, const Shape& shape, const Mesh& mesh) {
  const ShapeField field(shape);
  std::vector<double> angles;
  double error = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double angle = leastAngle(a, b, c);
    angles.push_back(std::isfinite(angle) ? angle : 0);
    Vec3d middle, side;
    for (int i = 0; i < 3; ++i) {
      middle[i] = (a[i] + b[i] + c[i]) / 3;
      side[i] = (a[i] + b[i]) / 2;
    }
    error = std::max({error, distanceToSurface(field, middle), distanceToSurface(field, side)});
  }
  std::sort(angles.begin(), angles.end());
  state.counters["triangles"] = static_cast<double>(angles.size());
  state.counters["error"] = 1000 * error / 2;
  state.counters["angle"] = angles[angles.size() / 2];
  state.counters["angle1"] = angles[angles.size() / 100];
}

void Polygonise(benchmark::State& state) {
  const Shape shape = benchShape(state.range(0));
  PolygoniseOptions options;
  options.cellSize = 2.0 / static_cast<double>(state.range(1));
  RunContext ctx;
  ctx.threads = 1;
  Mesh mesh;
  for (auto _ : state) mesh = polygonise(shape, options, ctx);
  report(state, shape, mesh);
}

/// Voxels of leaves that the surface comes near to; leaves are found by bounds, as the polygoniser's blocks are.
class LevelSetSampler {
public:
  LevelSetSampler(const Shape& shape, double voxel)
      : mField(shape), mVoxel(voxel), mGrid(openvdb::FloatGrid::create(static_cast<float>(3 * voxel))) {
    mGrid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    mGrid->setGridClass(openvdb::GRID_LEVEL_SET);
  }

  openvdb::FloatGrid::Ptr run() {
    int cells = 8;
    while (cells * mVoxel < 1.3) cells *= 2;
    for (int i = 0; i < 8; ++i) descend({i & 1 ? 0 : -cells, i & 2 ? 0 : -cells, i & 4 ? 0 : -cells}, cells);
    openvdb::tools::signedFloodFill(mGrid->tree());
    return mGrid;
  }

private:
  void descend(const Vec3i& first, int cells) {
    Box box;
    for (int a = 0; a < 3; ++a) {
      box.min[a] = first[a] * mVoxel;
      box.max[a] = (first[a] + cells) * mVoxel;
    }
    const Interval bound = mField.bound(box);
    const double band = 3 * mVoxel;
    if (bound.low > band || bound.high < -band) return;
    if (cells == 8) return sampleLeaf(first);
    const int half = cells / 2;
    for (int i = 0; i < 8; ++i)
      descend({first[0] + (i & 1) * half, first[1] + (i >> 1 & 1) * half, first[2] + (i >> 2 & 1) * half}, half);
  }

  void sampleLeaf(const Vec3i& first) {
    auto* leaf = mGrid->tree().touchLeaf({first[0], first[1], first[2]});
    mPoints.clear();
    for (int i = 0; i < 512; ++i) {
      const auto at = leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(i));
      mPoints.push_back({at[0] * mVoxel, at[1] * mVoxel, at[2] * mVoxel});
    }
    mValues.resize(mPoints.size());
    mField.values(mPoints, mValues);
    for (int i = 0; i < 512; ++i) {
      const double distance = -mValues[static_cast<std::size_t>(i)];
      if (std::abs(distance) < 3 * mVoxel)
        leaf->setValueOn(static_cast<openvdb::Index>(i), static_cast<float>(distance));
      else
        leaf->setValueOff(static_cast<openvdb::Index>(i), static_cast<float>(std::copysign(3 * mVoxel, distance)));
    }
  }

  ShapeField mField;
  const double mVoxel;
  openvdb::FloatGrid::Ptr mGrid;
  std::vector<Vec3d> mPoints;
  std::vector<double> mValues;
};

void OpenVdb(benchmark::State& state) {
  const Shape shape = benchShape(state.range(0));
  const double voxel = 2.0 / static_cast<double>(state.range(1));
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  tbb::task_arena(1).execute([&] {
    for (auto _ : state)
      openvdb::tools::volumeToMesh(*LevelSetSampler(shape, voxel).run(), points, triangles, quads, 0.0, 0.0);
  });
  Mesh mesh;
  for (const auto& p : points) mesh.positions.push_back({p[0], p[1], p[2]});
  for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  report(state, shape, mesh);
}

BENCHMARK(Polygonise)
    ->ArgNames({"shape", "cells"})
    ->ArgsProduct({{0, 1, 2}, {64, 128, 256}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(OpenVdb)
    ->ArgNames({"shape", "cells"})
    ->ArgsProduct({{0, 1, 2}, {64, 128, 256}})
    ->Unit(benchmark::kMillisecond);

} // namespace
} // namespace volcaustic::test
