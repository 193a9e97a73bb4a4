#include "backends/view_tables.h"

#include "core/parallel.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <limits>

namespace volcaustic {

namespace {

using kernels::FluenceField;
using kernels::Int3;

constexpr std::uint8_t kBusy = 1, kScatters = 2, kForeign = 4; ///< other optics than the ambient medium's
/// Whole bricks are crossed in one step where every point lamp is farther than this from their centres, in voxels: the
/// relative error of Gauss's two points for 1/r^2 is (chord/r)^4/36, and where they are thinner than this: for
/// exp(-depth) it is depth^4/4320.
constexpr float kFarLamp = 64, kThinBrick = 0.5f;
constexpr float kLongestChord = 13.9f; ///< of a brick, in voxels
constexpr std::int64_t kGrain = 4096;  ///< bricks that are looked at together

/// Whether a spot's light falls off in a brick that is far away, or an area light's plane goes through it.
bool crossesEdge(const kernels::Cone& cone, const kernels::Float3& way, float distance) {
  if (cone.isSphere()) return false;
  const float ramp = dot(cone.axis, way) / distance * cone.scale + cone.offset,
              around = 0.5f * kLongestChord / distance * cone.scale;
  return ramp + around > 0 && ramp - around < (cone.flat ? 0 : 1);
}

CornerVoxels cornerVoxels(const Int3& last) {
  CornerVoxels c{};
  int k = 0;
  for (int x = 0; x < kernels::kFieldEdge; ++x)
    for (int y = 0; y < kernels::kFieldEdge; ++y)
      for (int z = 0; z < kernels::kFieldEdge; ++z, ++k) {
        const Int3 v(std::min(x, last.x), std::min(y, last.y), std::min(z, last.z));
        c.brick[k] = (v.x >> 3) << 2 | (v.y >> 3) << 1 | v.z >> 3;
        c.offset[k] = kernels::FlatMedium::voxelOffset(v);
      }
  return c;
}

} // namespace

ViewTables::ViewTables(const kernels::FlatMedium& medium, const FluenceField& caustic,
                       const kernels::DirectField& direct, const LaneSet& lanes, const RunContext& ctx)
    : mMedium(medium), mCaustic(caustic), mDirect(direct) {
  for (std::int64_t i = 0; i < medium.opticsCount; ++i) mDirected |= medium.optics[i].asymmetry != 0;
  const auto bricks = static_cast<std::size_t>(medium.brickCount());
  mKinds = ZeroedTable<std::uint8_t>(bricks);
  mBricks = ZeroedTable<std::int32_t>(bricks);
  for (auto& entries : mEntries) entries = ZeroedTable<std::int32_t>(bricks);
  for (int edge = 0; edge < 8; ++edge) {
    const auto last = [edge](int bit, int dim) { return edge & bit ? (dim - 1) & 7 : kernels::kFieldEdge - 1; };
    mCorners[edge] = cornerVoxels({last(4, medium.dims.x), last(2, medium.dims.y), last(1, medium.dims.z)});
  }
  findKinds(ctx);
  assignSlots(ctx);
  pack(lanes, ctx);
  fillVoxels(ctx);
  makePlan(ctx);
}

kernels::ViewLight ViewTables::light() const {
  const auto texture = [this](Part part) { return kernels::LightTexture{mEntries[part].data(), mLight.data()}; };
  return {mMedium.dims,
          mMedium.brickDims,
          texture(Caustic),
          texture(Direct),
          mDirected ? texture(Towards) : kernels::LightTexture{},
          mDirect};
}

ViewTables::LampCounts ViewTables::lampCounts() const {
  LampCounts counts;
  for (std::int64_t b = 0; b < brickCount(); ++b)
    if (const std::int32_t entry = mEntries[Direct][b]; entry < 0) counts.sets = std::max(counts.sets, ~entry + 1);
  counts.setLamps = counts.sets > 0 ? mDirect.setBegins[counts.sets] : 0;
  for (std::int32_t i = 0; i < counts.setLamps; ++i) counts.lamps = std::max(counts.lamps, mDirect.setLamps[i] + 1);
  return counts;
}

Int3 ViewTables::coord(std::int64_t brick) const {
  const auto y = static_cast<std::int64_t>(mMedium.brickDims.y), z = static_cast<std::int64_t>(mMedium.brickDims.z);
  return {static_cast<std::int32_t>(brick / (y * z)), static_cast<std::int32_t>(brick / z % y),
          static_cast<std::int32_t>(brick % z)};
}

std::array<std::int64_t, 8> ViewTables::around(std::int64_t brick, int side) const {
  const Int3 c = coord(brick), &dims = mMedium.brickDims;
  const auto step = [side](int at, int dim, std::int64_t stride) {
    return at + side < 0 || at + side >= dim ? 0 : side * stride;
  };
  const std::int64_t x = step(c.x, dims.x, std::int64_t{dims.y} * dims.z), y = step(c.y, dims.y, dims.z),
                     z = step(c.z, dims.z, 1);
  return {brick, brick + z, brick + y, brick + y + z, brick + x, brick + x + z, brick + x + y, brick + x + y + z};
}

const kernels::FluenceVoxel* ViewTables::constantOf(const FluenceField& field,
                                                    const std::array<std::int64_t, 8>& bricks) {
  const kernels::FluenceVoxel* first = nullptr;
  for (const std::int64_t b : bricks) {
    const std::int32_t entry = field.entries[b];
    if (entry >= 0) return nullptr;
    const kernels::FluenceVoxel* v = field.constants + ~entry;
    if (first && !std::equal(std::begin(v->words), std::end(v->words), std::begin(first->words))) return nullptr;
    first = v;
  }
  return first;
}

void ViewTables::findKinds(const RunContext& ctx) {
  const auto scatters = [this](std::int32_t entry) { return maxComponent(mMedium.optics[entry].scattering) > 0; };
  parallelFor(mMedium.brickCount(), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b) {
      const std::int32_t optics = mMedium.opticsSlots[b];
      const bool busy = mMedium.fieldSlots[b] != 0 || optics > 0;
      const std::uint8_t kind =
          (busy ? kBusy : 0) | (optics > 0 || scatters(-optics) ? kScatters : 0) | (optics != 0 ? kForeign : 0);
      if (kind) mKinds[b] = kind;
    }
  });
}

