// Triangles against closed forms: volumes, areas, sharp edges, distances, topology.
#include "unit/polygonise_support.h"

#include <numbers>
#include <random>

namespace volcaustic::test {
namespace {

constexpr double kPi = std::numbers::pi;

struct Known {
  const char* name;
  Shape shape;
  double volume, area;
};

double spheroidArea(double a, double c) { // of semi-axes a, a, c with c < a
  const double e = std::sqrt(1 - c * c / (a * a));
  return 2 * kPi * a * a * (1 + (1 - e * e) / e * std::atanh(e));
}

std::vector<Known> knownShapes() {
  const Vec3d off{.013, -.027, .041};
  return {{"sphere", Shape::sphere(1).translated(off), 4 * kPi / 3, 4 * kPi},
          {"spheroid", Shape::ellipsoid({1, 1, .6}).rotated({20, 30, 40}), 4 * kPi / 3 * .6, spheroidArea(1, .6)},
          {"torus", Shape::torus(1, .3).rotated({30, 0, 0}), 2 * kPi * kPi * .09, 4 * kPi * kPi * .3},
          {"cylinder", Shape::cylinder(.5, 1).translated(off), kPi * .25, kPi * 1.5},
          {"dent", Shape::cuboid({2, 2, 2}) - Shape::sphere(.8).translated({0, 0, 1}), 8 - 2 * kPi / 3 * .512,
           24 + kPi * .64}};
}

TEST(PolygoniseAccuracy, VolumesAndAreasOfSecondOrder) {
  for (const Known& known : knownShapes()) {
    SCOPED_TRACE(known.name);
    double volumeError[2], areaError[2];
    for (int i = 0; i < 2; ++i) {
      const MeshReport r = checkMesh(polygonise(known.shape, cells(.08 / (1 << i)), threads(2)));
      EXPECT_EQ(describeDefects(r), "");
      volumeError[i] = std::abs(r.signedVolume - known.volume) / known.volume;
      areaError[i] = std::abs(r.area - known.area) / known.area;
    }
    EXPECT_LT(volumeError[0], .01);
    EXPECT_LT(areaError[0], .01);
    EXPECT_LT(volumeError[1], .32 * volumeError[0]);
    EXPECT_LT(areaError[1], .36 * areaError[0]);
  }
}

TEST(PolygoniseAccuracy, CuboidsKeepTheirEdgesAndCorners) {
  const Vec3d size{1, 1.3, .7};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> degrees(0, 90), offset(-1, 1);
  for (int i = 0; i < 12; ++i) {
    Placement placement;
    if (i > 0) placement.translate = {offset(random), offset(random), offset(random)};
    if (i > 3) placement.rotate = {degrees(random), degrees(random), degrees(random)};
    const Mesh mesh = polygonise(Shape::cuboid(size).placed(placement), cells(1.0 / 16), threads(2));
    const Affine m = affine(placement);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3d p;
      for (int a = 0; a < 3; ++a) {
        p[a] = m[a][3];
        for (int b = 0; b < 3; ++b) p[a] += m[a][b] * size[b] * (corner >> b & 1 ? .5 : -.5);
      }
      double nearest = 1;
      for (const Vec3d& v : mesh.positions)
        nearest = std::min(nearest, std::hypot(v[0] - p[0], v[1] - p[1], v[2] - p[2]));
      farthest = std::max(farthest, nearest);
    }
    const MeshReport r = checkMesh(mesh);
    EXPECT_EQ(describeDefects(r), "");
    // Turned, a corner may lie where no cell sees all of its faces, or next to a vertex of an edge.
    EXPECT_LT(farthest, i > 3 ? .012 : 1e-6) << i;
    EXPECT_NEAR(r.signedVolume, .91, i > 3 ? 2e-4 : 1e-6) << i;
    EXPECT_NEAR(r.area, 5.82, i > 3 ? 2e-3 : 1e-5) << i;
  }
}

TEST(PolygoniseAccuracy, RimsAreWhereTheyBelong) {
  // Vertices on the rim of a cone: as many as cells around it, and exactly on the circle.
  const Mesh mesh = polygonise(Shape::cone(1, 1.5).translated({.017, .023, .011}), cells(.05), threads(2));
  int onRim = 0;
  for (const Vec3d& p : mesh.positions) {
    const double radius = std::hypot(p[0] - .017, p[1] - .023);
    if (std::abs(p[2] - .011) < 1e-4 && std::abs(radius - 1) < 1e-3) ++onRim;
  }
  EXPECT_GT(onRim, 120);
}

TEST(PolygoniseAccuracy, Topology) {
  const Shape sphere = Shape::sphere(1), torus = Shape::torus(1, .3);
  const struct {
    const char* name;
    Shape shape;
    long characteristic;
    std::uint64_t shells;
  } cases[] = {{"sphere", sphere, 2, 1},
               {"torus", torus, 0, 1},
               {"double torus", Shape::unite({torus, torus.translated({2.2, 0, 0})}, .2), -2, 1},
               {"two spheres", sphere | sphere.translated({2.5, 0, 0}), 4, 2},
               {"hollow sphere", sphere - Shape::sphere(.6), 4, 2},
               {"shell", sphere.shell(.3), 4, 2},
               {"cube with a hole", Shape::cuboid({2, 2, 2}) - Shape::cylinder(.5, 4), 0, 1}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Mesh mesh = polygonise(c.shape, cells(.08), threads(2));
    expectManifold(mesh);
    EXPECT_EQ(eulerCharacteristic(mesh), c.characteristic);
    const MeshReport r = checkMesh(mesh);
    EXPECT_EQ(r.shellCount, c.shells);
    EXPECT_GT(r.signedVolume, 0);
  }
}

/// Distances to the surface along the gradient, of points all over the triangles.
double greatestDistance(const Shape& shape, const Mesh& mesh) {
  std::vector<Vec3d> points;
  for (const auto& t : mesh.triangles)
    for (int i = 0; i <= 6; ++i)
      for (int j = 0; i + j <= 6; ++j) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
          p[a] =
              (mesh.positions[t[0]][a] * i + mesh.positions[t[1]][a] * j + mesh.positions[t[2]][a] * (6 - i - j)) / 6;
        points.push_back(p);
      }
  const ShapeField field(shape);
  std::vector<double> values(points.size());
  std::vector<Vec3d> gradients(points.size());
  field.values(points, values);
  field.gradients(points, gradients);
  double greatest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    greatest = std::max(greatest, std::abs(values[i]) / std::hypot(gradients[i][0], gradients[i][1], gradients[i][2]));
  return greatest;
}

