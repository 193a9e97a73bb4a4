#include "volume/winding.h"

#include "core/parallel.h"
#include "core/simd_clones.h"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>

namespace volcaustic {

namespace {

/// Faces along an edge, counted with their direction: positive from low to high.
struct NetEdge {
  std::uint32_t low, high;
  std::int32_t faces;
};

/// Calls visit(low, high, sign) for the directed edges of a triangle.
template <class Visit>
void forEachEdge(const std::array<std::uint32_t, 3>& triangle, Visit&& visit) {
  for (int i = 0; i < 3; ++i) {
    const std::uint32_t from = triangle[i], to = triangle[i == 2 ? 0 : i + 1];
    if (from < to) visit(from, to, 1);
    if (to < from) visit(to, from, -1);
  }
}

/// Scrambles 64 bits (the finaliser of SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014).
inline std::uint64_t scrambled(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ x >> 27) * 0x94d049bb133111ebull;
  return x ^ x >> 31;
}

/// The name of an undirected edge, scrambled and signed by the direction; 0 from a vertex to itself. In masks rather
/// than jumps: the direction is a coin toss.
inline std::uint64_t signedName(std::uint64_t from, std::uint64_t to) {
  const std::uint64_t backwards = 0 - std::uint64_t{from > to}, isEdge = 0 - std::uint64_t{from != to};
  const std::uint64_t turned = (from ^ to) & backwards;
  const std::uint64_t name = scrambled(((from ^ turned) << 32 | (to ^ turned)) + 0x9e3779b97f4a7c15ull);
  return ((name ^ backwards) - backwards) & isEdge;
}

VOLCAUSTIC_SIMD_CLONES std::uint64_t sumOfNames(const std::array<std::uint32_t, 3>* triangles, std::int64_t count) {
  constexpr int kBlock = 256;
  std::array<std::array<std::uint64_t, kBlock>, 3> corners{}; // a block that is not full ends in points
  std::uint64_t sum = 0;
  for (std::int64_t first = 0; first < count; first += kBlock) {
    const auto size = static_cast<int>(std::min<std::int64_t>(kBlock, count - first));
    for (int i = 0; i < size; ++i)
      for (int c = 0; c < 3; ++c) corners[c][i] = triangles[first + i][c];
    for (int i = size; i < kBlock; ++i)
      for (int c = 0; c < 3; ++c) corners[c][i] = 0;
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < kBlock; ++i) sum += signedName(corners[c][i], corners[c == 2 ? 0 : c + 1][i]);
  }
  return sum;
}

/// True when all directed edges cancel, vertices told apart by index: then signed sums of their scrambled names do, and
/// the other way round but for one chance in 2^62. A fortieth of the time that pairing the edges takes.
bool edgesCancel(const Mesh& mesh, const RunContext& ctx) {
  std::vector<std::uint64_t> sums(threadCount(ctx), 0);
  parallelFor(static_cast<std::int64_t>(mesh.triangles.size()), 8192, ctx,
              [&](std::int64_t begin, std::int64_t end, int slot) {
                sums[slot] += sumOfNames(mesh.triangles.data() + begin, end - begin);
              });
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}) == 0;
}

/// Edges of the mesh whose faces do not cancel, vertices told apart by index.
std::vector<NetEdge> uncancelledEdges(const Mesh& mesh) {
  struct Half {
    std::uint32_t high;
    std::int32_t sign;
  };
  std::vector<std::uint64_t> start(mesh.positions.size() + 1, 0); // of the half-edges of each lower vertex
  for (const auto& t : mesh.triangles) forEachEdge(t, [&](std::uint32_t low, std::uint32_t, int) { ++start[low]; });
  std::uint64_t sum = 0;
  for (std::uint64_t& s : start) s = sum += s;
  std::vector<Half> halves(sum);
  for (const auto& t : mesh.triangles)
    forEachEdge(t, [&](std::uint32_t low, std::uint32_t high, int sign) { halves[--start[low]] = {high, sign}; });

  std::vector<NetEdge> edges;
  for (std::uint32_t v = 0; v + 1 < start.size(); ++v) {
    const std::span<Half> ofVertex(halves.data() + start[v], halves.data() + start[v + 1]);
    std::sort(ofVertex.begin(), ofVertex.end(), [](const Half& a, const Half& b) { return a.high < b.high; });
    for (auto it = ofVertex.begin(); it != ofVertex.end();) {
      NetEdge edge{v, it->high, 0};
      for (; it != ofVertex.end() && it->high == edge.high; ++it) edge.faces += it->sign;
      if (edge.faces != 0) edges.push_back(edge);
    }
  }
  return edges;
}

