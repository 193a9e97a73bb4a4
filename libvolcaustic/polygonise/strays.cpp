#include "polygonise/strays.h"

#include "polygonise/points.h"

#include <algorithm>

namespace volcaustic {

namespace {

/// In cells: vertices of a face that are closer to each other leave slivers.
constexpr double kLeastDistance = .02;
/// In cells: distance from the surface that a vertex in another's way may cost.
constexpr double kHarmless = 1e-3;

struct Stray {
  std::uint32_t vertex;
  Vec3d outside, within;          // of the edge or corner, as of PatchVertex
  Vec3d aside;                    // on the surface, clear of it
  std::vector<std::size_t> quads; // that it is a corner of
};

/// How well faces lie on the surface.
struct Fit {
  int turned = 0;      // triangles that face inwards
  double distance = 0; // greatest, of samples
};

class StrayMover {
public:
  explicit StrayMover(QuadMesh& mesh) : mMesh(mesh) {}

  std::uint64_t run(const RunContext& ctx) {
    collect();
    // What holds one back may itself be moved later.
    moveOutside(ctx);
    moveOutside(ctx);
    for (const Stray& stray : mStrays) mMesh.positions[stray.vertex] = stray.within;
    moveOutside(ctx);
    for (const Stray& stray : mStrays)
      if (isInTheWay(stray, mMesh.positions[stray.vertex])) move(stray, stray.aside, true);
    return mEvaluations;
  }

private:
  void collect() {
    constexpr std::uint32_t kNone = 0xffffffff;
    std::vector<std::uint32_t> strayOf;
    for (std::size_t b = 0; b < mMesh.blockCount(); ++b)
      for (const BlockSurface::Stray& stray : mMesh.surface(b).strays) {
        if (strayOf.empty()) strayOf.assign(mMesh.positions.size(), kNone);
        const auto vertex = static_cast<std::uint32_t>(mMesh.firstVertex(b) + stray.vertex);
        strayOf[vertex] = static_cast<std::uint32_t>(mStrays.size());
        mStrays.push_back({vertex, stray.outside, stray.within, mMesh.positions[vertex], {}});
      }
    if (mStrays.empty()) return;
    for (std::size_t q = 0; q < mMesh.quadCount(); ++q)
      for (const std::uint32_t vertex : mMesh.quad(q))
        if (strayOf[vertex] != kNone) mStrays[strayOf[vertex]].quads.push_back(q);
  }

  void moveOutside(const RunContext& ctx) {
    std::erase_if(mStrays, [&](const Stray& stray) {
      ctx.throwIfCancelled();
      return !isInTheWay(stray, stray.outside) && move(stray, stray.outside, false);
    });
  }

  /// Whether it would come too close to another vertex of its faces.
  [[nodiscard]] bool isInTheWay(const Stray& stray, const Vec3d& position) const {
    for (const std::size_t q : stray.quads)
      for (const std::uint32_t other : mMesh.quad(q))
        if (other != stray.vertex &&
            length(difference(mMesh.positions[other], position)) < kLeastDistance * mMesh.cellSize())
          return true;
    return false;
  }

  /// Moves a vertex if that brings its faces nearer to the surface, or at least does no harm where that is enough.
  bool move(const Stray& stray, const Vec3d& target, bool isEnough) {
    Vec3d& position = mMesh.positions[stray.vertex];
    const Fit before = fitOf(stray);
    const Vec3d old = position;
    position = target;
    const Fit after = fitOf(stray);
    const bool isGood = after.distance < before.distance ||
                        (isEnough && after.distance <= std::max(before.distance, kHarmless * mMesh.cellSize()));
    if (isGood && after.turned <= before.turned) return true;
    position = old;
    return false;
  }

  Fit fitOf(const Stray& stray) {
    Fit fit;
    for (const std::size_t q : stray.quads) addFace(q, fit);
    return fit;
  }

  /// Samples are the middles of the triangles and of their edges.
  void addFace(std::size_t q, Fit& fit) {
    const std::size_t block = mMesh.blockOfQuad(q);
    const auto triangles = mMesh.triangles(mMesh.quad(q), mMesh.crossing(block, q));
    mPoints.clear();
    for (const auto& t : triangles) {
      const Vec3d &a = mMesh.positions[t[0]], &b = mMesh.positions[t[1]], &c = mMesh.positions[t[2]];
      mPoints.add(along(between(a, b), difference(c, between(a, b)), 1.0 / 3));
      mPoints.add(between(a, b));
      mPoints.add(between(b, c));
      mPoints.add(between(c, a));
    }
    PointEvaluator evaluator(mMesh.block(block).program, mScratch);
    evaluator.gradients(mPoints, mValues);
    mEvaluations += evaluator.count();
    for (std::size_t i = 0; i < mPoints.size(); ++i)
      fit.distance = std::max(fit.distance, std::abs(mValues.tangent(i).distance));
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& t = triangles[i];
      const Vec3d& a = mMesh.positions[t[0]];
      const Vec3d normal = cross(difference(mMesh.positions[t[1]], a), difference(mMesh.positions[t[2]], a));
      fit.turned += dot(normal, mValues.tangent(4 * i).normal) >= 0; // the gradient points inwards
    }
  }

  QuadMesh& mMesh;
  std::vector<Stray> mStrays;
  ShapeScratch mScratch;
  PointArrays mPoints;
  ValueArrays mValues;
  std::uint64_t mEvaluations = 0;
};

} // namespace

std::uint64_t moveStrays(QuadMesh& mesh, const RunContext& ctx) { return StrayMover(mesh).run(ctx); }

} // namespace volcaustic
