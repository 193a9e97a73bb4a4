#include "volcaustic/medium.h"

#include "core/parallel.h"
#include "volcaustic/error.h"
#include "volcaustic/openvdb.h"
#include "volume/brick_collector.h"
#include "volume/device_medium.h"
#include "volume/lattice.h"
#include "volume/medium_store.h"
#include "volume/optics.h"
#include "volume/vdb_file.h"
#include "volume/volume_optics.h"
#include "volume/voxelise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>

namespace volcaustic {

namespace {

constexpr int kMaxDims = 1 << 15;
/// The same bound as for a mesh's vertices.
constexpr double kAbsurdCoordinate = 1e15;

bool finite(const Rgb& c) { return std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]); }

void requireDomain(const Domain& domain) {
  const auto [low, high] = std::minmax({domain.dims[0], domain.dims[1], domain.dims[2]});
  if (low < 1 || high > kMaxDims)
    throw Error(ErrorKind::Usage, "domain: needs 1 to 32768 voxels along each axis, got " +
                                      std::to_string(domain.dims[0]) + " x " + std::to_string(domain.dims[1]) + " x " +
                                      std::to_string(domain.dims[2]));
  if (!(domain.voxelSize > 0) || !std::isfinite(domain.voxelSize) || !finite(domain.minCorner))
    throw Error(ErrorKind::Usage, "domain: the voxel size must be positive and the corner finite");
  if (domain.voxelSize < kSmallestVoxel)
    throw Error(ErrorKind::Usage, "domain: voxels under 1.45e-5 world units cannot be in a transform of OpenVDB; take "
                                  "larger voxels, or scale the mesh to a smaller unit");
}

void requireOptions(const VoxeliseOptions& o) {
  const auto oneOf = [](int value, std::initializer_list<int> choices) {
    return std::find(choices.begin(), choices.end(), value) != choices.end();
  };
  if (!oneOf(o.supersample, {1, 2, 4, 8}))
    throw Error(ErrorKind::Usage, "supersample: " + std::to_string(o.supersample) + " is not one of 1, 2, 4, 8");
  if (!oneOf(o.blur, {1, 3, 5, 7, 9, 11}))
    throw Error(ErrorKind::Usage, "blur: " + std::to_string(o.blur) + " is not one of 1, 3, 5, 7, 9, 11");
}

template <class Optics> // Material or Ambient
void requireOptics(const Optics& m, const std::string& place) {
  if (!(m.index > 0) || !std::isfinite(m.index))
    throw Error(ErrorKind::Usage, place + ": the refractive index must be positive and finite");
  if (!finite(m.attenuation) || !finite(m.scattering) || !std::isfinite(m.asymmetry))
    throw Error(ErrorKind::Usage, place + ": attenuation, scattering and asymmetry must be finite");
}

} // namespace

openvdb::math::Transform::Ptr domainTransform(const Domain& domain) {
  auto transform = openvdb::math::Transform::createLinearTransform(domain.voxelSize);
  const double half = 0.5 * domain.voxelSize;
  transform->postTranslate({domain.minCorner[0] + half, domain.minCorner[1] + half, domain.minCorner[2] + half});
  return transform;
}

Domain domainAround(const Box& world, int resolution, double voxelSize, int padding) {
  double longest = 0;
  for (int a = 0; a < 3; ++a) {
    const double side = world.max[a] - world.min[a];
    if (!std::isfinite(world.min[a]) || !std::isfinite(world.max[a]) || side < 0)
      throw Error(ErrorKind::Usage, "domain: the box is empty or not finite");
    if (std::max(std::abs(world.min[a]), std::abs(world.max[a])) > kAbsurdCoordinate)
      throw Error(ErrorKind::Input, "domain: the box reaches beyond 1e15; check the mesh and its units");
    longest = std::max(longest, side);
  }
  if (longest == 0) throw Error(ErrorKind::Usage, "domain: the box is a single point");
  if (padding < 0 || padding > kMaxDims)
    throw Error(ErrorKind::Usage, "padding: " + std::to_string(padding) + " is not in 0 to 32768 voxels");
  const bool sized = voxelSize != 0;
  if (sized ? !(voxelSize > 0 && std::isfinite(voxelSize)) : resolution < 1)
    throw Error(ErrorKind::Usage, "domain: needs a positive voxel size, or a resolution of at least 1");

  Domain domain;
  domain.voxelSize = sized ? voxelSize : longest / resolution;
  for (int a = 0; a < 3; ++a) {
    // A side of a whole number of voxels must not become one more by rounding.
    constexpr double kRounding = 1 - 1e-12;
    const double side = world.max[a] - world.min[a];
    const double voxels = std::max(std::ceil(side / domain.voxelSize * kRounding), 1.0) + 2.0 * padding;
    if (!(voxels <= kMaxDims))
      throw Error(ErrorKind::Usage,
                  "domain: more than 32768 voxels along an axis; take a lower resolution or larger voxels");
    domain.dims[a] = static_cast<int>(voxels);
    domain.minCorner[a] = world.min[a] + 0.5 * (side - domain.voxelSize * voxels);
  }
  return domain;
}

