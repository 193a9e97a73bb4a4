// The parts of the viewer that need no window: geometry of hand and eye, scripts, colours.

#include "display.h"
#include "script.h"
#include "support/solids.h"
#include "view_geometry.h"
#include "volcaustic/error.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace volcaustic::test {

using namespace viewer;

namespace {

Camera camera() {
  Camera c;
  c.position = {1, -4, 2};
  c.target = {.2, .1, .3};
  return c;
}
double distance(const Vec3d& a, const Vec3d& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }
const PictureArea kArea{40, 20, 800, 600};

} // namespace

TEST(ViewerGeometry, WhatIsSeenAtAPlaceLiesOnItsRay) {
  const Projection projection(camera(), kArea);
  for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{.7, -.2, .9}, Vec3d{-1, 1, 0}}) {
    const auto at = projection.toWindow(p);
    ASSERT_TRUE(at);
    const Vec3d d = projection.rayThrough(*at), eye = camera().position;
    const double away = distance(p, eye);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(eye[a] + away * d[a], p[a], 1e-12);
  }
  const auto centre = projection.toWindow(camera().target);
  EXPECT_NEAR((*centre)[0], 440, 1e-9);
  EXPECT_NEAR((*centre)[1], 320, 1e-9);
  EXPECT_FALSE(projection.toWindow({2, -9, 4}));
}

TEST(ViewerGeometry, WhatIsDraggedStaysUnderTheHand) {
  const Projection projection(camera(), kArea);
  const Vec3d p{.4, .2, -.1}, shift = projection.inWorld({30, -50}, projection.depthOf(p));
  const auto before = projection.toWindow(p),
             after = projection.toWindow({p[0] + shift[0], p[1] + shift[1], p[2] + shift[2]});
  EXPECT_NEAR((*after)[0] - (*before)[0], 30, 1e-9);
  EXPECT_NEAR((*after)[1] - (*before)[1], -50, 1e-9);
  const Camera moved = panned(camera(), {30, -50}, kArea);
  const auto target = Projection(moved, kArea).toWindow(camera().target);
  EXPECT_NEAR((*target)[0], 440 + 30, 1e-9);
  EXPECT_NEAR((*target)[1], 320 - 50, 1e-9);
}

TEST(ViewerGeometry, OrbitsKeepTheirDistanceAndStayOffThePoles) {
  const double radius = distance(camera().position, camera().target);
  for (const Point& movement : {Point{100, 0}, Point{-37, 250}, Point{0, 5000}, Point{0, -5000}}) {
    const Camera c = orbited(camera(), movement, 600);
    EXPECT_NEAR(distance(c.position, c.target), radius, 1e-9);
    EXPECT_LT(std::abs(c.position[2] - c.target[2]), radius * .99999);
    EXPECT_EQ(c.target, camera().target);
  }
  const Camera half = orbited(camera(), {600, 0}, 600);
  EXPECT_NEAR(half.position[0], .2 - .8, 1e-9); // half a turn about the vertical line through the target
  EXPECT_NEAR(half.position[1], .1 + 4.1, 1e-9);
  EXPECT_NEAR(distance(zoomed(camera(), 2).position, camera().target), .81 * radius, 1e-12);
}

TEST(ViewerGeometry, FittedAreasKeepProportions) {
  const PictureArea wide = fitted({0, 0, 1000, 300}, {400, 300}), tall = fitted({10, 0, 200, 900}, {400, 300});
  EXPECT_DOUBLE_EQ(wide.width, 400);
  EXPECT_DOUBLE_EQ(wide.x, 300);
  EXPECT_DOUBLE_EQ(tall.height, 150);
  EXPECT_DOUBLE_EQ(tall.y, 375);
  EXPECT_TRUE(tall.contains({10, 375}));
  EXPECT_FALSE(tall.contains({210, 400}));
}

TEST(ViewerGeometry, RaysHitTheNearerSide) {
  const Mesh ball = ellipsoid({0, 0, 0}, {1, 1, 1}, 24);
  const auto at = hit(ball, {.01, -5, .02}, {0, 1, 0});
  ASSERT_TRUE(at);
  EXPECT_NEAR(*at, 4, .02);
  EXPECT_FALSE(hit(ball, {0, -5, 0}, {0, -1, 0}));
  EXPECT_FALSE(hit(ball, {1.1, -5, 0}, {0, 1, 0}));
}

