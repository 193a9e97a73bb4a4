// Every instruction set carries the same photons as the reference, and its sums do not depend on who runs what when.

#include "backends/lanes.h"
#include "support/lights.h"
#include "support/solids.h"
#include "transport/emission.h"
#include "transport/march_rules.h"
#include "transport/reach.h"
#include "volume/flatten.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace volcaustic::test {
namespace {

using kernels::Counter;
using kernels::Outcome;

/// A flat medium with the rasters of a light.
struct Scene {
  Domain domain;
  FlatMediumStorage flat;
  PhotonOptions options;
  std::vector<kernels::EmissionFrame> frames;
  FixedPoint scale;

  Scene(const Medium& medium, const Light& light, const PhotonOptions& photons)
      : domain(medium.domain())
      , flat(flattenMedium(medium, {}, {}))
      , options(photons)
      , frames(emissionFrames(light, 0, domain, photons, 5)) {
    double photon = 0, watts = 0;
    for (const kernels::EmissionFrame& f : frames) {
      const double strongest = kernels::maxComponent(f.strength);
      photon = std::max(photon, strongest * (f.point ? f.du * f.dv : 1));
      watts += strongest * (f.point ? 13 : static_cast<double>(f.cells()));
    }
    // Room for a raster that is traced a hundred times.
    scale = {std::exp2(16 - std::ceil(std::log2(photon))), std::exp2(54 - std::ceil(std::log2(watts)))};
  }
};

/// All sums of a tracer, voxel after voxel of the domain's blocks, z fastest.
struct Sums {
  std::vector<VoxelSums> voxels;
  std::vector<std::pair<std::size_t, VoxelSums>> around; ///< the same voxels as the blocks beside them hold them
  PhotonTally tally;
  std::uint64_t farBytes; ///< of far chords that are kept to the end