/// A brick of cells has light of its own where something scatters in it or in the voxels that its last cells reach
/// into.
void ViewTables::assignSlots(const RunContext& ctx) {
  for (std::int64_t b = 0; b < mMedium.brickCount(); ++b) {
    const auto above = around(b, 1);
    if (std::any_of(above.begin(), above.end(), [this](std::int64_t a) { return mKinds[a] & kScatters; })) assign(b);
  }
  const std::int64_t voxels = mSlots * kernels::kFieldVoxels;
  ctx.requireMemory(static_cast<std::uint64_t>(voxels) * sizeof(kernels::HalfVoxel), "view: light");
  if (voxels > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorKind::Input, "view: more light than a picture can hold; lower the resolution of the volume");
}

void ViewTables::assign(std::int64_t brick) {
  const auto above = around(brick, 1);
  const auto dark = [&](const FluenceField& field) {
    return std::all_of(above.begin(), above.end(), [&](std::int64_t a) { return field.entries[a] == 0; });
  };
  const std::int32_t set = mDirect.sets[brick];
  const bool oneSet = std::all_of(above.begin(), above.end(), [&](std::int64_t a) { return mDirect.sets[a] == set; });
  const bool noCaustic = dark(mCaustic), lampsOnly = dark(mDirect.stored) && oneSet;
  const auto give = [&](Part part, const FluenceField* field) {
    if (const kernels::FluenceVoxel* constant = field ? constantOf(*field, above) : nullptr) {
      Words words;
      std::copy(std::begin(constant->words), std::end(constant->words), words.begin());
      const auto [known, added] = mConstants.try_emplace({part, words}, brick);
      if (!added) return mSame[part].push_back({brick, known->second});
    }
    mJobs.push_back({brick, static_cast<std::int32_t>(mSlots++), part, lampsOnly});
  };
  if (!noCaustic) give(Caustic, &mCaustic);
  if (!lampsOnly)
    give(Direct, &mDirect.stored);
  else if (mDirect.setBegins[set] != mDirect.setBegins[set + 1])
    mEntries[Direct][brick] = ~set;
  if (mDirected && !(noCaustic && lampsOnly)) give(Towards, nullptr);
}

