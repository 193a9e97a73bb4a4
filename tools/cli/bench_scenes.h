// The scenes of `volcaustic bench`: data/scenes/paper, which is built into the program, and a glass ball.
#pragma once

#include <volcaustic/scene.h>

#include <span>
#include <string>
#include <vector>

namespace volcaustic::cli {

/// A row of VD's table: Intel Core i7 3820, NVIDIA GeForce GTX 1080 Ti, image 1024 x 768, 256^3 voxels, 1024^2 source
/// photons. Milliseconds.
struct PaperFigures {
  int objects;
  double triangles;        ///< rounded to thousands in the paper
  double occupiedCubeRoot; ///< occupied voxels, as the edge of a cube of as many
  double steps;            ///< photon steps
  double photonsTraced;    ///< that met the object
  double voxelisation, photonTracing;
  double everythingElse; ///< gradient, octree, merging, view and the rest
  double total, framesPerSecond;
};

/// The domain is the unit cube; the counts hold at 256 voxels along its edge.
struct BenchScene {
  std::string name;          ///< as --scene takes it
  const PaperFigures* paper; ///< null for scenes that the paper does not have
  Scene scene;               ///< its shapes polygonised: objects hold meshes in memory, in world space
  std::vector<Body> bodies;  ///< the same meshes
};

/// Their names: the paper's four first, in its order, then "ball".
std::span<const char* const> benchSceneNames();
/// How many of them are the paper's.
inline constexpr int kPaperScenes = 4;

/// Reads the scene and polygonises its shapes. \throws Error(Usage) for a name that is not in benchSceneNames().
BenchScene benchScene(const std::string& name);

struct BenchSize {
  int resolution = 256; ///< voxels along an axis
  int raster = 1024;    ///< source photons along each side
  bool fog = false;     ///< the box is filled with a thin scattering fog
};

/// The scene at this size, camera and all.
Scene sessionScene(const BenchScene& scene, const BenchSize& size);

} // namespace volcaustic::cli
