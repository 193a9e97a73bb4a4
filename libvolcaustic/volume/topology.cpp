#include "volcaustic/topology.h"

#include "core/parallel.h"
#include "mesh/validate.h"
#include "volcaustic/error.h"
#include "volume/topology_stitch.h"

#include <numeric>
#include <unordered_map>

namespace volcaustic {

namespace {

double meanEdge(const WeldedSurface& s) {
  double sum = 0;
  for (const TriangleCorners& t : s.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3d d = difference(s.positions[t[k]], s.positions[t[(k + 1) % 3]]);
      sum += std::sqrt(dot(d, d));
    }
  return sum / (3.0 * static_cast<double>(s.triangles.size()));
}

void requireOptions(const TopologyOptions& o) {
  const auto require = [](const char* name, double value) {
    if (!(value >= 0 && std::isfinite(value)))
      throw Error(ErrorKind::Usage,
                  std::string(name) + ": " + std::to_string(value) + " is no length; give 0 or a positive number");
  };
  require("gap", o.gap);
  require("blend", o.blend);
  require("neck", o.neck);
  require("remeshVoxel", o.voxelSize);
}

TopologyLengths lengthsFor(const WeldedSurface& s, const TopologyOptions& o) {
  TopologyLengths lengths{o.voxelSize > 0 ? o.voxelSize : meanEdge(s) / 2, o.gap, o.blend, o.neck};
  if (lengths.gap == 0) lengths.gap = 2 * lengths.voxelSize;
  if (lengths.neck == 0) lengths.neck = 4 * lengths.voxelSize;
  constexpr double kMostVoxels = 1 << 26;
  for (const Vec3d& p : s.positions)
    for (const double x : p)
      if (!(std::abs(x) + lengths.gap + lengths.blend + lengths.neck < kMostVoxels * lengths.voxelSize))
        throw Error(ErrorKind::Input, "remeshVoxel: " + std::to_string(lengths.voxelSize) +
                                          " is too small for the mesh; take larger voxels");
  return lengths;
}

/// How the triangles' directions along each edge add up, new ones less those that are gone: the old surface is closed,
/// so the new one is where all sums are zero.
bool isClosed(const WeldedSurface& s, const std::vector<std::uint32_t>& faces, const RemadeSurface& remade) {
  std::unordered_map<std::uint64_t, int> sums;
  const auto add = [&](const TriangleCorners& t, int sign) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      sums[std::uint64_t{std::min(a, b)} << 32 | std::max(a, b)] += a < b ? sign : -sign;
    }
  };
  for (const TriangleCorners& t : remade.triangles) add(t, 1);
  std::vector<bool> isKept(s.triangles.size(), false);
  for (const std::uint32_t f : remade.kept) isKept[f] = true;
  for (const std::uint32_t f : faces)
    if (!isKept[f]) add(s.triangles[f], -1);
  return std::all_of(sums.begin(), sums.end(), [](const auto& sum) { return sum.second == 0; });
}

/// One surface that changes on its own: its parts and what becomes of them.
class Remaker {
public:
  Remaker(const WeldedSurface& surface, const TopologyLengths& lengths, Topology topology, const RunContext& ctx)
      : mSurface(surface), mLengths(lengths), mTopology(topology), mCtx(ctx) {}

  /// Of part `part` of `parts`, or where they merge of all of them. Empty where nothing changes.
  std::optional<RemadeSurface> remake(const SurfaceParts& parts, std::size_t part) const {
    const std::vector<std::uint32_t> faces = facesOf(parts, part);
    const StitchRules rules = rulesFor(parts, part);
    const LevelSet set = levelSet(parts, part, false);
    if (!set.anyChange() && !(rules.stays && anyBuried(parts))) return std::nullopt;
    constexpr int kAttempts = 8; // each with a border elsewhere
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      constexpr double kInwards = 0.15; // voxels from one attempt to the next
      const std::vector<float> level =
          distanceFromChange(set, (kMargin - kInwards * attempt) * mLengths.voxelSize, mCtx);
      std::optional<RemadeSurface> remade = stitched(mSurface, faces, set, level, rules, mCtx);
      if (remade && isClosed(mSurface, faces, *remade)) return remade;
      mCtx.throwIfCancelled();
    }
    return replaced(mSurface, levelSet(parts, part, true), rules, mCtx);
  }

  /// The triangles that remake() replaces.
  [[nodiscard]] std::vector<std::uint32_t> facesOf(const SurfaceParts& parts, std::size_t part) const {
    if (mTopology != Topology::Merge) return parts[part]->faces();
    std::vector<std::uint32_t> faces;
    for (const auto& p : parts) faces.insert(faces.end(), p->faces().begin(), p->faces().end());
    std::sort(faces.begin(), faces.end());
    return faces;
  }

