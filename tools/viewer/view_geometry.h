// Between the world, the camera's picture and a person's hand. No window is needed for any of it.
#pragma once

#include <volcaustic/mesh.h>
#include <volcaustic/scene.h>

#include <array>
#include <optional>

namespace volcaustic::viewer {

using Point = std::array<double, 2>;

/// Where a picture lies in the window, pixels from the top left corner.
struct PictureArea {
  double x = 0, y = 0, width = 1, height = 1;
  [[nodiscard]] bool contains(const Point& p) const {
    return p[0] >= x && p[1] >= y && p[0] < x + width && p[1] < y + height;
  }
};
/// The largest area of the picture's proportions in the middle of `room`.
PictureArea fitted(const PictureArea& room, const std::array<int, 2>& resolution);

/// A camera and the area that shows its picture.
class Projection {
public:
  Projection(const Camera& camera, const PictureArea& area);
  /// Place in the window; nothing for what is not in front of the camera.
  [[nodiscard]] std::optional<Point> toWindow(const Vec3d& pWorld) const;
  /// Unit direction from the camera through a place in the window.
  [[nodiscard]] Vec3d rayThrough(const Point& p) const;
  /// Distance along the line of sight, world.
  [[nodiscard]] double depthOf(const Vec3d& pWorld) const;
  /// What a movement in the window is in the world, at a depth, in the plane across the line of sight.
  [[nodiscard]] Vec3d inWorld(const Point& movement, double depth) const;

private:
  Vec3d mEye, mRight, mUp, mForward;
  PictureArea mArea;
  double mPerPixel; ///< at depth 1
};

/// Turns about the target: a window's height is half a turn. The camera stays off the poles.
Camera orbited(Camera camera, const Point& movement, double windowHeight);
/// Moves eye and target so that what is at the target's depth follows the hand.
Camera panned(Camera camera, const Point& movement, const PictureArea& area);
/// Towards the target for positive notches; each takes a tenth of the way.
Camera zoomed(Camera camera, double notches);

/// Distance along the ray to the mesh, in units of the direction; nothing where it misses.
std::optional<double> hit(const Mesh& mesh, const Vec3d& origin, const Vec3d& direction);

} // namespace volcaustic::viewer
