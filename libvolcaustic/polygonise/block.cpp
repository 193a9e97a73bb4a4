#include "polygonise/block.h"

#include "polygonise/roots.h"

#include <algorithm>
#include <bit>

namespace volcaustic {

namespace {

/// Calls body(i) for the bits that are set, from the lowest on.
template <class Body>
void eachBit(unsigned bits, const Body& body) {
  for (; bits != 0; bits &= bits - 1) body(std::countr_zero(bits));
}

/// Points or cells 0 to 7 of a row.
constexpr unsigned kFirstEight = 0xff;

/// Of an edge of the lattice, for roots: vertices are moved onto the surface afterwards, planes know their distance.
constexpr double kRootAccuracy = 1e-2;

class BlockMesher {
public:
  BlockMesher(const SurfaceBlock& block, double cellSize, const std::vector<FlippedFaces>& flipped,
              BlockSampler& sampler)
      : mCellSize(cellSize), mFlipped(flipped), mSampler(sampler), mEvaluator(block.program, sampler.scratch()) {}

  BlockSurface run() {
    mSurface.firstVertex.fill(BlockSurface::kNone);
    if (mSampler.isCrossed()) {
      findCrossings();
      addCells();
      placeVertices(mEvaluator, mCellSize, mRoots, mPatchRoots, mPatches);
      takeVertices();
    }
    mSurface.evaluations = mEvaluator.count() + BlockSampler::kPoints;
    return std::move(mSurface);
  }

private:
  /// Those whose corners are not all on one side.
  void addCells() {
    for (int z = 0; z < kBlockCells; ++z)
      for (int y = 0; y < kBlockCells; ++y) {
        const unsigned a = mSampler.row(y, z), b = mSampler.row(y + 1, z), c = mSampler.row(y, z + 1),
                       d = mSampler.row(y + 1, z + 1);
        const unsigned any = a | b | c | d, all = a & b & c & d;
        eachBit((any | any >> 1) & ~(all & all >> 1) & kFirstEight, [&](int x) {
          addCell(x, y, z, (a >> x & 3) | (b >> x & 3) << 2 | (c >> x & 3) << 4 | (d >> x & 3) << 6);
        });
      }
  }

  /// Roots on all edges between the block's points, and faces for those that begin in it.
  void findCrossings() {
    std::vector<Bracket> brackets;
    for (auto& roots : mRootOf) roots.fill(-1);
    for (int z = 0; z < kBlockPoints; ++z)
      for (int y = 0; y < kBlockPoints; ++y) {
        const unsigned row = mSampler.row(y, z);
        const auto add = [&](unsigned crossed, int axis) {
          eachBit(crossed, [&](int x) { addEdge(x, y, z, axis, row >> x & 1, brackets); });
        };
        add((row ^ row >> 1) & kFirstEight, 0);
        if (y < kBlockCells) add(row ^ mSampler.row(y + 1, z), 1);
        if (z < kBlockCells) add(row ^ mSampler.row(y, z + 1), 2);
      }
    std::vector<double> places;
    findRoots(mEvaluator, brackets, kRootAccuracy, places);
    PointArrays points;
    for (std::size_t i = 0; i < brackets.size(); ++i) {
      Vec3d p = brackets[i].from;
      p[brackets[i].axis] += places[i] * brackets[i].length;
      points.add(p);
    }
    ValueArrays values;
    mEvaluator.gradients(points, values);
    for (std::size_t i = 0; i < brackets.size(); ++i) mRoots.push_back({points.at(i), values.tangent(i)});
    for (Crossing& crossing : mSurface.crossings) complete(crossing);
  }

  void addEdge(int x, int y, int z, int axis, bool outwards, std::vector<Bracket>& brackets) {
    const int from = BlockSampler::pointOfBlock(x, y, z), to = from + BlockSampler::kStep[axis];
    const Vec3d p = mSampler.point(x, y, z), q = mSampler.point(x + (axis == 0), y + (axis == 1), z + (axis == 2));
    mRootOf[axis][from] = static_cast<std::int16_t>(brackets.size());
    brackets.push_back({p, axis, q[axis] - p[axis], mSampler.value(from), mSampler.value(to)});
    if (std::max({x, y, z}) == kBlockCells) return;
    mSurface.crossings.push_back(
        {static_cast<std::uint16_t>(cellOfBlock(x, y, z)), static_cast<std::uint8_t>(axis), outwards, 0, {}, {}});
  }

  void complete(Crossing& crossing) {
    const int x = crossing.cell % kBlockCells, y = crossing.cell / kBlockCells % kBlockCells,
              z = crossing.cell / (kBlockCells * kBlockCells);
    const Root& root = mRoots[mRootOf[crossing.axis][BlockSampler::pointOfBlock(x, y, z)]];
    crossing.slope = static_cast<float>(root.tangent.slope);
    for (int a = 0; a < 3; ++a) crossing.normal[a] = static_cast<float>(root.tangent.normal[a]);
    crossing.position = along(root.position, root.tangent.normal, -root.tangent.distance);
  }