void ViewTables::pack(const LaneSet& lanes, const RunContext& ctx) {
  mLight.resize(static_cast<std::size_t>(mSlots) * kernels::kFieldVoxels);
  std::fill_n(mLight.begin(), kernels::kFieldVoxels, kernels::HalfVoxel{0, 0, 0, 0});
  parallelFor(static_cast<std::int64_t>(mJobs.size()), 16, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) packOne(mJobs[i], lanes);
  });
  for (int part = 0; part < kParts; ++part)
    for (const auto& [brick, same] : mSame[part]) mEntries[part][brick] = mEntries[part][same];
}

void ViewTables::packOne(const Job& job, const LaneSet& lanes) {
  const auto above = around(job.brick, 1);
  const Int3 c = coord(job.brick);
  const auto isLast = [](int at, int dim, int bit) { return at == dim - 1 ? bit : 0; };
  const Int3& dims = mMedium.brickDims;
  const CornerVoxels& voxels = mCorners[isLast(c.x, dims.x, 4) | isLast(c.y, dims.y, 2) | isLast(c.z, dims.z, 1)];
  CornerLight light;
  for (auto& part : light.of) std::fill(std::begin(part), std::end(part), 0.0f);
  const bool directions = job.part == Towards;
  const auto add = [&](const FluenceField& field) {
    std::int32_t entries[8];
    for (int i = 0; i < 8; ++i) entries[i] = field.entries[above[i]];
    lanes.addCorners(field, entries, voxels, directions, light);
  };
  if (job.part != Direct) add(mCaustic);
  if (job.part == Direct || (directions && !job.lamps)) {
    add(mDirect.stored);
    addLamps(job.brick, directions, lanes, light);
  }
  const std::int32_t unit = lanes.packCorners(light, mLight.data() + std::int64_t{job.slot} * kernels::kFieldVoxels);
  mEntries[job.part][job.brick] = unit == 0 ? 0 : unit | job.slot;
}

/// Adds the lamps' light in the voxels of bricks that have none of their own.
void ViewTables::addLamps(std::int64_t brick, bool directions, const LaneSet& lanes, CornerLight& light) const {
  const auto above = around(brick, 1);
  const Int3 c = coord(brick), low(8 * c.x, 8 * c.y, 8 * c.z);
  alignas(64) float parts[kAroundPadded], sums[8 * kAroundPadded];
  std::array<bool, 8> done{};
  for (int i = 0; i < 8; ++i) {
    const std::int32_t set = mDirect.sets[above[i]];
    if (done[i] || mDirect.stored.entries[above[i]] != 0 || mDirect.setBegins[set] == mDirect.setBegins[set + 1])
      continue;
    std::array<float, 8> part{};
    for (int j = i; j < 8; ++j)
      if (mDirect.stored.entries[above[j]] == 0 && mDirect.sets[above[j]] == set) {
        part[j] = 1;
        done[j] = true;
      }
    const auto bitOf = [](int at, int bit) { return at == 8 ? bit : 0; };
    std::fill(std::begin(parts), std::end(parts), 0.0f);
    std::fill(std::begin(sums), std::end(sums), 0.0f);
    for (int x = 0; x < kernels::kFieldEdge; ++x)
      for (int y = 0; y < kernels::kFieldEdge; ++y)
        for (int z = 0; z < kernels::kFieldEdge; ++z)
          parts[(x * 10 + y) * 10 + z] = part[bitOf(x, 4) | bitOf(y, 2) | bitOf(z, 1)];
    for (std::int32_t l = mDirect.setBegins[set]; l < mDirect.setBegins[set + 1]; ++l)
      lanes.lightAround(mDirect.lamps[mDirect.setLamps[l]], low, mMedium.dims, parts, sums);
    int k = 0;
    for (int x = 0; x < kernels::kFieldEdge; ++x)
      for (int y = 0; y < kernels::kFieldEdge; ++y)
        for (int z = 0; z < kernels::kFieldEdge; ++z, ++k)
          for (int a = 0; a < 3; ++a) light.of[a][k] += sums[8 * ((x * 10 + y) * 10 + z) + 4 * directions + a];
  }
}

