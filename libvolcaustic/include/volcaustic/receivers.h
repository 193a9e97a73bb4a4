/// \file receivers.h
/// Opaque diffuse surfaces that light falls on, and their light maps.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/image.h"
#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace volcaustic {

/// A surface that collects direct and refracted light, shows it as a Lambertian reflector, and blocks all light. It has
/// one side: that from which its triangles run counter-clockwise. The other one is black.
struct Receiver {
  std::string name;
  /// Null: the unit square, [-1/2, 1/2]^2 in the xy plane, facing +z.
  std::shared_ptr<const Mesh> mesh;
  Affine placement = kIdentity; ///< of the mesh or the square in the world; one that mirrors keeps fronts outside
  Rgb albedo{0.8, 0.8, 0.8};
  int resolution = 512; ///< texels along the longer side of a rectangle; along each side of a mesh's atlas
  bool visible = true;  ///< to the camera; one that is not still collects light and casts shadows
};
inline constexpr int kMostReceiverTexels = 16384; ///< along a side

/// What a receiver has collected, as a picture that lies on its surface.
struct ReceiverMap {
  std::string name;
  /// Irradiance in W/m2: R, G, B, and its parts caustic.* and direct.*; rows from the top.
  Image image;
  Mesh mesh;           ///< the surface, world space
  bool isMesh = false; ///< false for a rectangle, whose map lies on it edge to edge
  /// Of the corners of each triangle: u to the right, v upwards, both 0 to 1.
  std::vector<std::array<std::array<float, 2>, 3>> textureCoordinates;
};

struct LitReceiverData; // internal storage

/// Receivers and the light that they have collected in a photon pass: what the camera sees of them. Immutable, cheap to
/// copy; empty where there are none.
class VOLCAUSTIC_API LitReceivers {
public:
  LitReceivers() = default;
  explicit LitReceivers(std::shared_ptr<const LitReceiverData> data) : mData(std::move(data)) {}
  [[nodiscard]] explicit operator bool() const { return mData != nullptr; }
  [[nodiscard]] const LitReceiverData& data() const { return *mData; }

  /// One for each receiver, in their order.
  [[nodiscard]] std::vector<ReceiverMap> maps() const;

private:
  std::shared_ptr<const LitReceiverData> mData;
};

/// Writes the picture (an .exr, or any format that writeImage knows), and for a mesh an .obj with texture coordinates
/// beside it, under the same name. \throws Error(File), Error(Usage).
VOLCAUSTIC_API void writeReceiverMap(const std::filesystem::path& path, const ReceiverMap& map,
                                     const ImageWriteOptions& options = {}, const RunContext& ctx = {});

} // namespace volcaustic
