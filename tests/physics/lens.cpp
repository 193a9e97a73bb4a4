// Lenses as functional objects against the lensmaker's equation, from the shape to the light behind it.
#include "support/lights.h"
#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/polygonise.h"
#include "volcaustic/shape.h"
#include "volcaustic/shape_file.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <string>

namespace volcaustic::test {
namespace {

constexpr double kIndex = 1.5, kFlat = std::numeric_limits<double>::infinity();

/// Light goes along +z; radii are above 0 where a face is convex towards where light comes from.
struct Lens {
  const char* name;
  double front, back, thickness;

  [[nodiscard]] double focalLength() const {
    const double n = kIndex;
    return 1 / ((n - 1) * (1 / front - 1 / back + (n - 1) * thickness / (n * front * back)));
  }
  /// Of the focus behind the back face.
  [[nodiscard]] double backFocalLength() const {
    return focalLength() * (1 - (kIndex - 1) * thickness / (kIndex * front));
  }
  /// The front face through the origin.
  [[nodiscard]] Shape shape() const {
    Shape s = Shape::cylinder(.25, 1);
    const auto add = [&](double radius, double vertex, bool convex) {
      const double outwards = vertex > 0 ? 1 : -1;
      if (radius == kFlat) {
        s = s & Shape::plane({0, 0, outwards}, outwards * vertex);
        return;
      }
      const Shape ball = Shape::sphere(std::abs(radius)).translated({0, 0, vertex + radius});
      s = convex ? s & ball : s - ball;
    };
    add(front, 0, front > 0);
    add(back, thickness, back < 0);
    return s;
  }
};

/// A box that the lens's rim is outside of, so that all light in it goes through both faces.
Domain beam(double length) {
  const double h = .12 / 64;
  return {{-.06, -.06, -.05}, h, {64, 64, static_cast<int>(std::ceil((length + .05) / h))}};
}

Medium glassLens(const Lens& lens, const Domain& domain, bool triangles) {
  Body body;
  body.material.index = kIndex;
  if (triangles)
    body.mesh = std::make_shared<const Mesh>(polygonise(lens.shape(), {.tolerance = 1e-5}));
  else
    body.shape = lens.shape();
  return buildMedium(std::span(&body, 1), {}, domain);
}

const Lens kLenses[] = {{"biconvex", .97958, -.97958, .12},
                        {"plano-convex", .5, kFlat, .08},
                        {"meniscus", .3, .75, .06},
                        {"biconcave", -.8, .8, .04},
                        {"plano-concave", kFlat, .6, .05}};

/// 1/f by least squares over rays parallel to the axis: they leave with the slope -y/f.
double measuredPower(const Medium& medium) {
  std::vector<TracedRay> rays;
  std::vector<double> heights;
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j) {
      const double x = .00307 * i, y = .00293 * j;
      rays.push_back({{x, y, medium.domain().minCorner[2] + .001}, {0, 0, 1}});
    }
  const std::vector<TracedRay> start = rays;
  traceRays(medium, rays);
  double slopes = 0, squares = 0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (int a = 0; a < 2; ++a) {
      slopes += start[i].position[a] * rays[i].direction[a] / rays[i].direction[2];
      squares += start[i].position[a] * start[i].position[a];
    }
  return -slopes / squares;
}

TEST(LensShapes, BendRaysByTheLensmakersEquation) {
  for (const Lens& lens : kLenses) {
    const double expected = 1 / lens.focalLength();
    EXPECT_NEAR(measuredPower(glassLens(lens, beam(.2), false)) / expected, 1, .01) << lens.name;
  }
}

TEST(LensShapes, BendRaysAlikeAsTriangles) {
  const Lens& lens = kLenses[0];
  EXPECT_NEAR(measuredPower(glassLens(lens, beam(.2), true)) * lens.focalLength(), 1, .01);
}

TEST(LensShapes, OfTheModelShopHaveTheirFocalLengths) {
  struct Model {
    const char* file;
    double focalLength;
  };
  const double h = .12 / 64;
  const Domain domain{{-.06, -.06, -.2}, h, {64, 64, static_cast<int>(std::ceil(.4 / h))}};
  for (const Model& model : {Model{"lens_biconvex", 1},
                             {"lens_plano_convex", 2},
                             {"lens_biconcave", -1},
                             {"lens_meniscus", 2},
                             {"lens_aspheric", 1}}) {
    Body body;
    body.material.index = kIndex;
    const std::string file = std::string(VOLCAUSTIC_SOURCE_DIR "/data/shapes/") + model.file + ".json";
    body.shape = readShape(file);
    const Medium medium = buildMedium(std::span(&body, 1), {}, domain);
    EXPECT_NEAR(measuredPower(medium) * model.focalLength, 1, .01) << model.file;
  }
}

/// Where the light behind a lens would be narrowest: around the axis its fluence goes as 1/(focus - z)^2, so that the
/// inverse of its root is a straight line, whose zero is the focus. By least squares over slices.
double measuredFocus(const RadianceVolume& light, double from, double to) {
  const Domain& d = light.domain();
  double n = 0, sz = 0, sw = 0, szz = 0, szw = 0;
  for (int k = 0; k < d.dims[2]; ++k) {
    const double z = d.minCorner[2] + d.voxelSize * (k + .5);
    if (z < from || z > to) continue;
    double fluence = 0;
    for (int i = 24; i < 40; ++i)
      for (int j = 24; j < 40; ++j) fluence += light.causticFluence({i, j, k})[1];
    const double width = 1 / std::sqrt(fluence);
    n += 1, sz += z, sw += width, szz += z * z, szw += z * width;
  }
  const double slope = (n * szw - sz * sw) / (n * szz - sz * sz);
  return (sz - sw / slope) / n;
}

TEST(LensShapes, CollectLightAtTheirBackFocus) {
  for (const Lens& lens : {kLenses[0], kLenses[1], kLenses[2]}) {
    const double back = lens.backFocalLength(), length = lens.thickness + .75 * back;
    const Medium medium = glassLens(lens, beam(length), false);
    PhotonOptions options;
    options.grid = {512, 512};
    options.smooth = false;
    const Light light = sun({0, 0, 1});
    const PhotonResult result = tracePhotons(medium, std::span(&light, 1), {}, options);
    const double focus =
        measuredFocus(result.radiance, lens.thickness + .1 * back, lens.thickness + .7 * back) - lens.thickness;
    EXPECT_NEAR(focus / back, 1, .015) << lens.name;
  }
}

} // namespace
} // namespace volcaustic::test
