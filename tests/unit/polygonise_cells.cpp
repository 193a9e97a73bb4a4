// Patches of cells, and what keeps the mesh a manifold, on lattices of random signs.
#include "polygonise/faces.h"
#include "polygonise/pinches.h"
#include "unit/polygonise_support.h"

#include <bit>
#include <random>

namespace volcaustic::test {
namespace {

TEST(PolygoniseCells, PatchesAreLoopsOfAllCrossings) {
  for (unsigned inside = 0; inside < 256; ++inside)
    for (unsigned joined = 0; joined < 64; ++joined) {
      const CellPatches patches = cellPatches(inside, joined);
      std::array<int, kCellEdges> before{};
      for (int e = 0; e < kCellEdges; ++e) {
        const int corner = edgeCorner(e), other = corner | 1 << edgeAxis(e);
        const bool crossed = (inside >> corner & 1) != (inside >> other & 1);
        ASSERT_EQ(patches.next[e] >= 0, crossed);
        ASSERT_EQ(patches.patch[e] >= 0, crossed);
        if (!crossed) continue;
        ++before[patches.next[e]];
        ASSERT_EQ(patches.patch[e], patches.patch[patches.next[e]]);
        // Not back at once: a patch has three corners or more.
        ASSERT_NE(patches.next[patches.next[e]], e);
      }
      for (int e = 0; e < kCellEdges; ++e) ASSERT_EQ(before[e], patches.next[e] >= 0);
    }
}

TEST(PolygoniseCells, OneCornerInsideIsOnePatchOfThree) {
  for (int corner = 0; corner < 8; ++corner) {
    const CellPatches patches = cellPatches(1u << corner, 0);
    EXPECT_EQ(patches.count, 1);
    EXPECT_EQ(std::count(patches.patch.begin(), patches.patch.end(), 0), 3);
  }
  // Two opposite corners of a cell; of a face they hang together or not.
  EXPECT_EQ(cellPatches(0b10000001, 0).count, 2);
  EXPECT_EQ(cellPatches(0b00001001, 0).count, 2);
  EXPECT_EQ(cellPatches(0b00001001, 1u << 4).count, 1);
}

TEST(PolygoniseCells, PairingTheOtherWaySplitsAPinchedPatch) {
  for (unsigned inside = 1; inside < 255; ++inside)
    for (unsigned joined = 0; joined < 64; ++joined) {
      const unsigned pinched = facesOfOnePatch(inside, joined);
      for (int f = 0; f < kCellFaces; ++f) {
        if (!(pinched >> f & 1)) continue;
        const unsigned flipped = joined ^ 1u << f;
        ASSERT_EQ(cellPatches(inside, flipped).count, cellPatches(inside, joined).count + 1);
        // It joins nothing: no face becomes pinched that was not.
        ASSERT_EQ(facesOfOnePatch(inside, flipped) & ~pinched, 0u);
      }
    }
}

/// One block whose lattice points have random signs within a border that is outside; roots and gradients are those of
/// the middles of edges.
class RandomSigns {
public:
  explicit RandomSigns(unsigned seed) {
    std::mt19937 random(seed);
    const std::uint32_t share = 2 + random() % 6; // of eight
    mInside.fill(false);
    for (int z = 1; z < kBlockCells; ++z)
      for (int y = 1; y < kBlockCells; ++y)
        for (int x = 1; x < kBlockCells; ++x) at(x, y, z) = random() % 8 < share;
    for (unsigned& joined : mJoined) joined = 0;
    // Faces between cells, the same from both sides.
    for (int cell = 0; cell < kCellsOfBlock; ++cell)
      for (int axis = 0; axis < 3; ++axis) {
        const int step = axis == 0 ? 1 : axis == 1 ? kBlockCells : kBlockCells * kBlockCells;
        if (cell / step % kBlockCells == 0 || random() % 2) continue;
        mJoined[cell] |= 1u << 2 * axis;
        mJoined[cell - step] |= 1u << (2 * axis + 1);
      }
  }

  [[nodiscard]] Mesh mesh() const {
    const SurfaceBlock block{{0, 0, 0}, {}, 0};
    auto surface = std::make_shared<const BlockSurface>(make({}));
    std::vector<std::shared_ptr<const BlockSurface>> surfaces{surface};
    const auto flips = pinchedFaces(std::span(&block, 1), surfaces);
    if (!flips.empty()) surfaces[0] = std::make_shared<const BlockSurface>(make(flips[0].faces));
    const QuadMesh quads(std::span(&block, 1), surfaces, 1, {});
    Mesh mesh;
    mesh.positions = quads.positions;
    for (std::size_t q = 0; q < quads.quadCount(); ++q)
      for (const auto& t : quads.triangles(quads.quad(q), quads.crossing(0, q))) mesh.triangles.push_back(t);
    return mesh;
  }

private:
  bool& at(int x, int y, int z) { return mInside[BlockSampler::pointOfBlock(x, y, z)]; }
  [[nodiscard]] bool at(int x, int y, int z) const { return mInside[BlockSampler::pointOfBlock(x, y, z)]; }

  [[nodiscard]] BlockSurface make(const std::vector<FlippedFaces>& flipped) const {
    BlockSurface surface;
    surface.firstVertex.fill(BlockSurface::kNone);
    for (int cell = 0; cell < kCellsOfBlock; ++cell) addCell(cell, flipped, surface);
    return surface;
  }

  void addCell(int cell, const std::vector<FlippedFaces>& flipped, BlockSurface& surface) const {
    const int x = cell % kBlockCells, y = cell / kBlockCells % kBlockCells, z = cell / kBlockCells / kBlockCells;
    unsigned inside = 0, joined = mJoined[cell];
    for (int i = 0; i < 8; ++i) inside |= unsigned{at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2 & 1))} << i;
    for (const FlippedFaces& f : flipped)
      if (f.cell == cell) joined ^= f.faces;
    const auto id = static_cast<std::uint16_t>(cell);
    for (int axis = 0; axis < 3; ++axis)
      if ((inside & 1) != (inside >> (1 << axis) & 1))
        surface.crossings.push_back({id, static_cast<std::uint8_t>(axis), (inside & 1) != 0, 0, {}, {}});
    const CellPatches patches = cellPatches(inside, joined);
    if (patches.count == 0) return;
    if (const unsigned faces = facesOfOnePatch(inside, joined))
      surface.pinched.push_back(
          {id, static_cast<std::uint8_t>(inside), static_cast<std::uint8_t>(joined), static_cast<std::uint8_t>(faces)});
    surface.firstVertex[cell] = static_cast<std::uint16_t>(surface.positions.size());
    if (patches.count > 1) surface.many.push_back({id, patches.patch});
    for (int p = 0; p < patches.count; ++p) surface.positions.push_back({x + .1 * p, y + .2, z + .3});
  }

  std::array<bool, BlockSampler::kPoints> mInside;
  std::array<unsigned, kCellsOfBlock> mJoined;
};

TEST(PolygoniseCells, AnySignsMakeAManifold) {
  for (unsigned seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(seed);
    expectManifold(RandomSigns(seed).mesh());
    if (HasFatalFailure()) return;
  }
}

} // namespace
} // namespace volcaustic::test
