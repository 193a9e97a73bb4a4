// Handles: as rigid as possible and Laplacian.
#include "unit/deform_support.h"

#include "deform/rotation_fit.h"
#include "deform/surface.h"
#include "mesh/vector.h"
#include "volcaustic/placement.h"

#include <algorithm>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <random>

namespace volcaustic::test {
namespace {

Vec3d mapped(const Affine& a, const Vec3d& about, const Vec3d& p) {
  const Vec3d d = difference(p, about);
  Vec3d q;
  for (std::size_t i = 0; i < 3; ++i) q[i] = about[i] + a[i][3] + a[i][0] * d[0] + a[i][1] * d[1] + a[i][2] * d[2];
  return q;
}

/// Sorkine and Alexa's energy, with the best rotation at each point.
double rigidEnergy(const Mesh& rest, const Mesh& mesh) {
  const DeformSurface surface = makeDeformSurface(rest);
  std::vector<Eigen::Vector3d> before(surface.points.size()), after(surface.points.size());
  for (std::size_t v = 0; v < rest.positions.size(); ++v) {
    before[surface.pointOf[v]] = Eigen::Vector3d(rest.positions[v].data());
    after[surface.pointOf[v]] = Eigen::Vector3d(mesh.positions[v].data());
  }
  double energy = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    const auto forEdges = [&](auto&& body) {
      for (std::uint32_t e = surface.neighbours.start[i]; e < surface.neighbours.start[i + 1]; ++e) {
        const std::uint32_t j = surface.neighbours.entries[e];
        body(surface.weights[e], before[i] - before[j], after[i] - after[j]);
      }
    };
    forEdges(
        [&](double w, const Eigen::Vector3d& b, const Eigen::Vector3d& a) { covariance += w * b * a.transpose(); });
    const Eigen::Matrix3d rotation = fittedRotation(covariance);
    forEdges([&](double w, const Eigen::Vector3d& b, const Eigen::Vector3d& a) {
      energy += w * (a - rotation * b).squaredNorm();
    });
  }
  return energy;
}

/// Least and greatest length of an edge against its length at rest.
std::pair<double, double> stretch(const Mesh& rest, const Mesh& mesh) {
  double least = 1, greatest = 1;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const double part =
          distance(mesh.positions[a], mesh.positions[b]) / distance(rest.positions[a], rest.positions[b]);
      least = std::min(least, part);
      greatest = std::max(greatest, part);
    }
  return {least, greatest};
}

const Placement kTurned{.translate = {.3, -.2, .1}, .rotate = {40, -70, 110}};

/// The ends of a bar of length 6 held, the far one placed.
std::vector<Deformer> heldEnds(const Placement& placement) {
  return {handle({0, 0, 0}, .8), handle({6, 0, 0}, .8, placement)};
}

TEST(RotationFit, AgreesWithTheSingularValueDecomposition) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 4000; ++trial) {
    Eigen::Matrix3d m = Eigen::Matrix3d::NullaryExpr([&] { return normal(random); });
    if (trial % 4 == 1) m.col(trial % 3) *= 1e-12; // flat
    if (trial % 4 == 2) m.col(0) = m.col(1);       // flat and singular
    if (trial % 4 == 3) m *= trial % 8 == 3 ? 1e-200 : 1e150;
    const Eigen::Matrix3d r = fittedRotation(m);
    EXPECT_NEAR((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-14);
    EXPECT_NEAR(r.determinant(), 1, 1e-14);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d s = svd.singularValues();
    const double best = s[0] + s[1] + (m / s[0]).determinant() / std::abs((m / s[0]).determinant()) * s[2];
    if (std::isfinite(best)) {
      EXPECT_NEAR((r * m).trace() / s[0], best / s[0], 1e-9) << m;
    }
  }
}

