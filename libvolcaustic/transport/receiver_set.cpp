#include "transport/receiver_set.h"

#include "transport/emission.h"
#include "transport/receiver_atlas.h"
#include "transport/receiver_tree.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace volcaustic {

namespace {

using kernels::Double3;
using kernels::Float3;
using kernels::ReceiverTriangle;

std::string placeOf(const Receiver& receiver, std::size_t number) {
  return "receivers[" + std::to_string(number) + "]" + (receiver.name.empty() ? "" : " (" + receiver.name + ")");
}

Mesh unitSquare() {
  return {{{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}}, {{0, 1, 2}, {0, 2, 3}}, {}, {}};
}

void check(const Receiver& receiver, const std::string& place) {
  if (receiver.resolution < 1 || receiver.resolution > kMostReceiverTexels)
    throw Error(ErrorKind::Usage, place + ": resolution must be in 1 to " + std::to_string(kMostReceiverTexels));
  for (const double c : receiver.albedo)
    if (!(c >= 0 && c <= 1)) throw Error(ErrorKind::Usage, place + ": albedo must be in 0 to 1");
  for (const auto& row : receiver.placement)
    for (const double c : row)
      if (!std::isfinite(c)) throw Error(ErrorKind::Usage, place + ": its placement is not finite");
  if (!receiver.mesh) return;
  if (receiver.mesh->empty()) throw Error(ErrorKind::Input, place + ": its mesh has no triangle");
  for (const auto& triangle : receiver.mesh->triangles)
    for (const std::uint32_t corner : triangle)
      if (corner >= receiver.mesh->positions.size())
        throw Error(ErrorKind::Input, place + ": a triangle of its mesh names a vertex that is not there");
}

/// World space.
Mesh surfaceOf(const Receiver& receiver, const std::string& place, const Domain& domain) {
  constexpr double kFarthest = 1e7; // voxels; single precision is good to a voxel there
  Mesh mesh = transformed(receiver.mesh ? *receiver.mesh : unitSquare(), receiver.placement);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) {
      const Double3 p = toGrid(domain, mesh.positions[corner]);
      if (!(std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest && std::abs(p.z) <= kFarthest))
        throw Error(ErrorKind::Input, place + ": it reaches more than ten million voxels from the volume, or is not "
                                              "finite; make it smaller or the voxels larger");
    }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (planeOf(mesh, t).area > 0) return mesh;
  throw Error(ErrorKind::Input, place + ": it has no area; check its scale");
}

std::vector<std::array<std::array<float, 2>, 3>> textureCoordinates(const ReceiverAtlas& atlas) {
  std::vector<std::array<std::array<float, 2>, 3>> all(atlas.texels.size());
  for (std::size_t t = 0; t < all.size(); ++t)
    for (int i = 0; i < 3; ++i)
      all[t][i] = {static_cast<float>(atlas.texels[t][i].column / atlas.columns),
                   static_cast<float>(1 - atlas.texels[t][i].row / atlas.rows)};
  return all;
}

} // namespace

ReceiverSet::ReceiverSet(std::span<const Receiver> receivers, const Domain& domain, const RunContext& ctx) {
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const std::string place = placeOf(receivers[i], i);
    check(receivers[i], place);
    addReceiver(receivers[i], place, domain, ctx);
  }
  const ReceiverTree tree = receiverTree(mTriangles);
  mNodes = tree.nodes;
  const auto inOrder = [&](auto& of) {
    std::remove_reference_t<decltype(of)> sorted(of.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = of[tree.order[i]];
    of = std::move(sorted);
  };
  inOrder(mTriangles);
  inOrder(mChartOf);
  measureTexels(domain.voxelSize, ctx);
}

void ReceiverSet::addReceiver(const Receiver& receiver, const std::string& place, const Domain& domain,
                              const RunContext& ctx) {
  Mesh mesh = surfaceOf(receiver, place, domain);
  const ReceiverAtlas atlas =
      receiver.mesh ? meshAtlas(mesh, receiver.resolution, place, ctx) : rectangleAtlas(mesh, receiver.resolution);
  const auto number = static_cast<std::int32_t>(mSurfaces.size());
  const std::int64_t first = texelCount(), texels = std::int64_t{atlas.columns} * atlas.rows;
  if (3 * (first + texels) > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorKind::Input, place + ": more than 700 million texels in all; lower a resolution");
  constexpr std::uint64_t kTexelBytes = sizeof(Texel) + 15 * sizeof(float) + 3 * sizeof(std::int64_t);
  ctx.requireMemory(static_cast<std::uint64_t>(first + texels) * kTexelBytes, place + ".resolution");

  mSurfaces.push_back({static_cast<std::int32_t>(first), atlas.columns, atlas.rows, receiver.visible ? 1 : 0,
                       Float3(Double3(receiver.albedo[0], receiver.albedo[1], receiver.albedo[2]))});
  const auto firstChart = static_cast<std::int32_t>(mCharts.size());
  for (const TexelRange& r : atlas.charts) mCharts.push_back({number, r});
  mTexels.resize(static_cast<std::size_t>(first + texels), Texel{});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TrianglePlane plane = planeOf(mesh, t);
    if (atlas.chartOf[t] < 0 || !(plane.area > 0)) continue;
    ReceiverTriangle triangle;
    for (int i = 0; i < 3; ++i) {
      triangle.corner[i] = Float3(toGrid(domain, mesh.positions[mesh.triangles[t][i]]));
      triangle.texel[i][0] = static_cast<float>(atlas.texels[t][i].column);
      triangle.texel[i][1] = static_cast<float>(atlas.texels[t][i].row);
    }
    triangle.normal = Float3(plane.normal);
    triangle.receiver = number;
    mTriangles.push_back(triangle);
    mChartOf.push_back(firstChart + atlas.chartOf[t]);
  }
  mEmptyMaps.push_back({receiver.name, {}, std::move(mesh), receiver.mesh != nullptr, textureCoordinates(atlas)});
}

