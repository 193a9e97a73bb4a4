#include "volume/radiance_archive.h"

#include <type_traits>

namespace volcaustic {

namespace {

static_assert(std::is_trivially_copyable_v<kernels::Lamp> && std::is_trivially_copyable_v<kernels::FluenceVoxel>);

/// Bricks in their order, each with its voxels: which slots they have depends on the threads that made them.
void writeGrid(ByteWriter& out, const FluenceGrid& grid) {
  const kernels::FluenceField field = grid.view();
  std::int64_t stored = 0, lit = 0;
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    stored += field.entries[b] > 0;
    lit += field.entries[b] != 0;
  }
  out(grid.dims());
  out(lit);
  out(stored);
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const std::int32_t entry = field.entries[b];
    if (entry == 0) continue;
    out(b);
    out(entry > 0);
    if (entry > 0)
      out.raw(field.voxels + std::size_t(entry - 1) * kBrickVoxels, kBrickVoxels * sizeof(kernels::FluenceVoxel));
    else
      out(field.constants[~entry]);
  }
}

void readGrid(ByteReader& in, FluenceGrid& grid, const RunContext& ctx) {
  if (in.get<Vec3i>() != grid.dims()) throw std::out_of_range("dims");
  const auto lit = in.get<std::int64_t>(), stored = in.get<std::int64_t>();
  grid.reserve(stored, ctx);
  for (std::int64_t i = 0; i < lit; ++i) {
    const auto b = in.get<std::int64_t>();
    if (b < 0 || b >= grid.brickCount()) throw std::out_of_range("brick");
    if (in.get<bool>()) {
      const std::int32_t slot = grid.claim(1);
      in.raw(grid.slot(slot).data(), kBrickVoxels * sizeof(kernels::FluenceVoxel));
      grid.assign(b, slot);
    } else {
      grid.setPacked(b, in.get<kernels::FluenceVoxel>());
    }
  }
}

} // namespace

void writeBytes(ByteWriter& out, const RadianceBricks& light) {
  out(light.direct.lamps);
  out(light.direct.setBegins);
  out(light.direct.setLamps);
  std::vector<std::pair<std::int64_t, std::int32_t>> sets;
  light.direct.sets.forEachNonZero(0, light.direct.sets.size(), [&](std::size_t brick) {
    sets.emplace_back(static_cast<std::int64_t>(brick), light.direct.sets[brick]);
  });
  out(static_cast<std::uint64_t>(light.direct.sets.size()));
  out(static_cast<std::uint64_t>(sets.size()));
  for (const auto& [brick, set] : sets) {
    out(brick);
    out(set);
  }
  writeGrid(out, light.direct.stored);
  writeGrid(out, light.caustic);
}

void readBytes(ByteReader& in, RadianceBricks& light, const RunContext& ctx) {
  in(light.direct.lamps);
  in(light.direct.setBegins);
  in(light.direct.setLamps);
  const auto bricks = in.get<std::uint64_t>(), sets = in.get<std::uint64_t>();
  ctx.requireMemory(bricks * sizeof(std::int32_t), "light volume");
  light.direct.sets = ZeroedTable<std::int32_t>(bricks);
  for (std::uint64_t i = 0; i < sets; ++i) {
    const auto brick = in.get<std::int64_t>();
    if (brick < 0 || static_cast<std::uint64_t>(brick) >= bricks) throw std::out_of_range("brick");
    light.direct.sets[static_cast<std::size_t>(brick)] = in.get<std::int32_t>();
  }
  readGrid(in, light.direct.stored, ctx);
  readGrid(in, light.caustic, ctx);
}

} // namespace volcaustic
