#include "mesh/validate.h"

#include "volcaustic/error.h"

#include <cmath>

namespace volcaustic {

void requireValid(const Mesh& mesh) {
  const auto fail = [](const std::string& what) { throw Error(ErrorKind::Input, "mesh: " + what); };
  constexpr std::size_t kMost = 0xffffffffu; // both are numbered in 32 bits
  if (mesh.positions.size() > kMost || mesh.triangles.size() > kMost)
    fail("more than 4294967295 vertices or triangles; split it");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    for (const double x : mesh.positions[i])
      if (!std::isfinite(x)) fail("vertex " + std::to_string(i) + " is not finite");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const std::uint32_t v : mesh.triangles[i])
      if (v >= mesh.positions.size())
        fail("triangle " + std::to_string(i) + " refers to vertex " + std::to_string(v) + " of " +
             std::to_string(mesh.positions.size()));
  if (mesh.triangleGroup.empty()) return;
  if (mesh.triangleGroup.size() != mesh.triangles.size()) fail("triangleGroup needs one entry for each triangle");
  for (const std::uint32_t group : mesh.triangleGroup)
    if (group >= mesh.groupNames.size())
      fail("a triangle is in group " + std::to_string(group) + ", which has no name");
}

} // namespace volcaustic