/// Exact areas of the triangles in texels, in bands of rows. What single precision cannot tell from a point lies in
/// one.
void ReceiverSet::measureTexels(double voxelSize, const RunContext& ctx) {
  constexpr std::int32_t kBand = 64;
  constexpr double kPoint = 1e-6;                // texels squared
  std::vector<float> most(mTexels.size(), 0.0f); // cover by Texel::triangle
  TexelCover cover;
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(mTriangles.size()); ++k) {
    if (k % 1024 == 0) ctx.throwIfCancelled();
    const ReceiverTriangle& t = mTriangles[k];
    const MapTriangle map = mapTriangle(t);
    const Double3 a(t.corner[0]), n = cross(Double3(t.corner[1]) - a, Double3(t.corner[2]) - a);
    const double onMap = std::max(0.5 * std::abs(doubleArea(map)), kPoint),
                 worldPerTexel = 0.5 * length(n) / onMap * voxelSize * voxelSize;
    const TexelRange all = texelsOf(map, mCharts[mChartOf[k]].texels);
    for (std::int32_t row = all.row; row < all.row + all.rows; row += kBand) {
      cover.begin({all.column, row, all.columns, std::min(kBand, all.row + all.rows - row)});
      if (onMap > kPoint)
        cover.add(map, 1);
      else if (row == all.row)
        cover.addAt(map[0], kPoint);
      cover.take([&](std::int32_t c, std::int32_t r, double area) {
        if (area < kLeastCover * std::min(onMap, 1.0)) return;
        const std::int64_t at = texelAt(t.receiver, c, r);
        Texel& texel = mTexels[at];
        texel.area += static_cast<float>(area * worldPerTexel);
        texel.cover = std::min(texel.cover + static_cast<float>(area), 1.0f);
        if (static_cast<float>(area) > most[at]) {
          most[at] = static_cast<float>(area);
          texel.triangle = k;
        }
      });
    }
  }
}

MapTriangle mapTriangle(const ReceiverTriangle& t) {
  return {{{t.texel[0][0], t.texel[0][1]}, {t.texel[1][0], t.texel[1][1]}, {t.texel[2][0], t.texel[2][1]}}};
}

kernels::ReceiverScene ReceiverSet::scene(const float* irradiance) const {
  kernels::ReceiverScene s;
  s.nodes = mNodes.data();
  s.triangles = mTriangles.data();
  s.surfaces = mSurfaces.data();
  s.irradiance = irradiance;
  s.nodeCount = static_cast<std::int32_t>(mNodes.size());
  s.triangleCount = static_cast<std::int32_t>(mTriangles.size());
  s.surfaceCount = static_cast<std::int32_t>(mSurfaces.size());
  s.texelCount = texelCount();
  return s;
}

bool ReceiverSet::isFlat(std::int32_t receiver) const { return !mEmptyMaps[receiver].isMesh; }

std::vector<ReceiverMap> ReceiverSet::maps(std::span<const float> caustic, std::span<const float> direct) const {
  std::vector<ReceiverMap> maps = mEmptyMaps;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const kernels::ReceiverSurface& s = mSurfaces[i];
    Image& image = maps[i].image;
    image.width = s.columns;
    image.height = s.rows;
    for (const std::string prefix : {"", "caustic.", "direct."})
      for (const char* channel : {"R", "G", "B"}) image.add(prefix + channel);
    const auto texels = static_cast<std::size_t>(s.columns) * s.rows, first = std::size_t(s.firstTexel);
    for (std::size_t t = 0; t < texels; ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const float refracted = caustic[3 * (first + t) + c], straight = direct[3 * (first + t) + c];
        image.planes[c][t] = refracted + straight;
        image.planes[3 + c][t] = refracted;
        image.planes[6 + c][t] = straight;
      }
    image.metadata["unit"] = "W/m2";
  }
  return maps;
}

} // namespace volcaustic
