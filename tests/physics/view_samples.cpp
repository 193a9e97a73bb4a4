// Samples of pixels: filters, passes, convergence, the adaptive stop; and what a picture must not show: the steps of
// its rays, or the bricks of its volumes.

#include "support/fields.h"
#include "support/lights.h"
#include "transport/pixel_sampler.h"
#include "volcaustic/error.h"
#include "volcaustic/options.h"
#include "volcaustic/view.h"
#include "volume/radiance_bricks.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

namespace volcaustic::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Background kBlack{{0, 0, 0}, {0, 0, 0}};

Camera camera(const Vec3d& position, const Vec3d& target, int width, int height, double fieldOfView) {
  Camera c;
  c.position = position;
  c.target = target;
  c.resolution = {width, height};
  c.fieldOfView = fieldOfView;
  return c;
}

Ambient fog(double attenuation, double asymmetry = 0) {
  Ambient a;
  a.attenuation = a.scattering = {attenuation, attenuation, attenuation};
  a.asymmetry = asymmetry;
  return a;
}

/// Caustic fluence as a function of position, in every voxel.
RadianceVolume lightVolume(const Domain& domain, const std::function<double(const Vec3d&)>& fluence) {
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  FluenceGrid& grid = light->caustic;
  grid.reserve(grid.brickCount(), {});
  for (std::int64_t b = 0; b < grid.brickCount(); ++b) {
    const std::int32_t slot = grid.claim(1);
    const Vec3i c = grid.brickCoord(b);
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Vec3d p{(c[0] * 8 + (k >> 6) + .5) * domain.voxelSize, (c[1] * 8 + (k >> 3 & 7) + .5) * domain.voxelSize,
                    (c[2] * 8 + (k & 7) + .5) * domain.voxelSize};
      const auto f = static_cast<float>(fluence(p));
      grid.slot(slot)[k] = kernels::pack({kernels::Float3(f, f, f), kernels::Float3(0, 0, 0)});
    }
    grid.assign(b, slot);
  }
  return {domain, light};
}

double at(const Image& image, const char* channel, int x, int y) {
  return image.planes[image.find(channel)][std::size_t(y) * image.width + x];
}