  [[nodiscard]] std::int64_t count(Counter c) const { return tally.counts[static_cast<int>(c)]; }
  [[nodiscard]] double watts(Outcome o, int channel) const {
    return static_cast<double>(tally.power[static_cast<int>(o)][channel]);
  }
};

struct Way {
  int threads = 0;
  int rowsAtOnce = 0; ///< 0: the whole raster
  int repeats = 1;    ///< traces of each raster
};

double luminance(const VoxelSums& s) {
  return kernels::luminance(kernels::Double3(double(s[0]), double(s[1]), double(s[2])));
}

double total(const Sums& a) {
  double sum = 0;
  for (const VoxelSums& s : a.voxels) sum += luminance(s);
  return sum;
}

/// Calls visit(x, y, z, whether it is in the block) for the places of a block's sums.
template <class Visit>
void forPlacesInSums(const Visit& visit) {
  const auto within = [](int c) { return c >= 0 && c < kBlockEdge; };
  for (int x = -1; x <= kBlockEdge; ++x)
    for (int y = -1; y <= kBlockEdge; ++y)
      for (int z = -1; z <= kBlockEdge; ++z) visit(x, y, z, within(x) && within(y) && within(z));
}

Sums run(const Scene& scene, std::string_view lanes, const Way& way = {}) {
  RunContext ctx;
  ctx.threads = way.threads;
  const PhotonOptions& o = scene.options;
  const kernels::PhotonRules rules{marchRules(o), o.maxSteps, static_cast<float>(o.cutoff), o.roulette, 5,
                                   o.fresnel,     {}};
  const auto tracer = makeCpuTracer({scene.flat.view(), rules, scene.scale}, ctx, lanes);
  for (const kernels::EmissionFrame& frame : scene.frames) {
    const ReachMap reach = reachOf(scene.flat, frame);
    std::vector<float> entry(frame.cells());
    tracer->emit(frame, reach.view(), {0, frame.rows}, entry.data());
    const int rows = way.rowsAtOnce > 0 ? way.rowsAtOnce : frame.rows;
    for (int i = 0; i < way.repeats; ++i)
      for (int row = 0; row < frame.rows; row += rows)
        tracer->trace(frame, {row, std::min(row + rows, frame.rows)}, entry.data());
  }
  const std::uint64_t before = tracer->peakBytes();
  tracer->finish();

  Sums all;
  all.farBytes = tracer->peakBytes() - before;
  double outside = 0;
  BlockSums block;
  const kernels::Int3 blocks = blockDims(scene.flat.dims);
  const kernels::Int3 voxels(blocks.x * kBlockEdge, blocks.y * kBlockEdge, blocks.z * kBlockEdge);
  all.voxels.resize(std::size_t(voxels.x) * voxels.y * voxels.z);
  for (std::int64_t b = 0; b < std::int64_t{blocks.x} * blocks.y * blocks.z; ++b) {
    block.clear();
    tracer->addBlock(b, block);
    const kernels::Int3 corner = blockCorner(blocks, b);
    bool light = false;
    forPlacesInSums([&](int x, int y, int z, bool within) {
      const VoxelSums sums = block.at(sumsOffset(x, y, z));
      light = light || sums != VoxelSums{};
      const auto inside = [](int c, int count) { return c >= 0 && c < count; };
      x += corner.x, y += corner.y, z += corner.z;
      if (!inside(x, voxels.x) || !inside(y, voxels.y) || !inside(z, voxels.z)) {
        outside += luminance(sums);
        return;
      }
      const std::size_t number = (std::size_t(x) * voxels.y + y) * voxels.z + z;
      if (within)
        all.voxels[number] = sums;
      else
        all.around.emplace_back(number, sums);
    });
    EXPECT_LE(light, tracer->touched(b)) << "block " << b;
  }
  EXPECT_LE(outside, 1e-6 * total(all)) << "nothing but rounding is beyond the domain's blocks";
  all.tally = tracer->tally();
  return all;
}

/// Sum of absolute differences of voxels over the sum of the reference: of light, and of its direction.
std::array<double, 2> difference(const Sums& a, const Sums& reference) {
  double light = 0, direction = 0, all = 0;
  for (std::size_t i = 0; i < reference.voxels.size(); ++i) {
    const VoxelSums &s = a.voxels[i], &r = reference.voxels[i];
    light += std::abs(luminance(s) - luminance(r));
    for (int c = 3; c < 6; ++c) direction += std::abs(double(s[c] - r[c]));
    all += luminance(r);
  }
  return {light / all, direction / all};
}

/// A ball lens whose index varies everywhere inside it, in a box that no brick or block divides.
Medium luneburg(const Ambient& ambient = {}) {
  const Domain domain{{0, 0, 0}, 1, {37, 50, 61}};
  return sampleMedium(domain, ambient, [](const Vec3d& p) {
    const double r = std::hypot(p[0] - 18, p[1] - 24, p[2] - 33) / 15;
    return r < 1 ? std::sqrt(2 - r * r) : 1.0;
  });
}

/// Glass in a long box: kinks, then straight ways through several blocks.
Medium glass(const Vec3i& dims, const Rgb& attenuation = {0, 0, 0}, const Rgb& scattering = {0, 0, 0},
             double index = 1.3) {
  Body body;
  body.mesh = ball({dims[0] * .5, dims[1] * .5, dims[2] - 14.0}, 8);
  body.material.index = index;
  body.material.attenuation = attenuation;
  body.material.scattering = scattering;
  return buildMedium(std::span(&body, 1), {}, Domain{{0, 0, 0}, 1, dims});
}

PhotonOptions grid(int columns, int rows) {
  PhotonOptions o;
  o.grid = {columns, rows};
  return o;
}

class Lanes : public testing::TestWithParam<std::string> {};
class LanesAndReference : public Lanes {};

/// Holds the set's sums against the reference's, within `most` for voxels and `mostTotal` for all power.
void expectSameAsScalar(const Scene& scene, const std::string& lanes, double most = 1e-2, double mostTotal = 1e-4) {
  const Sums a = run(scene, lanes), reference = run(scene, "scalar");
  EXPECT_GT(reference.count(Counter::Traced), 1000);
  EXPECT_EQ(a.count(Counter::Traced), reference.count(Counter::Traced));
  EXPECT_EQ(a.count(Counter::Emitted), reference.count(Counter::Emitted));
  EXPECT_EQ(a.count(Counter::NotFinite), 0);
  EXPECT_EQ(a.count(Counter::StepLimit), reference.count(Counter::StepLimit));
  const auto near = [&](Counter c, double tolerance) {
    EXPECT_NEAR(double(a.count(c)), double(reference.count(c)), tolerance * double(reference.count(c))) << int(c);
  };
  // A photon starts on a voxel's face, on this side or that up to rounding; so does one on the face of a constant cube.
  EXPECT_NEAR(double(a.count(Counter::Steps)), double(reference.count(Counter::Steps)),
              1e-2 * double(reference.count(Counter::Steps)) + .25 * double(reference.count(Counter::Traced)));
  near(Counter::VoxelsCrossed, 1e-2);
  for (int o = 0; o < static_cast<int>(Outcome::Count); ++o)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(a.watts(Outcome(o), c), reference.watts(Outcome(o), c),
                  mostTotal * reference.watts(Outcome::Emitted, c))
          << "outcome " << o << " channel " << c;
  EXPECT_GT(total(reference), 0);
  EXPECT_NEAR(total(a), total(reference), mostTotal * total(reference));
  const auto [light, direction] = difference(a, reference);
  EXPECT_LT(light, most);
  EXPECT_LT(direction, 2 * most);
}

TEST_P(LanesAndReference, CarryTheReferencesLightThroughASmoothLens) {
  expectSameAsScalar(Scene(luneburg(), sun({.3, -.2, -1}), grid(201, 150)), GetParam());
}

TEST_P(LanesAndReference, CarryItAlongTheAxes) {
  for (const Vec3d& d : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, 1}}) {
    SCOPED_TRACE(testing::Message() << d[0] << ' ' << d[1] << ' ' << d[2]);
    expectSameAsScalar(Scene(luneburg(), sun(d), grid(96, 100)), GetParam());
  }
}

