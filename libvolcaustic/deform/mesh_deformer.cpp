#include "deform/brushes.h"
#include "deform/handles.h"
#include "mesh/validate.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>

namespace volcaustic {

namespace {

/// Upper bound of what a deformation holds for each vertex: the surface, points, rotations and a factor twice.
constexpr std::uint64_t kBytesForVertex = 3000;
/// A handle's ball in parts of its radius, squared: what lies on it by the numbers given is in it, in spite of
/// rounding.
constexpr double kInBall = 1 + 1e-12;
constexpr int kMostIterations = 1000;

std::string placeOf(std::size_t step) { return "deform[" + std::to_string(step) + "]: "; }

bool finite(const Vec3d& v) {
  return std::ranges::all_of(v, [](double x) { return std::isfinite(x); });
}

void requireValid(const Deformer& d, std::size_t step) {
  const auto require = [&](bool right, const char* what) {
    if (!right) throw Error(ErrorKind::Usage, placeOf(step) + what);
  };
  require(finite(d.center) && finite(d.direction) && std::isfinite(d.strength),
          "center, direction and strength must be finite; give plain numbers");
  require(d.radius > 0 && std::isfinite(d.radius), "the radius must be above 0; it says which vertices are meant");
  require(finite(d.placement.translate) && finite(d.placement.rotate) && finite(d.placement.scale) &&
              finite(d.placement.shear),
          "the placement must be finite; give plain numbers");
  require(d.type != DeformerType::Twist || d.direction != Vec3d{0, 0, 0},
          "the direction has no length; give the axis of the twist, as 0, 0, 1");
  require(d.type != DeformerType::Smooth || (d.strength >= 0 && d.strength <= 1),
          "the strength is a part of smooth; give 0 to 1");
}

/// The last of several handles that hold a point has it.
std::vector<int> heldPoints(const DeformSurface& surface, std::span<const Deformer> handles, std::size_t firstStep) {
  std::vector<int> handleOf(surface.points.size(), kNoHandle);
  for (std::size_t h = 0; h < handles.size(); ++h) {
    bool any = false;
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
      if (!(ballPart(handles[h], surface.points[i]) <= kInBall)) continue;
      handleOf[i] = static_cast<int>(h);
      any = true;
    }
    if (!any)
      throw Error(ErrorKind::Usage, placeOf(firstStep + h) +
                                        "the handle holds no vertex; move its center to the surface, or give it a "
                                        "larger radius");
  }
  return handleOf;
}

} // namespace

struct MeshDeformer::State {
  std::shared_ptr<const Mesh> rest;
  DeformSurface surface;
  std::vector<HandleSolver> solvers; // of the last call: one for each run of handles

  HandleSolver solverFor(DeformMethod method, std::vector<PointRole> roles) {
    const auto found = std::ranges::find_if(solvers, [&](const HandleSolver& s) { return s.fits(method, roles); });
    if (found == solvers.end()) return {method, std::move(roles)};
    HandleSolver solver = std::move(*found);
    solvers.erase(found);
    return solver;
  }
};

MeshDeformer::MeshDeformer(std::shared_ptr<const Mesh> rest) {
  if (!rest) throw Error(ErrorKind::Usage, "deform: there is no mesh; give one");
  volcaustic::requireValid(*rest);
  DeformSurface surface = makeDeformSurface(*rest);
  mState = std::make_unique<State>(State{std::move(rest), std::move(surface), {}});
}

MeshDeformer::~MeshDeformer() = default;
MeshDeformer::MeshDeformer(MeshDeformer&&) noexcept = default;
MeshDeformer& MeshDeformer::operator=(MeshDeformer&&) noexcept = default;

const std::shared_ptr<const Mesh>& MeshDeformer::rest() const { return mState->rest; }

Mesh MeshDeformer::deform(std::span<const Deformer> steps, const DeformOptions& options, const RunContext& ctx) {
  if (options.iterations < 1 || options.iterations > kMostIterations)
    throw Error(ErrorKind::Usage, "deform: iterations must be 1 to " + std::to_string(kMostIterations) + "; try 10");
  for (std::size_t i = 0; i < steps.size(); ++i) requireValid(steps[i], i);
  const DeformSurface& surface = mState->surface;
  ctx.requireMemory(surface.points.size() * kBytesForVertex, "deforming the mesh");

  std::vector<Vec3d> points = surface.points;
  std::vector<HandleSolver> used;
  const auto isHandle = [](const Deformer& d) { return d.type == DeformerType::Handle; };
  for (std::size_t i = 0; i < steps.size();) {
    ctx.throwIfCancelled();
    std::size_t end = i + 1;
    if (isHandle(steps[i])) {
      while (end < steps.size() && isHandle(steps[end])) ++end;
      const std::span<const Deformer> handles = steps.subspan(i, end - i);
      const std::vector<int> handleOf = heldPoints(surface, handles, i);
      used.push_back(mState->solverFor(options.method, rolesUnder(surface, handleOf)));
      used.back().solve(points, surface, handles, handleOf, options.iterations, ctx);
    } else {
      applyBrush(points, surface, steps[i], placeOf(i), ctx);
    }
    if (!std::ranges::all_of(points, finite))
      throw Error(ErrorKind::Usage, placeOf(i) + "moves vertices beyond all numbers; use less strength or scale");
    i = end;
  }
  mState->solvers = std::move(used);

  Mesh mesh = *mState->rest;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t p = surface.pointOf[v];
    if (points[p] != surface.points[p]) mesh.positions[v] = points[p];
  }
  return mesh;
}

Mesh deformed(const Mesh& mesh, std::span<const Deformer> steps, const DeformOptions& options, const RunContext& ctx) {
  // Without an owner: the deformer is gone before the mesh is.
  return MeshDeformer(std::shared_ptr<const Mesh>(std::shared_ptr<void>(), &mesh)).deform(steps, options, ctx);
}

} // namespace volcaustic