TEST(PolygoniseAccuracy, ToleranceIsKept) {
  const Shape shapes[] = {Shape::ellipsoid({1, .7, .4}), Shape::torus(1, .3).translated({.1, .2, .3}),
                          Shape::unite({Shape::sphere(1), Shape::sphere(.8).translated({1.2, .3, 0})}, .3),
                          Shape::cuboid({1, 1, 1}) - Shape::sphere(.6)};
  for (const Shape& shape : shapes) {
    PolygoniseOptions options;
    options.resolution = 12;
    options.tolerance = 2e-3;
    PolygoniseReport report;
    const Mesh mesh = polygonise(shape, options, threads(2), &report);
    EXPECT_LE(greatestDistance(shape, mesh), options.tolerance);
    EXPECT_GT(report.deviation, .2 * options.tolerance);
    EXPECT_LT(report.deviation, options.tolerance);
  }
}

TEST(PolygoniseAccuracy, FlatFacesNeedNoSmallCells) {
  PolygoniseOptions options;
  options.resolution = 12;
  options.tolerance = 1e-4;
  EXPECT_LT(polygonise(Shape::cuboid({1, .8, .6}).translated({.01, .02, .03}), options).triangles.size(), 3000u);
}

TEST(PolygoniseAccuracy, WarnsOfAToleranceOutOfReach) {
  PolygoniseOptions options;
  options.resolution = 12;
  options.tolerance = 1e-5;
  options.triangles = 5000;
  std::string warning;
  RunContext ctx = threads(2);
  ctx.onLog = [&](LogLevel level, std::string_view line) {
    if (level == LogLevel::Warning) warning += line;
  };
  EXPECT_LE(polygonise(Shape::sphere(1), options, ctx).triangles.size(), 5000u);
  EXPECT_NE(warning.find("not 1e-05"), warning.npos) << warning;
}

} // namespace
} // namespace volcaustic::test