TEST_P(LanesAndReference, CarryItThroughFog) {
  Ambient fog;
  fog.attenuation = {.02, .05, .3};
  fog.scattering = {.01, .05, 0};
  for (const double cutoff : {1e-4, .5}) {
    SCOPED_TRACE(cutoff);
    PhotonOptions o = grid(110, 110);
    o.cutoff = cutoff;
    const Scene scene(luneburg(fog), sun({.1, .2, -1}), o);
    // A photon at the threshold may end a step earlier or later.
    expectSameAsScalar(scene, GetParam(), 1e-2, cutoff > .1 ? 1e-3 : 1e-4);
    const Sums sums = run(scene, GetParam());
    EXPECT_EQ(sums.watts(Outcome::CutOff, 1) > 0, cutoff > .1);
  }
}

TEST_P(LanesAndReference, PlayRoulette) {
  Ambient fog;
  fog.attenuation = {.03, .05, .1};
  PhotonOptions o = grid(240, 240);
  o.roulette = true;
  o.cutoff = .5;
  // A hash of the photon and its step decides who lives, and sets may differ by a step: the same only on average.
  const Scene scene(luneburg(fog), sun({.1, .2, -1}), o);
  const Sums a = run(scene, GetParam()), reference = run(scene, "scalar");
  EXPECT_NEAR(total(a), total(reference), .01 * total(reference));
  EXPECT_NEAR(a.watts(Outcome::Escaped, 1), reference.watts(Outcome::Escaped, 1),
              .02 * reference.watts(Outcome::Escaped, 1));
}