private:
  [[nodiscard]] LevelSet levelSet(const SurfaceParts& parts, std::size_t part, bool everywhere) const {
    if (mTopology == Topology::Merge) return mergedParts(parts, mLengths, everywhere, mCtx);
    if (mTopology == Topology::Keep) return keptApart(parts, part, mLengths, everywhere, mCtx);
    return splitAtNecks(parts, mLengths, everywhere, mCtx);
  }

  [[nodiscard]] StitchRules rulesFor(const SurfaceParts& parts, std::size_t part) const {
    if (mTopology != Topology::Merge)
      return {[&parts, part](const Vec3d& p, double within) { return parts[part]->closest(p, within); }, {}};
    return {[&parts](const Vec3d& p, double within) {
              ClosestPoint best;
              for (const auto& one : parts) {
                const ClosestPoint c = one->closest(p, std::min(within, best.distance));
                if (c.distance < best.distance) best = c;
              }
              return best;
            },
            [this, &parts](const Vec3d& p) {
              int winding = 0;
              for (const auto& one : parts)
                if (areNear(one->tree().bounds(), {p, p}, 0)) winding += windingNumber(mSurface, one->faces(), p);
              return winding <= 0;
            }};
  }

  /// Whether a part lies in another one as a whole. Parts whose surfaces meet change anyway.
  [[nodiscard]] bool anyBuried(const SurfaceParts& parts) const {
    for (const auto& inner : parts) {
      const Vec3d& p = inner->tree().corner(0, 0);
      for (const auto& outer : parts)
        if (outer != inner && areNear(outer->tree().bounds(), {p, p}, 0) &&
            windingNumber(mSurface, outer->faces(), p) > 0)
          return true;
    }
    return false;
  }

  const WeldedSurface& mSurface;
  TopologyLengths mLengths;
  Topology mTopology;
  const RunContext& mCtx;
};

SurfaceParts makeParts(const WeldedSurface& s, double voxelSize, const RunContext& ctx) {
  std::vector<std::vector<std::uint32_t>> faces(s.partCount);
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t) faces[s.partOf[t]].push_back(t);
  SurfaceParts parts(faces.size());
  parallelFor(static_cast<std::int64_t>(parts.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p)
      parts[p] = std::make_unique<SurfacePart>(s, std::move(faces[p]), voxelSize, ctx);
  });
  return parts;
}

/// Parts that may have to do with each other, by their boxes.
std::vector<SurfaceParts> neighbours(SurfaceParts parts, double reach) {
  std::vector<std::size_t> group(parts.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t q = 0; q < p; ++q) {
      if (group[p] == group[q] || !areNear(parts[p]->tree().bounds(), parts[q]->tree().bounds(), reach)) continue;
      const std::size_t from = std::max(group[p], group[q]), to = std::min(group[p], group[q]);
      std::replace(group.begin(), group.end(), from, to);
    }
  std::vector<SurfaceParts> groups(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) groups[group[p]].push_back(std::move(parts[p]));
  std::erase_if(groups, [](const SurfaceParts& g) { return g.empty(); });
  return groups;
}

/// Collects what stays and what is new into a mesh.
class Assembler {
public:
  Assembler(const Mesh& mesh, const WeldedSurface& surface) : mMesh(mesh), mSurface(surface) {}

  void keep(const std::vector<std::uint32_t>& faces) {
    for (const std::uint32_t f : faces) mKept.push_back(mSurface.meshFace[f]);
  }
  void add(const RemadeSurface& remade, const SurfaceParts& parts) {
    keep(remade.kept);
    std::unordered_map<std::uint32_t, std::uint32_t> named;
    for (std::size_t i = 0; i < remade.triangles.size(); ++i) {
      TriangleCorners t = remade.triangles[i];
      if (!mMesh.triangleGroup.empty()) mNew.triangleGroup.push_back(groupOf(remade, i, parts));
      for (std::uint32_t& v : t) {
        if (v < mSurface.positions.size()) {
          v = mSurface.meshVertex[v];
          continue;
        }
        const auto next = static_cast<std::uint32_t>(mMesh.positions.size() + mNew.positions.size());
        const auto [entry, isNew] = named.try_emplace(v, next);
        if (isNew) mNew.positions.push_back(remade.positions[v]);
        v = entry->second;
      }
      mNew.triangles.push_back(t);
    }
  }

