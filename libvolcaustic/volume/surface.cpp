#include "core/parallel.h"
#include "volcaustic/openvdb.h"
#include "volume/vdb_file.h"

#include <algorithm>
#include <cmath>
#include <openvdb/tools/VolumeToMesh.h>

namespace volcaustic {

namespace {

constexpr const char* kScalarTypes[] = {"Tree_float_5_4_3", "Tree_double_5_4_3", "Tree_int32_5_4_3", "Tree_int64_5_4_3",
                                        "Tree_bool_5_4_3"};

bool isScalar(const std::string& type) {
  return std::find(std::begin(kScalarTypes), std::end(kScalarTypes), type) != std::end(kScalarTypes);
}

/// The one grid that the options name: as asked, else `coverage`, else the first scalar one.
GridSelection surfaceGrid(const std::string& place, const std::string& wanted) {
  return [place, wanted](std::span<const GridName> grids) -> std::vector<std::size_t> {
    const auto named = [&](const std::string& name) {
      return std::find_if(grids.begin(), grids.end(), [&](const GridName& g) { return g.name == name; });
    };
    auto chosen = named(wanted.empty() ? "coverage" : wanted);
    if (chosen == grids.end() && wanted.empty())
      chosen = std::find_if(grids.begin(), grids.end(), [](const GridName& g) { return isScalar(g.type); });
    if (chosen == grids.end())
      throw Error(ErrorKind::Input, place + ": holds " +
                                        (wanted.empty() ? "no scalar grid" : "no grid '" + wanted + "'") +
                                        "; it holds " + listGrids(grids));
    if (!isScalar(chosen->type))
      throw Error(ErrorKind::Input, place + ": grid '" + chosen->name + "' is of type " + chosen->type +
                                        ", which has no iso-surface; it holds " + listGrids(grids));
    return {static_cast<std::size_t>(chosen - grids.begin())};
  };
}

/// One grid type is meshed; the others become it, which keeps the costly template to one instance.
openvdb::FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid) {
  openvdb::FloatGrid::Ptr result;
  using Scalars = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                    openvdb::BoolGrid>;
  grid->apply<Scalars>([&](auto& typed) {
    using GridType = std::decay_t<decltype(typed)>;
    if constexpr (std::is_same_v<GridType, openvdb::FloatGrid>)
      result = typed.copy();
    else {
      result = openvdb::FloatGrid::create(std::make_shared<openvdb::FloatTree>(typed.tree()));
      result->setTransform(typed.transformPtr());
      result->setGridClass(typed.getGridClass());
    }
  });
  return result;
}

bool mirrors(const openvdb::math::Transform& transform) {
  const openvdb::Vec3d o = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
  const openvdb::Vec3d x = transform.indexToWorld(openvdb::Vec3d(1, 0, 0)) - o,
                       y = transform.indexToWorld(openvdb::Vec3d(0, 1, 0)) - o,
                       z = transform.indexToWorld(openvdb::Vec3d(0, 0, 1)) - o;
  return x.cross(y).dot(z) < 0;
}

double distance2(const Vec3d& a, const Vec3d& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

/// OpenVDB's polygons are wound clockwise seen from outside.
void addPolygons(Mesh& mesh, const std::vector<openvdb::Vec3I>& triangles, const std::vector<openvdb::Vec4I>& quads,
                 bool flip) {
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;
    if (flip)
      mesh.triangles.push_back({a, b, c});
    else
      mesh.triangles.push_back({a, c, b});
  };
  mesh.triangles.reserve(triangles.size() + 2 * quads.size());
  for (const openvdb::Vec3I& t : triangles) add(t[0], t[1], t[2]);
  for (const openvdb::Vec4I& q : quads) {
    const auto& p = mesh.positions;
    if (distance2(p[q[0]], p[q[2]]) <= distance2(p[q[1]], p[q[3]])) {
      add(q[0], q[1], q[2]);
      add(q[0], q[2], q[3]);
    } else {
      add(q[1], q[2], q[3]);
      add(q[1], q[3], q[0]);
    }
  }
}

Mesh surfaceOf(const openvdb::FloatGrid& grid, double isovalue, double adaptivity) {
  // Meshed in index space: single precision in world space would lose small grids far from the origin.
  const auto indexGrid = grid.copyReplacingTransform(openvdb::math::Transform::createLinearTransform(1.0));
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*indexGrid, points, triangles, quads, isovalue, adaptivity);
  Mesh mesh;
  mesh.positions.reserve(points.size());
  for (const openvdb::Vec3s& point : points) {
    const openvdb::Vec3d world = grid.indexToWorld(openvdb::Vec3d(point));
    mesh.positions.push_back({world[0], world[1], world[2]});
  }
  addPolygons(mesh, triangles, quads, mirrors(grid.transform()));
  return mesh;
}

void requireAdaptivity(double adaptivity) {
  if (!(adaptivity >= 0 && adaptivity <= 1))
    throw Error(ErrorKind::Usage, "adaptivity: " + std::to_string(adaptivity) + " is not in 0 to 1");
}

} // namespace

Mesh surfaceFromVdb(const std::filesystem::path& path, const SurfaceOptions& options, const RunContext& ctx) {
  requireAdaptivity(options.adaptivity);
  const std::string place = path.string();
  const VdbFile file = readVdbFile(path, ctx, surfaceGrid(place, options.grid));
  const auto grid = asFloatGrid(file.grids.at(0));
  const double automatic = grid->getGridClass() == openvdb::GRID_LEVEL_SET ? 0.0 : 0.5;
  const double isovalue = options.automaticIsovalue ? automatic : options.isovalue;
  if (!std::isfinite(isovalue)) throw Error(ErrorKind::Usage, "isovalue: is not finite");
  Mesh mesh;
  withThreads(ctx, [&] { mesh = surfaceOf(*grid, isovalue, options.adaptivity); });
  if (mesh.empty())
    throw Error(ErrorKind::Input, place + ": grid '" + file.grids[0]->getName() + "' has no surface at the value " +
                                      std::to_string(isovalue) + "; choose another isovalue");
  return mesh;
}

Mesh surfaceFromMedium(const Medium& medium, double isovalue, double adaptivity) {
  requireAdaptivity(adaptivity);
  return surfaceOf(*medium.grids().coverage, isovalue, adaptivity);
}

} // namespace volcaustic