/// Gives vertices of equal position the index of the first of them, and cancels again.
void weld(std::vector<NetEdge>& edges, const std::vector<Vec3d>& positions) {
  std::vector<std::uint32_t> vertices;
  for (const NetEdge& e : edges) vertices.insert(vertices.end(), {e.low, e.high});
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<std::uint32_t> byPosition = vertices;
  std::stable_sort(byPosition.begin(), byPosition.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return positions[a] < positions[b]; });
  const auto slot = [&](std::uint32_t v) {
    return std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin();
  };
  std::vector<std::uint32_t> representative(vertices.size());
  for (std::size_t i = 0, first = 0; i < byPosition.size(); ++i) {
    if (positions[byPosition[i]] != positions[byPosition[first]]) first = i;
    representative[slot(byPosition[i])] = byPosition[first];
  }
  for (NetEdge& e : edges) {
    e.low = representative[slot(e.low)];
    e.high = representative[slot(e.high)];
    if (e.low > e.high) {
      std::swap(e.low, e.high);
      e.faces = -e.faces;
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const NetEdge& a, const NetEdge& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size();) {
    NetEdge sum{edges[i].low, edges[i].high, 0};
    for (; i < edges.size() && edges[i].low == sum.low && edges[i].high == sum.high; ++i) sum.faces += edges[i].faces;
    if (sum.faces != 0 && sum.low != sum.high) edges[kept++] = sum;
  }
  edges.resize(kept);
}

/// Calls loop(vertices) for simple loops that use up the chain: walk on until a vertex comes again, cut that loop off.
template <class Loop>
void forEachSimpleLoop(std::vector<BoundaryEdge> chain, Loop&& loop) {
  std::sort(chain.begin(), chain.end(), [](const BoundaryEdge& a, const BoundaryEdge& b) {
    return std::tie(a.from, a.to) < std::tie(b.from, b.to);
  });
  // Every vertex of a closed chain has as many edges in as out, so each `to` is also a `from`.
  std::vector<std::uint32_t> vertices, next;
  for (std::uint32_t i = 0; i < chain.size(); ++i)
    if (vertices.empty() || vertices.back() != chain[i].from) {
      vertices.push_back(chain[i].from);
      next.push_back(i);
    }
  const std::vector<std::uint32_t> firstEdge = next;
  const auto edgesEnd = [&](std::size_t slot) {
    return slot + 1 < firstEdge.size() ? firstEdge[slot + 1] : static_cast<std::uint32_t>(chain.size());
  };
  constexpr std::size_t kOff = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> placeOnPath(vertices.size(), kOff), path;
  std::vector<std::uint32_t> corners;
  for (std::size_t start = 0; start < vertices.size(); ++start) {
    path.assign(1, start);
    placeOnPath[start] = 0;
    while (next[path.back()] < edgesEnd(path.back())) {
      const std::uint32_t to = chain[next[path.back()]++].to;
      const std::size_t slot = std::lower_bound(vertices.begin(), vertices.end(), to) - vertices.begin();
      assert(slot < vertices.size() && vertices[slot] == to);
      if (placeOnPath[slot] == kOff) {
        placeOnPath[slot] = path.size();
        path.push_back(slot);
        continue;
      }
      corners.clear();
      for (std::size_t i = placeOnPath[slot]; i < path.size(); ++i) corners.push_back(vertices[path[i]]);
      while (path.back() != slot) {
        placeOnPath[path.back()] = kOff;
        path.pop_back();
      }
      loop(corners);
    }
    assert(path.size() == 1);
    placeOnPath[start] = kOff;
  }
}

} // namespace

std::vector<BoundaryEdge> boundaryChain(const Mesh& mesh, const RunContext& ctx) {
  if (edgesCancel(mesh, ctx)) return {};
  std::vector<NetEdge> edges = uncancelledEdges(mesh);
  weld(edges, mesh.positions);
  std::vector<BoundaryEdge> chain;
  for (const NetEdge& e : edges)
    chain.insert(chain.end(), static_cast<std::size_t>(std::abs(e.faces)),
                 e.faces > 0 ? BoundaryEdge{e.low, e.high} : BoundaryEdge{e.high, e.low});
  return chain;
}

LoopCaps capLoops(const Mesh& mesh, const std::vector<BoundaryEdge>& chain) {
  LoopCaps caps;
  forEachSimpleLoop(chain, [&](const std::vector<std::uint32_t>& loop) {
    const auto first = static_cast<std::uint32_t>(caps.positions.size());
    const auto size = static_cast<std::uint32_t>(loop.size());
    for (const std::uint32_t v : loop) caps.positions.push_back(mesh.positions[v]);
    for (std::uint32_t i = 0; i < size; ++i) caps.edges.push_back({first + i, first + (i + 1) % size});
    const auto halve = [&](const auto& self, std::uint32_t i, std::uint32_t j) -> void {
      if (j - i < 2) return;
      const std::uint32_t middle = i + (j - i) / 2;
      caps.triangles.push_back({j, middle, i});
      self(self, i, middle);
      self(self, middle, j);
    };
    halve(halve, first, first + size - 1);
  });
  return caps;
}

} // namespace volcaustic