/// Integral over the ray of a pixel's centre through the unit cube, in `parts` parts.
double alongRay(const Camera& c, int x, int y, int parts, const std::function<double(const Vec3d& p, double way)>& f) {
  const auto minus = [](const Vec3d& a, const Vec3d& b) { return Vec3d{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto unit = [](Vec3d a) {
    const double l = std::hypot(a[0], a[1], a[2]);
    return Vec3d{a[0] / l, a[1] / l, a[2] / l};
  };
  const auto cross = [](const Vec3d& a, const Vec3d& b) {
    return Vec3d{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Vec3d forward = unit(minus(c.target, c.position)), right = unit(cross(forward, c.up)),
              up = cross(right, forward);
  const double half = std::tan(.5 * c.fieldOfView * kPi / 180);
  const double u = ((x + .5) / c.resolution[0] * 2 - 1) * half * c.resolution[0] / c.resolution[1],
               v = (1 - (y + .5) / c.resolution[1] * 2) * half;
  Vec3d d;
  for (int a = 0; a < 3; ++a) d[a] = forward[a] + u * right[a] + v * up[a];
  d = unit(d);
  double entry = 0, exit = 1e300;
  for (int a = 0; a < 3; ++a) {
    const double t0 = (0 - c.position[a]) / d[a], t1 = (1 - c.position[a]) / d[a];
    entry = std::max(entry, std::min(t0, t1));
    exit = std::min(exit, std::max(t0, t1));
  }
  double sum = 0;
  const double step = (exit - entry) / parts;
  for (int i = 0; i < parts && exit > entry; ++i) {
    const double way = (i + .5) * step, t = entry + way;
    sum += f({c.position[0] + t * d[0], c.position[1] + t * d[1], c.position[2] + t * d[2]}, way) * step;
  }
  return sum;
}

// Mean and variance of the points are the filter's own; a box is the pixel's square.
TEST(PixelFilter, SamplesHaveTheFiltersMoments) {
  const struct {
    PixelFilter filter;
    double radius, variance;
  } filters[] = {{PixelFilter::Box, .5, 1.0 / 12},
                 {PixelFilter::Tent, 1, 1.0 / 6},
                 {PixelFilter::Gaussian, 1.5, .22945},
                 {PixelFilter::BlackmanHarris, 1.5, .17266}};
  for (const auto& f : filters) {
    SCOPED_TRACE(enumNames(f.filter)[static_cast<int>(f.filter)]);
    const kernels::PixelSampler sampler = pixelSampler(f.filter, 16, 7);
    double mean = 0, square = 0;
    int points = 0;
    for (int pixel = 0; pixel < 16; ++pixel)
      for (int s = 0; s < 256; ++s, ++points) {
        const auto p = sampler.point(pixel, 100 - pixel, s);
        const double x = p.column - pixel - .5, y = p.row - (100 - pixel) - .5;
        ASSERT_LE(std::abs(x), f.radius);
        ASSERT_LE(std::abs(y), f.radius);
        mean += x + y;
        square += x * x + y * y;
      }
    EXPECT_NEAR(mean / points, 0, 4e-3);
    EXPECT_NEAR(square / points / 2, f.variance, .015 * f.variance + 5e-4);
  }
}

TEST(PixelFilter, VisitsEveryStratumOnce) {
  for (const int side : {2, 3, 5, 8, 16}) {
    const kernels::PixelSampler sampler = pixelSampler(PixelFilter::Box, side, 3);
    std::set<int> strata;
    for (int s = 0; s < side * side; ++s) {
      const auto p = sampler.point(12, 7, s);
      strata.insert(int((p.column - 12) * side) * side + int((p.row - 7) * side));
    }
    EXPECT_EQ(strata.size(), std::size_t(side) * side) << side;
  }
  const auto centre = pixelSampler(PixelFilter::Tent, 1, 3).point(4, 5, 0);
  EXPECT_EQ(centre.column, 4.5);
  EXPECT_EQ(centre.row, 5.5);
}

/// An edge of light across the picture, slanting.
struct Edge {
  Domain domain = unitCube(32);
  Medium medium = buildMedium({}, fog(.5), domain);
  RadianceVolume light = lightVolume(domain, [](const Vec3d& p) { return p[2] > .3 + .4 * p[1] ? 1.0 : 0.0; });
  Camera eye = camera({-6, .5, .5}, {.5, .5, .5}, 64, 64, 7);
};

// Stratified samples of a kink: the error falls faster than that of random ones, by 2 for each doubling of both sides.
TEST(ViewSamples, ConvergeAtTheRateOfStrata) {
  const Edge edge;
  const auto render = [&](int samples) {
    ViewOptions options;
    options.samples = samples;
    return renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options).image;
  };
  const Image reference = render(16);
  const auto error = [&](int samples) {
    const Image image = render(samples);
    double sum = 0;
    for (std::size_t i = 0; i < image.planes[0].size(); ++i)
      sum += std::pow(double(image.planes[0][i]) - reference.planes[0][i], 2);
    return std::sqrt(sum / double(image.planes[0].size()));
  };
  const double two = error(2), four = error(4), eight = error(8);
  EXPECT_LT(four, .6 * two);
  EXPECT_LT(eight, .6 * four);
}

TEST(ViewSamples, ComeInPassesThatEndInTheSamePicture) {
  const Edge edge;
  ViewOptions options;
  options.samples = 3;
  std::vector<std::int64_t> samples;
  std::vector<double> errors;
  const ViewResult end = renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options);
  const ViewResult watched =
      renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options, {}, [&](const ViewResult& soFar) {
        samples.push_back(soFar.samples / (64 * 64));
        double sum = 0;
        for (std::size_t i = 0; i < soFar.image.planes[0].size(); ++i)
          sum += std::pow(double(soFar.image.planes[0][i]) - end.image.planes[0][i], 2);
        errors.push_back(sum);
      });
  EXPECT_EQ(samples, (std::vector<std::int64_t>{1, 2, 4, 8, 9}));
  EXPECT_EQ(watched.passes, 5);
  EXPECT_EQ(watched.image.planes, end.image.planes);
  EXPECT_EQ(errors.back(), 0);
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_LT(errors[i], errors[i - 1]);
}

TEST(ViewSamples, StopWhereNothingIsNoisy) {
  Edge edge;
  edge.eye.resolution = {256, 256};
  edge.light = lightVolume(edge.domain, [](const Vec3d& p) { return p[2] > .8 ? 2.0 : 1.0; });
  ViewOptions options;
  options.samples = 6;
  const ViewResult all = renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options);
  options.noise = .002;
  RunContext one, two;
  one.threads = 1;
  two.threads = 2;
  const ViewResult some = renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options, one);
  EXPECT_EQ(all.samples, 36 * 256 * 256);
  EXPECT_LT(some.samples, all.samples / 2);
  EXPECT_GT(some.samples, 4 * 256 * 256);
  double worst = 0;
  for (std::size_t i = 0; i < all.image.planes[0].size(); ++i)
    worst = std::max(worst, std::abs(double(some.image.planes[0][i]) - all.image.planes[0][i]));
  EXPECT_LT(worst, .1 * at(all.image, "R", 128, 20));
  EXPECT_EQ(renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options, two).image.planes, some.image.planes);
  options.noise = 2;
  EXPECT_THROW((void)renderView(edge.medium, edge.light, edge.eye, kBlack, {}, options), Error);
}