  /// Kept triangles first, in their order, over those vertices that are in use.
  TopologyResult take() {
    TopologyResult result;
    std::sort(mKept.begin(), mKept.end());
    result.keptTriangles = mKept.size();
    result.newTriangles = mNew.triangles.size();
    Mesh& mesh = result.mesh;
    mesh.groupNames = mMesh.groupNames;
    for (const std::uint32_t f : mKept) {
      mesh.triangles.push_back(mMesh.triangles[f]);
      if (!mMesh.triangleGroup.empty()) mesh.triangleGroup.push_back(mMesh.triangleGroup[f]);
    }
    mesh.triangles.insert(mesh.triangles.end(), mNew.triangles.begin(), mNew.triangles.end());
    mesh.triangleGroup.insert(mesh.triangleGroup.end(), mNew.triangleGroup.begin(), mNew.triangleGroup.end());
    constexpr std::uint32_t kUnused = 0xffffffffu;
    std::vector<std::uint32_t> number(mMesh.positions.size() + mNew.positions.size(), kUnused);
    for (const TriangleCorners& t : mesh.triangles)
      for (const std::uint32_t v : t) number[v] = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] == kUnused) continue;
      number[v] = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(v < mMesh.positions.size() ? mMesh.positions[v]
                                                          : mNew.positions[v - mMesh.positions.size()]);
    }
    for (TriangleCorners& t : mesh.triangles)
      for (std::uint32_t& v : t) v = number[v];
    return result;
  }

private:
  [[nodiscard]] std::uint32_t groupOf(const RemadeSurface& remade, std::size_t i, const SurfaceParts& parts) const {
    std::uint32_t face = remade.cutFrom[i];
    if (face == RemadeSurface::kNone) {
      Vec3d centre{0, 0, 0};
      for (const std::uint32_t v : remade.triangles[i])
        for (int k = 0; k < 3; ++k) centre[k] += remade.positions[v][k] / 3;
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& part : parts) {
        const ClosestPoint c = part->tree().closest(centre, nearest);
        if (!(c.distance < nearest)) continue;
        nearest = c.distance;
        face = part->faces()[c.triangle];
      }
    }
    return mMesh.triangleGroup[mSurface.meshFace[face]];
  }

  const Mesh& mMesh;
  const WeldedSurface& mSurface;
  std::vector<std::uint32_t> mKept; ///< triangles of the mesh
  Mesh mNew;                        ///< its vertices follow those of the mesh
};

/// Remakes each part on its own, or what may merge at once. False where nothing changed.
bool remakeAll(const WeldedSurface& surface, const TopologyLengths& lengths, Topology topology, Assembler& result,
               const RunContext& ctx) {
  const double reach = topology == Topology::Split ? -std::numeric_limits<double>::infinity()
                                                   : std::max({2 * lengths.blend, lengths.gap, lengths.voxelSize * 4});
  std::vector<SurfaceParts> groups = neighbours(makeParts(surface, lengths.voxelSize, ctx), reach);
  const Remaker remaker(surface, lengths, topology, ctx);
  bool changed = false;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    ctx.progress("topology", static_cast<double>(g) / static_cast<double>(groups.size()));
    const SurfaceParts& parts = groups[g];
    const bool together = topology == Topology::Merge;
    for (std::size_t part = 0; part < (together ? 1 : parts.size()); ++part) {
      const std::optional<RemadeSurface> remade = remaker.remake(parts, part);
      changed |= remade.has_value();
      if (remade)
        result.add(*remade, parts);
      else
        result.keep(remaker.facesOf(parts, part));
    }
  }
  ctx.progress("topology", 1);
  return changed;
}

TopologyResult unchanged(const Mesh& mesh, std::uint64_t shells) {
  return {mesh, mesh.triangles.size(), 0, shells, shells};
}

} // namespace

TopologyResult controlTopology(const Mesh& mesh, const TopologyOptions& options, const RunContext& ctx) {
  requireOptions(options);
  requireValid(mesh);
  if (options.topology == Topology::Free) {
    MeshReport report;
    return unchanged(mesh, analyseEdges(weld(mesh), report).count);
  }
  const WeldedSurface surface = weldedSurface(mesh, ctx);
  if (surface.triangles.empty()) return unchanged(mesh, surface.shellCount);
  const TopologyLengths lengths = lengthsFor(surface, options);
  Assembler assembler(mesh, surface);
  if (!remakeAll(surface, lengths, options.topology, assembler, ctx)) return unchanged(mesh, surface.shellCount);
  TopologyResult result = assembler.take();
  MeshReport report;
  result.partsBefore = surface.shellCount;
  result.partsAfter = analyseEdges(weld(result.mesh), report).count;
  return result;
}

} // namespace volcaustic