void ViewTables::fillVoxels(const RunContext& ctx) {
  for (std::int64_t b = 0; b < mMedium.brickCount(); ++b)
    if (mKinds[b] & kBusy) mBusy.push_back(b);
  const std::size_t voxels = (mBusy.size() + 1) * kernels::kStepVoxels;
  ctx.requireMemory(voxels * sizeof(std::int32_t), "view: plan");
  mPlanVoxels.resize(voxels);
  std::fill_n(mPlanVoxels.begin(), kernels::kStepVoxels, 0); // slot 0, for lanes that do not care
  parallelFor(static_cast<std::int64_t>(mBusy.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int32_t steps = mMedium.stepSlots[mBusy[i]], optics = mMedium.opticsSlots[mBusy[i]];
      const std::uint8_t* step = mMedium.steps + std::int64_t{std::max(steps, 0)} * kernels::kStepVoxels;
      const std::int32_t* entry = mMedium.voxelOptics + std::int64_t{std::max(optics, 0)} * kernels::kStepVoxels;
      std::int32_t* word = mPlanVoxels.data() + (i + 1) * kernels::kStepVoxels;
      for (int k = 0; k < kernels::kStepVoxels; ++k)
        word[k] = (steps < 0 ? ~steps : step[k]) | (optics > 0 ? entry[k] : -optics) << 8;
      mBricks[mBusy[i]] = kernels::kPlanBusy | static_cast<std::int32_t>(i + 1) << kernels::kPlanShift;
    }
  });
}

void ViewTables::makePlan(const RunContext& ctx) {
  parallelFor(mMedium.brickCount(), kGrain, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t b = begin; b < end; ++b)
      if (mKinds[b] && !(mKinds[b] & kBusy)) mBricks[b] = planOf(b);
  });
  mPlan = {mBricks.data(), mPlanVoxels.data(), box()};
}

/// Around the bricks that bend or have optics of their own; the domain where the ambient medium attenuates.
kernels::GridBox ViewTables::box() const {
  const kernels::Float3 dims(mMedium.dims);
  if (maxComponent(mMedium.optics[0].attenuation) > 0) return {kernels::Float3(0), dims};
  Int3 low(mMedium.brickDims), high(0);
  for (std::int64_t b = 0; b < mMedium.brickCount(); ++b) {
    if (!(mKinds[b] & (kBusy | kForeign))) continue;
    const Int3 c = coord(b);
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x + 1), std::max(high.y, c.y + 1), std::max(high.z, c.z + 1)};
  }
  if (high.x == 0) return {}; // nothing anywhere
  // Cells of a brick reach half a voxel beyond it.
  const auto limit = [](int bricks, float dim) { return std::min(8.0f * static_cast<float>(bricks) + 0.5f, dim); };
  return {kernels::Float3(low) * 8.0f, {limit(high.x, dims.x), limit(high.y, dims.y), limit(high.z, dims.z)}};
}

/// Of a brick that is not busy.
std::int32_t ViewTables::planOf(std::int64_t brick) const {
  const std::int32_t optics = -mMedium.opticsSlots[brick], set = mEntries[Direct][brick];
  bool lit = false, fine = false;
  if (mKinds[brick] & kScatters) {
    const float attenuation = maxComponent(mMedium.optics[optics].attenuation);
    fine = attenuation * kLongestChord > kThinBrick || (set < 0 && lampsVary(~set, coord(brick)));
    for (const std::int64_t b : around(brick, -1)) {
      const std::int32_t caustic = mEntries[Caustic][b], direct = mEntries[Direct][b];
      lit |= (caustic | direct) != 0;
      fine |= caustic != 0 || direct != set || direct > 0;
    }
  }
  return (lit ? kernels::kPlanLit : 0) | (lit && fine ? kernels::kPlanFine : 0) | optics << kernels::kPlanShift;
}

bool ViewTables::lampsVary(std::int32_t set, const Int3& brick) const {
  const kernels::Float3 centre = kernels::Float3(brick) * 8.0f + kernels::Float3(4.0f);
  for (std::int32_t l = mDirect.setBegins[set]; l < mDirect.setBegins[set + 1]; ++l) {
    const kernels::Lamp& lamp = mDirect.lamps[mDirect.setLamps[l]];
    if (!lamp.point) continue;
    const kernels::Float3 way = centre - lamp.origin;
    const float distance = kernels::length(way);
    if (distance < kFarLamp || crossesEdge(lamp.cone, way, distance)) return true;
  }
  return false;
}

} // namespace volcaustic