  /// The patches of a cell. \param inside bit i: corner i
  void addCell(int x, int y, int z, unsigned inside) {
    const int corner = BlockSampler::pointOfBlock(x, y, z);
    const int cell = cellOfBlock(x, y, z);
    const unsigned joined = joinedFaces(corner, inside) ^ flippedOf(cell);
    if (const unsigned faces = facesOfOnePatch(inside, joined))
      mSurface.pinched.push_back({static_cast<std::uint16_t>(cell), static_cast<std::uint8_t>(inside),
                                  static_cast<std::uint8_t>(joined), static_cast<std::uint8_t>(faces)});
    const CellPatches patches = cellPatches(inside, joined);
    mSurface.firstVertex[cell] = static_cast<std::uint16_t>(mPatches.size());
    if (patches.count > 1) mSurface.many.push_back({static_cast<std::uint16_t>(cell), patches.patch});
    int found = 0;
    for (int edge = 0; found < patches.count; ++edge)
      if (patches.patch[edge] == found) {
        addPatch(mSampler.point(x, y, z), corner, patches, edge);
        ++found;
      }
  }

  static int cornerStep(int i) {
    return (i & 1) * BlockSampler::kStep[0] + (i >> 1 & 1) * BlockSampler::kStep[1] +
           (i >> 2 & 1) * BlockSampler::kStep[2];
  }

  [[nodiscard]] unsigned joinedFaces(int corner, unsigned inside) const {
    unsigned joined = 0;
    const unsigned ambiguous = ambiguousFaces(inside);
    for (int f = 0; ambiguous >> f != 0; ++f) {
      if (!(ambiguous >> f & 1)) continue;
      double v[4];
      for (int k = 0; k < 4; ++k) v[k] = mSampler.value(corner + cornerStep(faceCorner(f / 2, f & 1, k)));
      const int first = v[0] >= 0 ? 0 : 1;
      if (insideJoins(v[first], v[first + 2], v[1 - first], v[3 - first])) joined |= 1u << f;
    }
    return joined;
  }

  [[nodiscard]] unsigned flippedOf(int cell) const {
    const auto found = std::lower_bound(mFlipped.begin(), mFlipped.end(), cell,
                                        [](const FlippedFaces& f, int c) { return f.cell < c; });
    return found != mFlipped.end() && found->cell == cell ? found->faces : 0u;
  }

  void addPatch(const Vec3d& cell, int corner, const CellPatches& patches, int first) {
    PatchVertex patch;
    patch.cell = cell;
    patch.firstRoot = mPatchRoots.size();
    int edge = first;
    do {
      mPatchRoots.push_back(mRootOf[edgeAxis(edge)][corner + cornerStep(edgeCorner(edge))]);
      edge = patches.next[edge];
    } while (edge != first);
    patch.rootCount = mPatchRoots.size() - patch.firstRoot;
    mPatches.push_back(patch);
  }

  void takeVertices() {
    for (const PatchVertex& patch : mPatches) {
      if (patch.strays)
        mSurface.strays.push_back({static_cast<std::uint16_t>(mSurface.positions.size()), patch.outside, patch.within});
      mSurface.positions.push_back(patch.position);
    }
  }

  const double mCellSize;
  const std::vector<FlippedFaces>& mFlipped;
  BlockSampler& mSampler;
  PointEvaluator mEvaluator;
  BlockSurface mSurface;
  std::array<std::array<std::int16_t, BlockSampler::kPoints>, 3> mRootOf; // by point where the edge begins
  std::vector<Root> mRoots;
  std::vector<int> mPatchRoots;
  std::vector<PatchVertex> mPatches;
};

} // namespace

std::uint16_t BlockSurface::vertexAt(int cell, int edge) const {
  const std::uint16_t first = firstVertex[cell];
  if (first == kNone) return kNone;
  const auto found =
      std::lower_bound(many.begin(), many.end(), cell, [](const ManyPatches& m, int c) { return m.cell < c; });
  if (found == many.end() || found->cell != cell) return first;
  const int patch = found->patch[edge];
  return patch < 0 ? kNone : static_cast<std::uint16_t>(first + patch);
}

void BlockSampler::sample(const SurfaceBlock& block, double cellSize) {
  std::array<double, kBlockPoints> axes[3];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < kBlockPoints; ++i)
      axes[a][i] = latticeCoordinate(std::int64_t{block.coord[a]} * kBlockCells + i, cellSize);
  mAxisY = axes[1];
  mAxisZ = axes[2];
  mPoints.resize(kPoints);
  std::size_t i = 0;
  for (const double z : axes[2])
    for (const double y : axes[1])
      for (const double x : axes[0]) mPoints.set(i++, {x, y, z});
  PointEvaluator(block.program, mScratch).values(mPoints, mValues);
  unsigned any = 0, all = ~0u;
  const double* value = mValues.data();
  for (std::uint16_t& row : mRows) {
    unsigned inside = 0;
    for (int x = 0; x < kBlockPoints; ++x) inside |= unsigned{*value++ >= 0} << x;
    row = static_cast<std::uint16_t>(inside);
    any |= inside;
    all &= inside;
  }
  mCrossed = any != 0 && all != (1u << kBlockPoints) - 1;
}

std::size_t BlockSampler::countCrossings() const {
  std::size_t count = 0;
  for (int z = 0; z < kBlockCells && mCrossed; ++z)
    for (int y = 0; y < kBlockCells; ++y) {
      const unsigned a = row(y, z);
      for (const unsigned next : {a >> 1, row(y + 1, z), row(y, z + 1)})
        count += static_cast<std::size_t>(std::popcount((a ^ next) & kFirstEight));
    }
  return count;
}

BlockSurface blockSurface(const SurfaceBlock& block, double cellSize, const std::vector<FlippedFaces>& flipped,
                          BlockSampler& sampler) {
  sampler.sample(block, cellSize);
  return BlockMesher(block, cellSize, flipped, sampler).run();
}

} // namespace volcaustic