TEST_P(LanesAndReference, CarryItWithEveryLookupAndScheme) {
  for (const Scheme scheme : {Scheme::DriftKickDrift, Scheme::Euler})
    for (const Lookup lookup : {Lookup::Trilinear, Lookup::Nearest}) {
      SCOPED_TRACE(testing::Message() << "Euler " << (scheme == Scheme::Euler) << ", nearest "
                                      << (lookup == Lookup::Nearest));
      PhotonOptions o = grid(90, 90);
      o.scheme = scheme;
      o.lookup = lookup;
      // The nearest voxel jumps where two are equally near: a photon there may go either way.
      expectSameAsScalar(Scene(luneburg(), sun({-.2, .1, -1}), o), GetParam(), lookup == Lookup::Nearest ? .03 : 1e-2);
    }
}

TEST_P(LanesAndReference, CarryItFromPointsInsideTheBoxAndOutside) {
  for (const Vec3d& p : {Vec3d{5, 6, 7}, Vec3d{18, 24, 33}, Vec3d{-20, 30, 100}, Vec3d{36.9, 20, 50}}) {
    SCOPED_TRACE(testing::Message() << p[0] << ' ' << p[1] << ' ' << p[2]);
    expectSameAsScalar(Scene(luneburg(), lamp(p), grid(160, 160)), GetParam());
  }
}

TEST_P(LanesAndReference, CarryItThroughJitteredRasters) {
  PhotonOptions o = grid(130, 140);
  o.jitter = true;
  expectSameAsScalar(Scene(luneburg(), sun({.1, .1, -1}), o), GetParam());
}

TEST_P(LanesAndReference, CarryItThroughGlassAndItsColour) {
  // A ray that grazes the glass magnifies a unit in the last place, so voxels agree less well than totals.
  expectSameAsScalar(Scene(glass({40, 36, 150}, {.1, .02, .3}, {.1, 0, .1}), sun({.05, .02, -1}), grid(200, 200)),
                     GetParam(), .05);
}

// A way is straight until light bends, however many steps that takes, so chords are longer than the longest step.
TEST_P(LanesAndReference, CarryItOnStraightWaysOfManySteps) {
  for (const double maxStep : {1.0, 64.0}) {
    SCOPED_TRACE(maxStep);
    PhotonOptions o = grid(48, 48);
    o.maxStep = maxStep;
    expectSameAsScalar(Scene(glass({24, 24, 600}, {}, {}, 1.02), sun({0, 0, -1}), o), GetParam(), .05);
  }
}

void expectEqual(const Sums& a, const Sums& b, std::int64_t times = 1) {
  ASSERT_EQ(a.voxels.size(), b.voxels.size());
  for (std::size_t i = 0; i < a.voxels.size(); ++i)
    for (int c = 0; c < kSums; ++c) ASSERT_EQ(a.voxels[i][c], times * b.voxels[i][c]) << "voxel " << i << " sum " << c;
}

TEST_P(Lanes, GiveTheSameBitsOnAnyNumberOfThreadsAndAgain) {
  Ambient fog;
  fog.attenuation = {.02, .05, .1};
  PhotonOptions o = grid(110, 110);
  o.jitter = o.roulette = true;
  o.cutoff = .1;
  for (const Scene& scene :
       {Scene(luneburg(fog), sun({.3, .1, -1}), o), Scene(glass({70, 40, 100}), lamp({30, 20, 95}), grid(200, 200))}) {
    const Sums one = run(scene, GetParam(), {.threads = 1});
    EXPECT_GT(total(one), 0);
    for (const int threads : {1, 2, 3}) {
      SCOPED_TRACE(threads);
      const Sums again = run(scene, GetParam(), {.threads = threads});
      expectEqual(again, one);
      EXPECT_EQ(again.tally.power, one.tally.power);
      EXPECT_EQ(again.tally.counts, one.tally.counts);
    }
  }
}