TEST(RotationFit, TurnsLinesAndPointsSomehowButAlwaysAlike) {
  Eigen::Matrix3d line = Eigen::Matrix3d::Zero();
  EXPECT_EQ(fittedRotation(line), Eigen::Matrix3d::Identity());
  line(0, 1) = 2; // x goes to y
  const Eigen::Matrix3d r = fittedRotation(line);
  EXPECT_NEAR((r * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-12);
  EXPECT_EQ(r, fittedRotation(line));
  EXPECT_NEAR(fittedRotation(-Eigen::Matrix3d::Identity()).determinant(), 1, 1e-12); // all axes are equally bad
}

TEST(DeformHandles, StandStillBitByBit) {
  const Mesh rest = *ball({.1, .2, .3}, .7, 12);
  for (const DeformMethod method : {DeformMethod::AsRigidAsPossible, DeformMethod::Laplacian}) {
    const Mesh mesh = deformed(rest, std::vector{handle({.1, .2, 1}, .2), handle({.1, .2, -.4}, .2)}, {method, 10});
    EXPECT_EQ(mesh.positions, rest.positions);
    EXPECT_EQ(mesh.triangles, rest.triangles);
  }
}

TEST(DeformHandles, MoveTheWholeRigidlyWhenTheyDo) {
  const Mesh rest = bar(6, 4);
  const Affine motion = affine(kTurned);
  // The same motion about the origin for both, in numbers about the center of each.
  Placement far = kTurned;
  const Vec3d center{6, 0, 0}, moved = mapped(motion, {0, 0, 0}, center);
  far.translate = difference(moved, center);
  const Mesh mesh = deformed(rest, std::vector{handle({0, 0, 0}, .8, kTurned), handle(center, .8, far)});
  for (std::size_t v = 0; v < rest.positions.size(); ++v)
    EXPECT_LT(distance(mesh.positions[v], mapped(motion, {0, 0, 0}, rest.positions[v])), 1e-9);
}

TEST(DeformHandles, PlaceWhatTheyHold) {
  const Mesh rest = bar(6, 4);
  const Placement stretched{.translate = {0, 1, 0}, .rotate = {0, 20, 0}, .scale = {1, 2, 1}};
  for (const DeformMethod method : {DeformMethod::AsRigidAsPossible, DeformMethod::Laplacian}) {
    const Mesh mesh = deformed(rest, heldEnds(stretched), {method, 5});
    for (std::size_t v = 0; v < rest.positions.size(); ++v) {
      if (distance(rest.positions[v], {0, 0, 0}) < .8) {
        EXPECT_EQ(mesh.positions[v], rest.positions[v]);
      }
      if (distance(rest.positions[v], {6, 0, 0}) < .8) {
        EXPECT_LT(distance(mesh.positions[v], mapped(affine(stretched), {6, 0, 0}, rest.positions[v])), 1e-14);
      }
    }
  }
}

TEST(DeformHandles, KeepEdgeLengthsOfABentBar) {
  const Mesh rest = bar(6, 4);
  // The end of a bar that is bent to a quarter of a circle of its length.
  const double radius = 12 / std::numbers::pi;
  const Placement bent{.translate = {radius - 6, 0, radius}, .rotate = {0, -90, 0}};
  const auto [least, greatest] = stretch(rest, deformed(rest, heldEnds(bent), {.iterations = 50}));
  // The ends are held stiff, so what lies between bends to a radius of 2.8: 1 -+ .5/2.8 inside and outside.
  EXPECT_GT(least, 0.78);
  EXPECT_LT(greatest, 1.22);
}

TEST(DeformHandles, WindABarUpEvenly) {
  const Mesh rest = bar(6, 4);
  for (const double degrees : {90., 180., -180., 360.}) {
    const Mesh mesh = deformed(rest, heldEnds({.rotate = {degrees, 0, 0}}));
    for (std::size_t v = 0; v < rest.positions.size(); ++v) {
      const Vec3d &p = rest.positions[v], &q = mesh.positions[v];
      // A steel bar thins as it is wound up; what must not happen is that it falls into its axis.
      EXPECT_NEAR(std::hypot(q[1], q[2]), std::hypot(p[1], p[2]), std::abs(degrees) > 180 ? .3 : .12) << degrees;
      if (p[0] != 3 || std::abs(p[1]) + std::abs(p[2]) < .9) continue;
      const double turn = std::atan2(q[2], q[1]) - std::atan2(p[2], p[1]);
      EXPECT_NEAR(std::remainder(turn * 180 / std::numbers::pi - degrees / 2, 360), 0, 5) << degrees;
    }
  }
}

TEST(DeformHandles, LowerTheEnergyWithEachIteration) {
  const Mesh rest = bar(6, 3);
  const std::vector<Deformer> steps = heldEnds({.translate = {-2, 1, 0}, .rotate = {30, 80, -60}});
  double before = std::numeric_limits<double>::infinity();
  const double unrotated = rigidEnergy(rest, deformed(rest, steps, {DeformMethod::Laplacian, 1}));
  for (const int iterations : {1, 2, 3, 5, 10, 20, 50}) {
    const double energy = rigidEnergy(rest, deformed(rest, steps, {.iterations = iterations}));
    EXPECT_LT(energy, before * (1 + 1e-12)) << iterations;
    before = energy;
    if (iterations == 10) {
      EXPECT_LT(energy, unrotated / 2);
    }
  }
}

TEST(DeformHandles, AreLinearUnderTheLaplacian) {
  const Mesh rest = *ball({0, 0, 0}, 1, 16);
  const auto moved = [&](const Vec3d& by) {
    return deformed(rest, std::vector{handle({0, 0, -1}, .4), handle({0, 0, 1}, .3, {.translate = by})},
                    {DeformMethod::Laplacian, 1});
  };
  const Mesh a = moved({.25, 0, 0}), b = moved({0, .5, -.125}), both = moved({.5, -1, .25});
  for (std::size_t v = 0; v < rest.positions.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k) {
      const double p = rest.positions[v][k];
      EXPECT_NEAR(both.positions[v][k] - p, 2 * (a.positions[v][k] - p) - 2 * (b.positions[v][k] - p), 1e-9);
    }
}

TEST(DeformHandles, DoNotDependOnCallsBefore) {
  const auto rest = std::make_shared<const Mesh>(bar(4, 3));
  MeshDeformer deformer(rest);
  const auto at = [](double degrees, double radius) {
    return std::vector{handle({0, 0, 0}, .8), handle({4, 0, 0}, radius, {.rotate = {degrees, 5, 0}})};
  };
  const Mesh fresh = deformed(*rest, at(100, .8));
  (void)deformer.deform(at(-170, .8));
  EXPECT_EQ(deformer.deform(at(100, .8)).positions, fresh.positions);
  (void)deformer.deform(at(100, 1.5));
  (void)deformer.deform(at(100, .8), {DeformMethod::Laplacian, 1});
  EXPECT_THROW((void)deformer.deform(std::vector{handle({9, 9, 9}, .1)}), Error);
  EXPECT_EQ(deformer.deform(at(100, .8)).positions, fresh.positions);
}

TEST(DeformHandles, HaveTheSameBitsForAnyNumberOfThreads) {
  const Mesh rest = *ball({0, 0, 0}, 1, 40);
  const std::vector steps{handle({0, 0, -1}, .4),
                          handle({0, 0, 1}, .3, {.translate = {.5, 0, .5}, .rotate = {0, 60, 0}}),
                          brush(DeformerType::Inflate, {1, 0, 0}, .5, .1)};
  const auto withThreads = [&](int threads) {
    RunContext ctx;
    ctx.threads = threads;
    return deformed(rest, steps, {}, ctx).positions;
  };
  EXPECT_EQ(withThreads(1), withThreads(2));
  EXPECT_EQ(withThreads(1), withThreads(7));
}

TEST(DeformHandles, MoveTrianglesWithoutSharedVerticesLikeTheirSurface) {
  const Mesh rest = *ball({0, 0, 0}, 1, 10);
  Mesh soup;
  for (const auto& t : rest.triangles) {
    for (const std::uint32_t v : t) soup.positions.push_back(rest.positions[v]);
    const auto last = static_cast<std::uint32_t>(soup.positions.size() - 1);
    soup.triangles.push_back({last - 2, last - 1, last});
  }
  const std::vector steps{handle({0, 0, -1}, .4), handle({0, 0, 1}, .3, {.translate = {.5, 0, .5}})};
  const Mesh whole = deformed(rest, steps), pieces = deformed(soup, steps);
  for (std::size_t t = 0; t < rest.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) // equal points are equal still; the order of unknowns differs
      EXPECT_LT(distance(pieces.positions[3 * t + k], whole.positions[rest.triangles[t][k]]), 1e-10);
  EXPECT_TRUE(checkMesh(pieces).closedAndConsistent());
}

TEST(DeformHandles, LeavePartsAloneThatTheyDoNotHold) {
  Mesh mesh = *ball({0, 0, 0}, 1, 8);
  const std::size_t first = mesh.positions.size();
  const Mesh other = *ball({5, 0, 0}, 1, 8);
  for (const Vec3d& p : other.positions) mesh.positions.push_back(p);
  for (const auto& [a, b, c] : other.triangles) {
    const auto shift = static_cast<std::uint32_t>(first);
    mesh.triangles.push_back({a + shift, b + shift, c + shift});
  }
  const Mesh moved = deformed(mesh, std::vector{handle({0, 0, 1}, .3, {.translate = {0, 0, 1}})});
  EXPECT_TRUE(std::equal(mesh.positions.begin() + static_cast<std::ptrdiff_t>(first), mesh.positions.end(),
                         moved.positions.begin() + static_cast<std::ptrdiff_t>(first)));
  for (std::size_t v = 0; v < first; ++v) // a single handle takes the whole part with it
    EXPECT_NEAR(moved.positions[v][2], mesh.positions[v][2] + 1, 1e-9);
}

TEST(DeformHandles, SayWhatIsWrong) {
  const Mesh mesh = *ball({0, 0, 0}, 1, 6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint(mesh, {handle({0, 0, 1}, .3), handle({3, 0, 0}, 1)}),
            "deform[1]: the handle holds no vertex; move its center to the surface, or give it a larger radius");
  EXPECT_TRUE(complaint(mesh, {handle({0, 0, 1}, 0)}).starts_with("deform[0]: the radius"));
  EXPECT_TRUE(complaint(mesh, {handle({0, 0, nan}, 1)}).starts_with("deform[0]: center"));
  EXPECT_TRUE(complaint(mesh, {handle({0, 0, 1}, 1, {.scale = {1, nan, 1}})}).starts_with("deform[0]: the placement"));
  EXPECT_TRUE(complaint(mesh, {handle({0, 0, 1}, .8, {.translate = {1.7e308, 0, 0}, .scale = {1e308, 1, 1}})})
                  .starts_with("deform[0]: moves vertices beyond"));
  EXPECT_TRUE(complaint(mesh, {}, {.iterations = 0}).starts_with("deform: iterations"));
  EXPECT_THROW(MeshDeformer(nullptr), Error);
  Mesh broken = mesh;
  broken.triangles[0][1] = 99999;
  EXPECT_THROW((void)deformed(broken, {}), Error);
}

TEST(DeformHandles, StopWhenAsked) {
  const std::atomic<bool> cancel{true};
  RunContext ctx;
  ctx.cancel = &cancel;
  try {
    (void)deformed(bar(6, 3), heldEnds(kTurned), {}, ctx);
    FAIL() << "goes on";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Cancelled);
  }
}

} // namespace
} // namespace volcaustic::test
