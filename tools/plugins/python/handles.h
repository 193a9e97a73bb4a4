// What Python holds of meshes and pictures: shared with results of the library, which nobody writes to.
#pragma once

#include "common.h"

#include <memory>
#include <volcaustic/image.h>
#include <volcaustic/mesh.h>
#include <volcaustic/types.h>

namespace volcaustic::python {

/// Its vectors never change their size while Python can see them, so that views stay good.
struct MeshHandle {
  std::shared_ptr<const Mesh> mesh;
  bool writable = false; ///< made here from non-const memory, and nobody's but the handle's

  static MeshHandle own(Mesh mesh) { return {std::make_shared<Mesh>(std::move(mesh)), true}; }
  /// \throws Error(Input) for an index out of range: views let people write whatever they like.
  void check() const;
  [[nodiscard]] const std::shared_ptr<const Mesh>& checked() const {
    check();
    return mesh;
  }
};

/// Planes are views of their own; the vector of planes may grow, its elements do not.
struct ImageHandle {
  std::shared_ptr<const Image> image;
  bool writable = false;

  static ImageHandle own(Image image) { return {std::make_shared<Image>(std::move(image)), true}; }
};

/// A Placement, or a matrix of 3x4 or 4x4 whose last row is 0 0 0 1. \throws TypeError, Error(Usage).
Affine affineFrom(py::handle given);

} // namespace volcaustic::python
