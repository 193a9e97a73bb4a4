#include "mesh/topology.h"

#include "mesh/weld.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace volcaustic {

namespace {

/// Keys gathered in one bucket for each vertex, each bucket sorted: a sort of all in time linear in practice, because a
/// vertex has few edges. `emit(face, triangle, put)` calls put(vertex, key) as often as it likes.
class VertexBuckets {
public:
  template <class Emit>
  VertexBuckets(const WeldedMesh& mesh, Emit emit) : mBegin(std::size_t{mesh.vertexCount} + 1, 0) {
    const auto forEachKey = [&](auto put) {
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (!hasRepeatedCorner(mesh.triangles[i])) emit(static_cast<std::uint32_t>(i), mesh.triangles[i], put);
    };
    forEachKey([&](std::uint32_t v, std::uint64_t) { ++mBegin[v + 1]; });
    std::partial_sum(mBegin.begin(), mBegin.end(), mBegin.begin());
    mKeys.resize(mBegin.back());
    std::vector<std::uint64_t> end(mBegin.begin(), mBegin.end() - 1);
    forEachKey([&](std::uint32_t v, std::uint64_t key) { mKeys[end[v]++] = key; });
    for (std::size_t v = 0; v + 1 < mBegin.size(); ++v)
      sortBucket(mKeys.data() + mBegin[v], mKeys.data() + mBegin[v + 1]);
  }

  /// Calls visit(vertex, first, last) for every run of keys of one vertex that `same` holds for.
  template <class Same, class Visit>
  void forRuns(Same same, Visit visit) const {
    for (std::size_t v = 0; v + 1 < mBegin.size(); ++v) {
      const std::uint64_t* const end = mKeys.data() + mBegin[v + 1];
      for (const std::uint64_t* first = mKeys.data() + mBegin[v]; first != end;) {
        const std::uint64_t* last = first + 1;
        while (last != end && same(*first, *last)) ++last;
        visit(static_cast<std::uint32_t>(v), first, last);
        first = last;
      }
    }
  }

private:
  /// Most buckets hold three keys: inserting them costs half of what std::sort does.
  static void sortBucket(std::uint64_t* first, std::uint64_t* last) {
    constexpr std::ptrdiff_t kFew = 24;
    if (last - first > kFew) {
      std::sort(first, last);
      return;
    }
    for (std::uint64_t* next = first; next != last; ++next) {
      const std::uint64_t key = *next;
      std::uint64_t* place = next;
      for (; place != first && place[-1] > key; --place) *place = place[-1];
      *place = key;
    }
  }

  std::vector<std::uint64_t> mBegin, mKeys;
};

/// Sets of faces that know of each face whether it is wound like the set's first one or against it.
class OrientedSets {
public:
  struct Place {
    std::uint32_t root; ///< the first face of the set
    bool reversed;      ///< wound against it
  };

  explicit OrientedSets(std::size_t count) : mParent(count), mReversed(count, 0) {
    std::iota(mParent.begin(), mParent.end(), 0u);
  }

  Place find(std::uint32_t face) {
    bool reversed = false;
    while (mParent[face] != face) {
      const std::uint32_t parent = mParent[face];
      mReversed[face] ^= mReversed[parent]; // path halving: from here on against the grandparent
      mParent[face] = mParent[parent];
      reversed ^= mReversed[face] != 0;
      face = mParent[face];
    }
    return {face, reversed};
  }

  /// Joins the sets of two faces that are wound alike or against each other. False when they are in one set already
  /// and there the other way.
  bool join(std::uint32_t a, std::uint32_t b, bool opposed) {
    Place p = find(a), q = find(b);
    const bool reversed = (p.reversed ^ q.reversed) != opposed;
    if (p.root == q.root) return !reversed;
    if (p.root > q.root) std::swap(p, q);
    mParent[q.root] = p.root;
    mReversed[q.root] = reversed;
    return true;
  }

private:
  std::vector<std::uint32_t> mParent;
  std::vector<std::uint8_t> mReversed; // against the parent
};

/// Goes once over the edges: counts them, joins faces over edges of two faces and remembers what else to join.
class EdgePass {
public:
  EdgePass(const WeldedMesh& mesh, MeshReport& report, FaceShells& shells)
      : mMesh(mesh), mReport(report), mShells(shells), mSets(mesh.triangles.size()) {}