// A block is smoothed without its neighbours: what it holds of their voxels is what they hold. Far chords are cut
// anew for each block, so a crossing may round another way there, by a few units of some ten thousand.
TEST_P(Lanes, BlocksHoldTheirNeighboursLight) {
  const Rgb kFaint{1e-9, 1e-9, 1e-9}; // photons are traced, and go straight on
  for (const Scene& scene : {Scene(luneburg(), sun({.3, -.2, -1}), grid(201, 150)),
                             Scene(glass({70, 40, 100}), lamp({30, 20, 95}), grid(300, 300)),
                             // Rays along an axis, through the middles of voxels and through their faces.
                             Scene(glass({72, 72, 100}, kFaint, {}, 1), sun({0, 0, -1}), grid(72, 72)),
                             Scene(glass({72, 72, 100}, kFaint, {}, 1), sun({0, 0, -1}), grid(36, 36))}) {
    const Sums sums = run(scene, GetParam());
    double off = 0, all = 0;
    for (const auto& [voxel, around] : sums.around)
      for (int c = 0; c < kSums; ++c) {
        const auto own = static_cast<double>(sums.voxels[voxel][c]);
        off += std::abs(static_cast<double>(around[c]) - own);
        all += std::abs(own);
        ASSERT_NEAR(static_cast<double>(around[c]), own, 1e3 + 2e-3 * std::abs(own))
            << "voxel " << voxel << " sum " << c;
      }
    EXPECT_GT(all, 0);
    EXPECT_LE(off, GetParam() == "scalar" ? 0 : 2e-4 * all);
  }
}

// A photon's lane, its neighbours in the register and its task change with the rows; its light must not.
TEST_P(Lanes, GiveTheSameBitsRowByRow) {
  for (const Scene& scene : {Scene(glass({70, 40, 100}, {.1, .2, .05}), sun({.1, -.3, -1}), grid(133, 117)),
                             Scene(luneburg(), lamp({30, 20, 55}), grid(150, 150))}) {
    const Sums whole = run(scene, GetParam());
    for (const int rows : {1, 13, 64}) {
      SCOPED_TRACE(rows);
      const Sums parts = run(scene, GetParam(), {.threads = 2, .rowsAtOnce = rows});
      expectEqual(parts, whole);
      EXPECT_EQ(parts.tally.power, whole.tally.power);
      EXPECT_EQ(parts.tally.counts, whole.tally.counts);
    }
  }
}

// The same raster over and over: so many long chords that some are settled on the way. The fog cuts every straight way
// into many of them.
TEST_P(LanesAndReference, AddUpExactlyWhenFarLightIsSettledOnTheWay) {
  Ambient fog;
  fog.attenuation = {.03, .03, .03};
  Body body;
  body.mesh = ball({20, 18, 56}, 5);
  body.material.index = 1.3;
  body.material.attenuation = fog.attenuation;
  PhotonOptions o = grid(128, 128);
  o.cutoff = 0;
  const Scene scene(buildMedium(std::span(&body, 1), fog, Domain{{0, 0, 0}, 1, {40, 36, 64}}), sun({.1, .05, -1}), o);
  constexpr int kRepeats = 80;
  const Sums once = run(scene, GetParam());
  const Sums often = run(scene, GetParam(), {.threads = 2, .repeats = kRepeats});
  EXPECT_LT(often.farBytes, kRepeats * once.farBytes) << "all chords were kept to the end: the test needs more of them";
  expectEqual(often, once, kRepeats);
  EXPECT_EQ(often.count(Counter::VoxelsCrossed), kRepeats * once.count(Counter::VoxelsCrossed));
}

/// Sets of at least this many lanes.
std::vector<std::string> names(int width) {
  std::vector<std::string> n;
  for (const LaneSet& set : laneSets())
    if (set.width >= width) n.emplace_back(set.name);
  return n;
}
const auto kName = [](const testing::TestParamInfo<std::string>& set) { return set.param; };
INSTANTIATE_TEST_SUITE_P(All, Lanes, testing::ValuesIn(names(1)), kName);
INSTANTIATE_TEST_SUITE_P(Wide, LanesAndReference, testing::ValuesIn(names(2)), kName);

} // namespace
} // namespace volcaustic::test
