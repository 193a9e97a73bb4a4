#include "volume/topology_stitch.h"

#include "core/parallel.h"
#include "volume/topology_contour.h"
#include "volume/topology_cut.h"
#include "volume/topology_refine.h"
#include "volume/topology_zip.h"

#include <numeric>

namespace volcaustic {

namespace {

double squaredLength(const Vec3d& v) { return dot(v, v); }

bool anyCornerChanged(const LevelSet& set, const Vec3i& cell) {
  std::array<std::int64_t, 8> corners;
  return set.grid.cell(cell[0], cell[1], cell[2], corners) &&
         std::any_of(corners.begin(), corners.end(),
                     [&](std::int64_t c) { return set.changed[static_cast<std::size_t>(c)] != 0; });
}

/// Moves the contour's vertices to the surface: where nothing changed onto the old one itself, else to where the level
/// set is zero, within their cells.
void settle(Contour& contour, const LevelSet& set, const StitchRules& rules, const RunContext& ctx) {
  const double h = set.grid.voxelSize();
  parallelFor(static_cast<std::int64_t>(contour.positions.size()), 256, ctx,
              [&](std::int64_t begin, std::int64_t end, int) {
                for (std::int64_t i = begin; i < end; ++i) {
                  Vec3d& p = contour.positions[static_cast<std::size_t>(i)];
                  const Vec3i& cell = contour.cells[static_cast<std::size_t>(i)];
                  if (!anyCornerChanged(set, cell)) {
                    constexpr double kFarthest = 0.75; // voxels, beyond what a contour is off by
                    const ClosestPoint c = rules.closestOld(p, kFarthest * h);
                    if (c.found()) p = c.point;
                    continue;
                  }
                  for (int step = 0; step < 3; ++step) {
                    Vec3d slope;
                    const double value = set.grid.sample(set.value, p, 0, &slope);
                    const double squared = std::max(squaredLength(slope), 0.25); // of a distance it is 1
                    for (int k = 0; k < 3; ++k)
                      p[k] = std::clamp(p[k] - value * slope[k] / squared, h * cell[k], h * (cell[k] + 1));
                  }
                }
              });
}

/// Sets of vertices that polygons join.
class VertexSets {
public:
  explicit VertexSets(std::size_t count) : mParent(count) { std::iota(mParent.begin(), mParent.end(), 0u); }
  std::uint32_t find(std::uint32_t v) {
    for (; mParent[v] != v; v = mParent[v]) mParent[v] = mParent[mParent[v]];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    mParent[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<std::uint32_t> mParent;
};

class Stitcher {
public:
  Stitcher(const WeldedSurface& surface, const LevelSet& set, const std::vector<float>& level, const StitchRules& rules,
           const RunContext& ctx)
      : mSet(set), mLevel(level), mRules(rules), mCtx(ctx), mAt([&](const Vec3d& p) {
        return set.grid.sample(level, p, kStrip * set.grid.voxelSize());
      }) {
    mResult.positions = surface.positions;
  }

  std::optional<RemadeSurface> run(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces) {
    constexpr double kLongest = 4; // voxels
    const double h = mSet.grid.voxelSize();
    mOld = refinedNear(surface, faces, mSet.grid, mLevel, kStrip * h / 2, kLongest * h, mResult.positions);
    CutTriangles old = cutTriangles(mOld.triangles, mResult.positions, false, mAt);
    dropBuried(old);
    const std::vector<TriangleCorners> fresh = addContour();
    // Cut a little short, the new surface is drawn out to the old one's end and never folds back from it.
    constexpr double kShort = 0.3, kReach = 2; // voxels
    const CutTriangles added =
        cutTriangles(fresh, mResult.positions, true, [&](const Vec3d& p) { return mAt(p) + kShort * h; });
    Curves oldCurves, addedCurves;
    ZippedCurves zipped;
    if (!curvesOf(old.cut, oldCurves) || !curvesOf(added.cut, addedCurves) ||
        !zipCurves(oldCurves, addedCurves, kReach * h, mResult.positions, zipped))
      return std::nullopt;
    for (const std::uint32_t i : old.whole) keep(i);
    for (const CutTriangle& c : old.cut) addPieces(c, zipped.inFixed[c.from], mOld.source[c.source], {});
    for (const std::uint32_t i : added.whole) addTriangle(fresh[i], RemadeSurface::kNone);
    for (const CutTriangle& c : added.cut) addPieces(c, zipped.inAdded[c.from], RemadeSurface::kNone, zipped.sameAs);
    return std::move(mResult);
  }

private:
  using Renaming = std::unordered_map<std::uint32_t, std::uint32_t>;

  /// The contour's triangles, over the result's positions.
  std::vector<TriangleCorners> addContour() {
    const double reach = kStrip * mSet.grid.voxelSize() / 2;
    Contour contour = contourOf(
        mSet.grid, mSet.value,
        [&](const std::array<std::int64_t, 8>& corners) {
          return std::any_of(corners.begin(), corners.end(),
                             [&](std::int64_t c) { return mLevel[static_cast<std::size_t>(c)] < reach; });
        },
        mCtx);
    settle(contour, mSet, mRules, mCtx);
    const auto offset = static_cast<std::uint32_t>(mResult.positions.size());
    mResult.positions.insert(mResult.positions.end(), contour.positions.begin(), contour.positions.end());
    for (TriangleCorners& t : contour.triangles)
      for (std::uint32_t& v : t) v += offset;
    return std::move(contour.triangles);
  }

  /// Of what the cut left, takes away whatever hangs together and does not stay.
  void dropBuried(CutTriangles& old) {
    if (!mRules.stays) return;
    VertexSets sets(mResult.positions.size());
    for (const std::uint32_t i : old.whole) {
      sets.join(mOld.triangles[i][0], mOld.triangles[i][1]);
      sets.join(mOld.triangles[i][0], mOld.triangles[i][2]);
    }
    for (const CutTriangle& c : old.cut) {
      if (c.second != CutTriangle::kNone) sets.join(c.first, c.second);
      sets.join(c.first, c.from);
      sets.join(c.first, c.to);
    }
    // One triangle speaks for each patch: the largest, which rounding has the least say in.
    struct Speaker {
      double squaredArea = -1;
      Vec3d outside{0, 0, 0};
      bool stays = false;
    };
    std::unordered_map<std::uint32_t, Speaker> speakers;
    const auto offer = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      const Vec3d &p = mResult.positions[a], &q = mResult.positions[b], &r = mResult.positions[c];
      const Vec3d normal = cross(difference(q, p), difference(r, p));
      const double area = squaredLength(normal);
      Speaker& speaker = speakers[sets.find(a)];
      if (!(area > speaker.squaredArea)) return;
      const double step = area > 0 ? kOutside * mSet.grid.voxelSize() / std::sqrt(area) : 0;
      speaker.squaredArea = area;
      for (int k = 0; k < 3; ++k) speaker.outside[k] = (p[k] + q[k] + r[k]) / 3 + step * normal[k];
    };
    for (const std::uint32_t i : old.whole) offer(mOld.triangles[i][0], mOld.triangles[i][1], mOld.triangles[i][2]);
    for (const CutTriangle& c : old.cut) offer(c.first, c.from, c.to);
    for (auto& [set, speaker] : speakers) speaker.stays = mRules.stays(speaker.outside);
    const auto goes = [&](std::uint32_t vertex) { return !speakers.at(sets.find(vertex)).stays; };
    std::erase_if(old.whole, [&](std::uint32_t i) { return goes(mOld.triangles[i][0]); });
    std::erase_if(old.cut, [&](const CutTriangle& c) { return goes(c.first); });
  }

  void keep(std::uint32_t i) {
    if (mOld.whole[i])
      mResult.kept.push_back(mOld.source[i]);
    else
      addTriangle(mOld.triangles[i], mOld.source[i]);
  }
  void addTriangle(const TriangleCorners& t, std::uint32_t cutFrom) {
    mResult.triangles.push_back(t);
    mResult.cutFrom.push_back(cutFrom);
  }
  /// The rest of a triangle, as a fan around its first corner over the vertices of the cut.
  void addPieces(const CutTriangle& c, const std::vector<std::uint32_t>& between, std::uint32_t cutFrom,
                 const Renaming& names) {
    const auto named = [&](std::uint32_t v) {
      const auto entry = names.find(v);
      return entry == names.end() ? v : entry->second;
    };
    std::uint32_t previous = named(c.from);
    if (c.second != CutTriangle::kNone) addTriangle({c.first, c.second, previous}, cutFrom);
    for (const std::uint32_t v : between) {
      addTriangle({c.first, previous, v}, cutFrom);
      previous = v;
    }
    addTriangle({c.first, previous, named(c.to)}, cutFrom);
  }

  static constexpr double kOutside = 1e-3; // voxels

  const LevelSet& mSet;
  const std::vector<float>& mLevel;
  const StitchRules& mRules;
  const RunContext& mCtx;
  std::function<double(const Vec3d&)> mAt;
  RefinedTriangles mOld;
  RemadeSurface mResult;
};

} // namespace

std::optional<RemadeSurface> stitched(const WeldedSurface& surface, const std::vector<std::uint32_t>& faces,
                                      const LevelSet& set, const std::vector<float>& level, const StitchRules& rules,
                                      const RunContext& ctx) {
  return Stitcher(surface, set, level, rules, ctx).run(surface, faces);
}

RemadeSurface replaced(const WeldedSurface& surface, const LevelSet& set, const StitchRules& rules,
                       const RunContext& ctx) {
  Contour contour = contourOf(
      set.grid, set.value, [](const std::array<std::int64_t, 8>&) { return true; }, ctx);
  settle(contour, set, rules, ctx);
  RemadeSurface result;
  result.positions = surface.positions;
  const auto offset = static_cast<std::uint32_t>(result.positions.size());
  result.positions.insert(result.positions.end(), contour.positions.begin(), contour.positions.end());
  for (TriangleCorners t : contour.triangles) {
    for (std::uint32_t& v : t) v += offset;
    result.triangles.push_back(t);
  }
  result.cutFrom.assign(result.triangles.size(), RemadeSurface::kNone);
  return result;
}

} // namespace volcaustic