  void run() {
    // An edge lies in the bucket of its lower vertex; the key is the higher vertex and the face.
    const VertexBuckets edges(mMesh, [](std::uint32_t face, const TriangleCorners& t, auto put) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        put(std::min(a, b), std::uint64_t{std::max(a, b)} << 32 | face);
      }
    });
    edges.forRuns([](std::uint64_t a, std::uint64_t b) { return a >> 32 == b >> 32; },
                  [this](std::uint32_t lower, const std::uint64_t* first, const std::uint64_t* last) {
                    addEdge(lower, first, last);
                  });
  }

  /// Judges the patches; then the sets grow to shells.
  void countFlippedFaces() {
    if (mReport.inconsistentEdges == 0) return;
    const std::size_t faces = mMesh.triangles.size();
    std::vector<std::uint32_t> reversed(faces, 0), total(faces, 0);
    for (std::uint32_t face = 0; face < faces; ++face) {
      const auto [root, isReversed] = mSets.find(face);
      reversed[root] += isReversed;
      ++total[root];
    }
    for (const std::uint32_t face : mConflicts) {
      std::uint32_t& size = total[mSets.find(face).root];
      if (size > 0) ++mReport.unorientablePatches;
      size = 0;
    }
    for (std::uint32_t face = 0; face < faces; ++face)
      if (total[face] > 0) mReport.flippedFaces += std::min(reversed[face], total[face] - reversed[face]);
  }

  void numberShells() {
    for (const auto& [a, b] : mSharedByMany) mSets.join(a, b, false);
    mShells.shellOf.assign(mMesh.triangles.size(), FaceShells::kNone);
    for (std::uint32_t face = 0; face < mShells.shellOf.size(); ++face) {
      if (hasRepeatedCorner(mMesh.triangles[face])) continue;
      const std::uint32_t root = mSets.find(face).root;
      mShells.shellOf[face] = root == face ? mShells.count++ : mShells.shellOf[root];
    }
    mReport.shellCount = mShells.count;
  }

private:
  static std::uint32_t faceOf(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

  struct Side {
    bool forward;           ///< the face runs along the edge from its lower vertex to the higher one
    std::uint32_t opposite; ///< its third corner
  };
  Side sideOf(std::uint32_t lower, std::uint64_t key) const {
    const TriangleCorners& t = mMesh.triangles[faceOf(key)];
    const int corner = t[0] == lower ? 0 : t[1] == lower ? 1 : 2;
    const std::uint32_t next = t[(corner + 1) % 3], previous = t[(corner + 2) % 3];
    const bool forward = next == key >> 32;
    return {forward, forward ? previous : next};
  }

  void addEdge(std::uint32_t lower, const std::uint64_t* first, const std::uint64_t* last) {
    const std::ptrdiff_t faces = last - first;
    if (faces == 1) {
      ++mReport.openEdges;
      mShells.openEdgeFaces.push_back(faceOf(*first));
      return;
    }
    if (faces == 2) {
      const Side a = sideOf(lower, first[0]), b = sideOf(lower, first[1]);
      const bool opposed = a.forward == b.forward;
      if (opposed) noteInconsistent(faceOf(*first));
      if (!mSets.join(faceOf(first[0]), faceOf(first[1]), opposed)) mConflicts.push_back(faceOf(*first));
      mShells.mayHaveDuplicates |= a.opposite == b.opposite;
      return;
    }
    const auto forward = std::count_if(first, last, [&](std::uint64_t key) { return sideOf(lower, key).forward; });
    if (2 * forward != faces) noteInconsistent(faceOf(*first));
    ++mReport.nonManifoldEdges;
    mShells.mayHaveDuplicates = true;
    for (const std::uint64_t* key = first + 1; key != last; ++key)
      mSharedByMany.emplace_back(faceOf(*first), faceOf(*key));
  }

  void noteInconsistent(std::uint32_t face) {
    ++mReport.inconsistentEdges;
    mShells.inconsistentEdgeFaces.push_back(face);
  }

  const WeldedMesh& mMesh;
  MeshReport& mReport;
  FaceShells& mShells;
  OrientedSets mSets;
  std::vector<std::uint32_t> mConflicts; // a face of each edge that shows its patch to be one-sided
  std::vector<std::pair<std::uint32_t, std::uint32_t>> mSharedByMany; // faces joined by edges of more than two
};

} // namespace

WeldedMesh weld(const Mesh& mesh) {
  PositionWelder welder(mesh.positions.size());
  std::vector<std::uint32_t> number;
  number.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) number.push_back(welder.add(p));
  WeldedMesh welded;
  welded.vertexCount = static_cast<std::uint32_t>(welder.size());
  welded.triangles.reserve(mesh.triangles.size());
  for (const TriangleCorners& t : mesh.triangles)
    welded.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return welded;
}

FaceShells analyseEdges(const WeldedMesh& mesh, MeshReport& report) {
  FaceShells shells;
  EdgePass pass(mesh, report, shells);
  pass.run();
  pass.countFlippedFaces();
  pass.numberShells();
  return shells;
}

std::uint64_t countDuplicateFaces(const WeldedMesh& mesh) {
  const VertexBuckets faces(mesh, [](std::uint32_t, TriangleCorners t, auto put) {
    std::sort(t.begin(), t.end());
    put(t[0], std::uint64_t{t[1]} << 32 | t[2]);
  });
  std::uint64_t duplicates = 0;
  faces.forRuns([](std::uint64_t a, std::uint64_t b) { return a == b; },
                [&](std::uint32_t, const std::uint64_t* first, const std::uint64_t* last) {
                  duplicates += static_cast<std::uint64_t>(last - first - 1);
                });
  return duplicates;
}

std::uint64_t countComponents(const WeldedMesh& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> parent(mesh.vertexCount, kUnused);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::uint64_t components = 0;
  for (const TriangleCorners& t : mesh.triangles) {
    for (const std::uint32_t v : t)
      if (parent[v] == kUnused) {
        parent[v] = v;
        ++components;
      }
    for (const std::uint32_t v : {t[1], t[2]}) {
      const std::uint32_t a = root(t[0]), b = root(v);
      if (a == b) continue;
      parent[std::max(a, b)] = std::min(a, b);
      --components;
    }
  }
  return components;
}

} // namespace volcaustic