// A slope of light is a slope in the picture: where steps or bricks show, second differences along a row stand out.
TEST(ViewSmoothness, NeitherStepsNorBricksShowOnAGradient) {
  const Domain domain = unitCube(64);
  const Medium medium = buildMedium({}, fog(1), domain);
  const RadianceVolume light = lightVolume(domain, [](const Vec3d& p) { return 1 + p[1] + .5 * p[2]; });
  // From aslant, so that rays cross bricks at every place of them.
  const Camera eye = camera({-4, -.3, .9}, {.5, .45, .52}, 240, 9, .35);
  const Image image = renderView(medium, light, eye, kBlack).image;
  for (const int y : {0, 4, 8})
    for (int x = 1; x + 1 < eye.resolution[0]; ++x) {
      const double before = at(image, "R", x - 1, y), here = at(image, "R", x, y), after = at(image, "R", x + 1, y);
      ASSERT_GT(here, 0);
      ASSERT_LT(std::abs(before - 2 * here + after), 3e-4 * here) << x << ' ' << y;
    }
}

// The same picture in steps of one voxel and of a tenth: no error of theirs stands along the faces of bricks.
TEST(ViewSmoothness, StepsOfOneVoxelAreFineEnough) {
  const Domain domain = unitCube(48);
  const Medium medium = sampleMedium(domain, fog(1), indexField("linear"));
  const RadianceVolume light =
      lightVolume(domain, [](const Vec3d& p) { return 1.5 + std::sin(9 * p[0]) * std::cos(7 * p[1] + 4 * p[2]); });
  const Camera eye = camera({-3, .2, .6}, {.5, .5, .5}, 65, 65, 14);
  ViewOptions fine;
  fine.step = .1;
  const Image image = renderView(medium, light, eye, kBlack).image,
              reference = renderView(medium, light, eye, kBlack, {}, fine).image;
  for (int y = 16; y < 48; ++y)
    for (int x = 16; x < 48; ++x)
      ASSERT_NEAR(at(image, "R", x, y), at(reference, "R", x, y), 2e-3 * at(reference, "R", x, y)) << x << ' ' << y;
}

// Light of lamps in fog, scattered once: Beer-Lambert from the face of the box (or from the lamp) to the point and from
// there to the camera, the inverse square of the distance, and the phase function. Far from the lamp rays cross whole
// bricks in a step; near it, they may not.
TEST(ViewClosedForms, ALampInFogIsScatteredOnce) {
  const Domain domain = unitCube(128);
  const double t = .8;
  for (const double g : {0.0, .5})
    for (const Vec3d& place : {Vec3d{.2, .3, .75}, Vec3d{.5, .5, 3}}) {
      const Medium medium = buildMedium({}, fog(t, g), domain);
      const Light light = lamp(place, {3, 3, 3});
      const RadianceVolume radiance = tracePhotons(medium, std::span(&light, 1)).radiance;
      const Camera eye = camera({-2, .1, .4}, {.5, .5, .5}, 41, 31, 22);
      const Image image = renderView(medium, radiance, eye, kBlack).image;
      for (int y = 3; y < 31; y += 6)
        for (int x = 2; x < 41; x += 9) {
          double nearest = 1e300;
          const double expected = alongRay(eye, x, y, 4000, [&](const Vec3d& p, double way) {
            double squared = 0, toFace = 1e300, cosine = 0, toEye = 0;
            for (int a = 0; a < 3; ++a) {
              squared += (p[a] - place[a]) * (p[a] - place[a]);
              toEye += (p[a] - eye.position[a]) * (p[a] - eye.position[a]);
            }
            const double r = std::sqrt(squared);
            for (int a = 0; a < 3; ++a) {
              const double d = (p[a] - place[a]) / r;
              cosine += d * (eye.position[a] - p[a]) / std::sqrt(toEye);
              toFace = std::min(toFace, d > 0 ? p[a] / d : (p[a] - 1) / d);
            }
            nearest = std::min(nearest, r);
            const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
            return t * 3 / squared * std::exp(-t * std::min(r, toFace)) * phase * std::exp(-t * way);
          });
          if (nearest < .08) continue; // voxels are too large there
          ASSERT_NEAR(at(image, "direct.G", x, y), expected, 4e-3 * expected)
              << g << ' ' << place[2] << ' ' << x << ' ' << y;
        }
    }
}

} // namespace
} // namespace volcaustic::test