Medium buildMedium(std::span<const Body> bodies, const Ambient& ambient, const Domain& domain,
                   const VoxeliseOptions& options, const RunContext& ctx) {
  return buildMedium(bodies, {}, ambient, domain, options, ctx);
}

Medium buildMedium(std::span<const Body> bodies, std::span<const MediumVolume> volumes, const Ambient& ambient,
                   const Domain& domain, const VoxeliseOptions& options, const RunContext& ctx) {
  requireDomain(domain);
  requireOptions(options);
  requireOptics(ambient, "ambient");
  for (const Body& body : bodies) requireOptics(body.material, body.name.empty() ? "material" : body.name);
  initialiseOpenVdb();

  std::vector<Body> order(bodies.begin(), bodies.end()); // from low priority to high
  std::stable_sort(order.begin(), order.end(), [](const Body& a, const Body& b) { return a.priority < b.priority; });
  if (auto bricks = volumes.empty() ? mediumOnDevice(order, ambient, domain, options, ctx) : nullptr)
    return Medium(domain, ambient, std::make_shared<MediumStore>(std::move(bricks), domain, ambient, ctx));

  OpticsBricks optics = ambientOptics(domain, ambient, order, ctx);
  addVolumes(optics, volumes, ambient, domain, ctx);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const RunContext share = shareOf(ctx, i, order.size());
    const CoveragePatch patch = voxeliseBody(order[i], domain, options.supersample, options.fill, share);
    paintBody(optics, patch, order[i].material, share);
    share.progress("blend", 1);
  }
  collapseUniform(optics, ctx);
  optics.index = gaussianBlur(optics.index, options.blur, ctx);
  return Medium(domain, ambient, std::make_shared<MediumStore>(std::move(optics), domain, ambient, ctx));
}

Medium sampleMedium(const Domain& domain, const Ambient& ambient,
                    const std::function<double(const Vec3d& pWorld)>& index, const RunContext& ctx) {
  requireDomain(domain);
  requireOptics(ambient, "ambient");
  initialiseOpenVdb();
  const std::string what = "sampling the index";
  ctx.requireMemory(static_cast<std::uint64_t>(domain.voxelCount()) / kBrickVoxels * 8, what);
  OpticsBricks optics;
  optics.index = BrickGrid<float>(domain.dims, static_cast<float>(ambient.index));
  optics.coverage = BrickGrid<float>(domain.dims, 0.0f);
  BrickCollector<float> varying(ctx);

  const auto sample = [&](int x, int y, int z) {
    const Vec3i at{std::min(x, domain.dims[0] - 1), std::min(y, domain.dims[1] - 1), std::min(z, domain.dims[2] - 1)};
    Vec3d p{};
    for (int a = 0; a < 3; ++a) p[a] = domain.minCorner[a] + domain.voxelSize * (at[a] + 0.5);
    const double n = index(p);
    if (n > 0 && std::isfinite(n)) return static_cast<float>(n);
    std::ostringstream text;
    text << "index function: returned " << n << " at (" << p[0] << ", " << p[1] << ", " << p[2]
         << "); an index must be positive and finite";
    throw Error(ErrorKind::Input, text.str());
  };
  parallelFor(
      optics.index.brickCount(), 16, ctx,
      [&](std::int64_t begin, std::int64_t end, int slot) {
        std::array<float, kBrickVoxels> values{};
        for (std::int64_t b = begin; b < end; ++b) {
          const Vec3i brick = optics.index.brickCoord(b);
          for (int v = 0; v < kBrickVoxels; ++v)
            values[v] = sample(brick[0] * 8 + (v >> 6), brick[1] * 8 + (v >> 3 & 7), brick[2] * 8 + (v & 7));
          if (std::all_of(values.begin(), values.end(), [&](float v) { return v == values[0]; }))
            optics.index.setConstant(b, values[0]);
          else
            std::copy(values.begin(), values.end(), varying.add(slot, b).begin());
        }
      },
      "sample");
  varying.moveInto(optics.index, what, ctx);
  return Medium(domain, ambient, std::make_shared<MediumStore>(std::move(optics), domain, ambient, ctx));
}

Medium mediumFromGrids(const Domain& domain, const Ambient& ambient, MediumGrids grids) {
  requireDomain(domain);
  initialiseOpenVdb();
  if (!grids.index) throw Error(ErrorKind::Input, "index: the grid is missing; a medium needs it");
  const auto transform = domainTransform(domain);
  const auto requireSame = [&](const auto& grid, const char* name) {
    if (grid && grid->transform() != *transform)
      throw Error(ErrorKind::Input, std::string(name) + ": the grid's transform is not the domain's");
  };
  requireSame(grids.index, "index");
  requireSame(grids.attenuation, "attenuation");
  requireSame(grids.scattering, "scattering");
  requireSame(grids.coverage, "coverage");
  requireSame(grids.asymmetry, "asymmetry");
  if (!grids.attenuation) grids.attenuation = constantVec3(domain, ambient.attenuation, "attenuation");
  if (!grids.scattering) grids.scattering = constantVec3(domain, ambient.scattering, "scattering");
  if (!grids.coverage) grids.coverage = constantFloat(domain, 0, "coverage");
  return Medium(domain, ambient, std::make_shared<MediumStore>(std::move(grids)));
}

} // namespace volcaustic