TEST(ViewerDisplay, ColoursGrowBrighterAndStayInRange) {
  double last = -1;
  for (int i = 0; i <= 100; ++i) {
    const auto [r, g, b] = colourOf(i / 100.0);
    for (const double c : {r, g, b}) {
      EXPECT_GE(c, -.01);
      EXPECT_LE(c, 1.01);
    }
    const double luminance = .2126 * r + .7152 * g + .0722 * b;
    EXPECT_GT(luminance, last) << i;
    last = luminance;
  }
}

TEST(ViewerDisplay, HistogramsCountEverythingThatCounts) {
  const std::vector<float> values{0, .01f, .1f, 1, 10, 10, INFINITY};
  const Histogram linear = histogramOf(values, false, 10), decades = histogramOf(values, true, 3);
  EXPECT_EQ(linear.greatest, 10);
  EXPECT_EQ(linear.counts.front(), 3);
  EXPECT_EQ(linear.counts.back(), 2);
  EXPECT_EQ(decades.counts, (std::vector<float>{1, 1, 3}));
  EXPECT_EQ(decades.least, .01f);
  EXPECT_TRUE(histogramOf({0, 0}, true).greatest == 0);
}

TEST(ViewerDisplay, LayersOfAPicture) {
  Image image;
  image.width = image.height = 1;
  for (const char* channel : {"R", "G", "B", "A", "caustic.R", "caustic.G", "caustic.B", "depth.Z"}) image.add(channel);
  image.planes[1][0] = .5f;
  EXPECT_EQ(layersOf(image), (std::vector<std::string>{"picture", "caustic", "depth"}));
  EXPECT_EQ(displayed(image, "picture", 0).rgba, (std::vector<std::uint8_t>{0, 188, 0, 255}));
  EXPECT_EQ(displayed(image, "picture", 1).rgba[1], 255);
}

TEST(ViewerDisplay, SlicesOfLightAreShownByWhatIsLit) {
  VolumeSlice slice;
  slice.columns = 100;
  slice.rows = 2;
  slice.values.assign(200, Vec3f{0, 0, 0});
  for (int i = 0; i < 100; ++i) slice.values[static_cast<std::size_t>(i)] = {40, 20, 0};
  slice.values[0] = {4000, 0, 0}; // a caustic does not darken the rest
  EXPECT_EQ(whiteOf(slice), 40);
  const auto shown = displayed(slice, VolumeLayer::Radiance, {});
  EXPECT_EQ(shown.rgba[4], 255);
  EXPECT_EQ(shown.rgba[5], 188);
  EXPECT_EQ(displayed(slice, VolumeLayer::Radiance, {.exposure = -1}).rgba[4], 188);
  EXPECT_EQ(shown.rgba[4 * 150], 0);
  slice.values.assign(200, Vec3f{0, 0, 0});
  EXPECT_EQ(displayed(slice, VolumeLayer::Radiance, {}).rgba[0], 0);
}

TEST(ViewerScript, ReadsCommandsAndSaysWhereOneIsWrong) {
  const auto commands = parseScript("# a comment\nwait\n\ndrag 1 2 3.5 4 right # so\nset a.b = [1, 2]\n", "s");
  ASSERT_EQ(commands.size(), 3u);
  EXPECT_EQ(commands[1].line, 4);
  EXPECT_EQ(commands[1].arguments, (std::vector<std::string>{"1", "2", "3.5", "4", "right"}));
  EXPECT_EQ(commands[2].arguments, std::vector<std::string>{"a.b = [1, 2]"});
  EXPECT_EQ(numberOf("3.5"), 3.5);
  for (const char* bad : {"jump", "drag 1 2", "drag 1 2 3 four", "undo twice", "screenshot"}) try {
      (void)parseScript(std::string("\n") + bad, "s");
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      EXPECT_EQ(std::string(error.what()).find("s:2: "), 0u) << error.what();
    }
}

} // namespace volcaustic::test
