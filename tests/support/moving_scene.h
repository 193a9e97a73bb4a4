// A small scene with something of everything that can move, and comparisons of results bit by bit.
#pragma once

#include "support/solids.h"
#include "volcaustic/session.h"

#include <cstring>
#include <gtest/gtest.h>

namespace volcaustic::test {

/// A deformed mesh, a triangulated shape and a plain one, a sun, a lamp and a floor, at 24 voxels.
inline Scene movingScene() {
  Scene s;
  s.volume.automatic = false;
  s.volume.bounds = {{-1, -1, -1}, {1, 1, 1}};
  s.volume.resolution = 24;
  s.volume.ambient.attenuation = s.volume.ambient.scattering = {.1, .1, .1};
  SceneObject soft;
  soft.name = "soft";
  soft.mesh = std::make_shared<const Mesh>(ellipsoid({-.4, 0, 0}, {.3, .3, .3}, 12));
  Deformer pull;
  pull.type = DeformerType::Pull;
  pull.center = {-.1, 0, 0};
  pull.direction = {1, 0, 0};
  pull.radius = .3;
  pull.strength = -.1;
  soft.deform = {pull};
  SceneObject ball;
  ball.name = "ball";
  ball.shape = Shape::sphere(.25).translated({.4, .3, 0});
  SceneObject cube;
  cube.name = "cube";
  cube.shape = Shape::cuboid({.3, .3, .3}).translated({.4, -.4, .2});
  cube.triangulate = true;
  cube.polygonise.resolution = 12;
  s.objects = {soft, ball, cube};
  Light sun, lamp;
  sun.name = "sun";
  sun.direction = {.2, .1, -1};
  lamp.name = "lamp";
  lamp.type = LightType::Point;
  lamp.position = {0, 2, 2};
  s.lights = {sun, lamp};
  SceneReceiver floor;
  floor.name = "floor";
  floor.placement.translate = {0, 0, -.9};
  floor.placement.scale = {4, 4, 1};
  floor.resolution = 32;
  s.receivers = {floor};
  s.photons.grid = {48, 48};
  s.camera.resolution = {32, 24};
  return s;
}

inline bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

inline void expectSamePicture(const ViewResult& a, const ViewResult& b) {
  ASSERT_EQ(a.image.channels, b.image.channels);
  for (std::size_t c = 0; c < a.image.channels.size(); ++c)
    EXPECT_TRUE(sameBits(a.image.planes[c], b.image.planes[c])) << a.image.channels[c];
  EXPECT_EQ(a.steps, b.steps);
}

inline void expectSameLight(const PhotonResult& a, const PhotonResult& b) {
  const Domain& d = a.radiance.domain();
  ASSERT_EQ(d.dims, b.radiance.domain().dims);
  for (int x = 0; x < d.dims[0]; ++x)
    for (int y = 0; y < d.dims[1]; ++y)
      for (int z = 0; z < d.dims[2]; ++z) {
        ASSERT_EQ(a.radiance.fluence({x, y, z}), b.radiance.fluence({x, y, z})) << x << ' ' << y << ' ' << z;
        ASSERT_EQ(a.radiance.direction({x, y, z}), b.radiance.direction({x, y, z}));
      }
  EXPECT_EQ(a.balance.scattered, b.balance.scattered);
  EXPECT_EQ(a.balance.received, b.balance.received);
  EXPECT_EQ(a.balance.steps, b.balance.steps);
  const auto mapsA = a.receivers.maps(), mapsB = b.receivers.maps();
  ASSERT_EQ(mapsA.size(), mapsB.size());
  for (std::size_t i = 0; i < mapsA.size(); ++i)
    for (std::size_t c = 0; c < mapsA[i].image.planes.size(); ++c)
      EXPECT_TRUE(sameBits(mapsA[i].image.planes[c], mapsB[i].image.planes[c]));
}

/// The stages that ran since `before` runs.
inline std::vector<std::string> stagesSince(const Session& session, std::size_t before) {
  std::vector<std::string> stages;
  for (std::size_t i = before; i < session.runs().size(); ++i) stages.push_back(session.runs()[i].stage);
  return stages;
}

} // namespace volcaustic::test
