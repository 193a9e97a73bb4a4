#include "core/parallel.h"
#include "volume/radiance_bricks.h"

#include <algorithm>
#include <map>

namespace volcaustic {

namespace {

using kernels::Int3;
using kernels::Light;
using Lights = std::span<const RadianceBricks* const>;

constexpr std::int64_t kGrain = 32; // bricks

/// Fills `sum` with the sums of valueOf(light, voxel) over the lights: one value where isConstant(brick), nothing where
/// isDark(brick).
template <class IsDark, class IsConstant, class ValueOf>
void addUp(FluenceGrid& sum, Lights lights, const RunContext& ctx, const IsDark& isDark, const IsConstant& isConstant,
           const ValueOf& valueOf) {
  const auto at = [&](std::int64_t brick, int k) {
    const Vec3i c = sum.brickCoord(brick);
    const Int3 voxel(8 * c[0] + (k >> 6), 8 * c[1] + (k >> 3 & 7), 8 * c[2] + (k & 7));
    Light all;
    for (std::size_t i = 0; i < lights.size(); ++i) all += valueOf(i, voxel);
    return all;
  };
  std::vector<std::int64_t> varying;
  for (std::int64_t b = 0; b < sum.brickCount(); ++b) {
    if (isDark(b)) continue;
    if (isConstant(b))
      sum.setConstant(b, at(b, 0));
    else
      varying.push_back(b);
  }
  sum.reserve(static_cast<std::int64_t>(varying.size()), ctx);
  const std::int32_t first = sum.claim(static_cast<std::int32_t>(varying.size()));
  parallelFor(static_cast<std::int64_t>(varying.size()), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto slot = first + static_cast<std::int32_t>(i);
      const auto voxels = sum.slot(slot);
      for (int k = 0; k < kBrickVoxels; ++k) voxels[k] = kernels::pack(at(varying[i], k));
      sum.assign(varying[i], slot);
    }
  });
}

/// All lamps, and for each brick the set of those that light it.
void uniteLamps(DirectLight& sum, Lights lights) {
  std::vector<std::int32_t> firstLamp;
  for (const RadianceBricks* light : lights) {
    firstLamp.push_back(static_cast<std::int32_t>(sum.lamps.size()));
    sum.lamps.insert(sum.lamps.end(), light->direct.lamps.begin(), light->direct.lamps.end());
  }
  sum.setBegins = {0};
  std::map<std::vector<std::int32_t>, std::int32_t> known; // by the lights' own numbers of sets
  const auto numberOf = [&](const std::vector<std::int32_t>& sets) {
    const auto [found, isNew] = known.try_emplace(sets, static_cast<std::int32_t>(known.size()));
    if (!isNew) return found->second;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const DirectLight& direct = lights[i]->direct;
      for (std::int32_t l = direct.setBegins[sets[i]]; l < direct.setBegins[sets[i] + 1]; ++l)
        sum.setLamps.push_back(firstLamp[i] + direct.setLamps[l]);
    }
    sum.setBegins.push_back(static_cast<std::int32_t>(sum.setLamps.size()));
    return found->second;
  };
  std::vector<std::int32_t> sets(lights.size(), 0);
  numberOf(sets); // all lamps come first
  for (std::int64_t b = 0; b < sum.stored.brickCount(); ++b) {
    for (std::size_t i = 0; i < lights.size(); ++i) sets[i] = lights[i]->direct.sets[b];
    if (const std::int32_t number = numberOf(sets)) sum.sets[b] = number;
  }
}

} // namespace

std::shared_ptr<const RadianceBricks> sumOf(Lights lights, const RunContext& ctx) {
  auto sum = std::make_shared<RadianceBricks>(lights.front()->caustic.dims());
  const auto all = [&](const auto& holds) {
    return [&lights, holds](std::int64_t b) {
      return std::all_of(lights.begin(), lights.end(), [&](const RadianceBricks* light) { return holds(*light, b); });
    };
  };
  addUp(sum->caustic, lights, ctx, all([](const RadianceBricks& l, std::int64_t b) { return l.caustic.isDark(b); }),
        all([](const RadianceBricks& l, std::int64_t b) { return l.caustic.isConstant(b); }),
        [&](std::size_t i, const Int3& voxel) { return lights[i]->caustic.view().at(voxel); });
  uniteLamps(sum->direct, lights);
  // Bricks that any light has voxels for.
  addUp(sum->direct.stored, lights, ctx,
        all([](const RadianceBricks& l, std::int64_t b) { return l.direct.stored.isDark(b); }),
        all([](const RadianceBricks& l, std::int64_t b) { return l.direct.isConstant(b); }),
        [&](std::size_t i, const Int3& voxel) { return lights[i]->direct.view().at(voxel); });
  return sum;
}

} // namespace volcaustic
