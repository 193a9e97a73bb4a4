// The bodies of a scene, for a simulation of them.
#pragma once

#include <volcaustic/run_context.h>
#include <volcaustic/scene.h>
#include <volcaustic/simulation.h>

#include <span>
#include <string>
#include <vector>

namespace volcaustic::cli {

/// A body, and where it is in the scene.
struct SceneBody {
  RigidBody body;
  std::size_t object = 0; ///< index; no meaning for receivers
  bool receiver = false;
};

/// Meshes and shapes that are visible as bodies, receivers as fixed ones. Those without a name are called objects.0,
/// receivers.0 and so on. Shapes are triangulated, deformed objects deformed.
std::vector<SceneBody> sceneBodies(const Scene& scene, const RunContext& ctx);

/// "NAME=1,2,3": a body and so many numbers. \throws Error(Usage) "FLAG TEXT: ..." with the names there are.
struct NamedNumbers {
  std::size_t body;
  std::vector<double> numbers;
};
NamedNumbers namedNumbers(const char* flag, const std::string& text, std::size_t count,
                          std::span<const SceneBody> bodies);
/// The body of that name. \throws as above.
std::size_t bodyNamed(const char* flag, const std::string& name, std::span<const SceneBody> bodies);

} // namespace volcaustic::cli
