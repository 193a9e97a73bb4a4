#include "polygonise/run.h"

#include "core/hash.h"
#include "core/parallel.h"
#include "polygonise/pinches.h"
#include "polygonise/strays.h"

#include <algorithm>
#include <numeric>

namespace volcaustic {

namespace {

constexpr int kGrain = 8; // blocks that a thread takes at once

/// One run from blocks to triangles.
class Run {
public:
  Run(PolygoniseJob& job, double cellSize)
      : mJob(job)
      , mCellSize(cellSize)
      , mBlocks(surfaceBlocks(job.program, job.bounds, cellSize, job.ctx))
      , mSamplers(threadCount(job.ctx)) {
    for (const SurfaceBlock& block : mBlocks) mStored.push_back(&mJob.store.take(block, mCellSize, {}));
  }

  PolygoniseResult polygonise() {
    std::vector<std::size_t> all(mBlocks.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<std::vector<FlippedFaces>> flipped(mBlocks.size());
    makeSurfaces(all, flipped);
    std::vector<std::size_t> changed;
    for (BlockFlips& flips : pinchedFaces(mBlocks, surfaces())) {
      mStored[flips.block] = &mJob.store.take(mBlocks[flips.block], mCellSize, flips.faces);
      changed.push_back(flips.block);
      flipped[flips.block] = std::move(flips.faces);
    }
    makeSurfaces(changed, flipped);
    return assemble();
  }

  std::uint64_t count() {
    std::vector<std::uint64_t> crossings(mBlocks.size(), 0), evaluations(mBlocks.size(), 0);
    eachOf(mBlocks.size(), {}, [&](std::size_t b, BlockSampler& sampler) {
      if (mStored[b]->surface) {
        crossings[b] = mStored[b]->surface->crossings.size();
        return;
      }
      sampler.sample(mBlocks[b], mCellSize);
      crossings[b] = sampler.countCrossings();
      evaluations[b] = BlockSampler::kPoints;
    });
    mJob.evaluations += std::reduce(evaluations.begin(), evaluations.end());
    return 2 * std::reduce(crossings.begin(), crossings.end());
  }

private:
  template <class Body>
  void eachOf(std::size_t count, std::string_view stage, const Body& body) {
    parallelFor(
        static_cast<std::int64_t>(count), kGrain, mJob.ctx,
        [&](std::int64_t begin, std::int64_t end, int slot) {
          for (std::int64_t i = begin; i < end; ++i) body(static_cast<std::size_t>(i), mSamplers[slot]);
        },
        stage);
  }

  [[nodiscard]] std::vector<std::shared_ptr<const BlockSurface>> surfaces() const {
    std::vector<std::shared_ptr<const BlockSurface>> all;
    for (const StoredBlock* stored : mStored) all.push_back(stored->surface);
    return all;
  }

  /// Those of `which` that are not in the store.
  void makeSurfaces(const std::vector<std::size_t>& which, const std::vector<std::vector<FlippedFaces>>& flipped) {
    std::vector<std::size_t> missing;
    for (const std::size_t b : which)
      if (!mStored[b]->surface) missing.push_back(b);
    eachOf(missing.size(), "polygonise", [&](std::size_t i, BlockSampler& sampler) {
      const std::size_t b = missing[i];
      mStored[b]->surface =
          std::make_shared<const BlockSurface>(blockSurface(mBlocks[b], mCellSize, flipped[b], sampler));
    });
    for (const std::size_t b : missing) mJob.evaluations += mStored[b]->surface->evaluations;
  }

  PolygoniseResult assemble() {
    const auto all = surfaces();
    QuadMesh quads(mBlocks, all, mCellSize, mJob.ctx);
    mJob.evaluations += moveStrays(quads, mJob.ctx);
    const std::vector<std::string>& names = mJob.program.partNames();
    std::uint64_t partsKey = 0;
    if (names.size() > 1) {
      Hash hash;
      for (const std::string& name : names) hash.text(name);
      partsKey = hash.digest() | 1;
    }
    PolygoniseResult result;
    Mesh& mesh = result.mesh;
    mesh.triangles.resize(2 * quads.quadCount());
    std::vector<std::uint64_t> evaluations(mBlocks.size(), 0);
    eachOf(mBlocks.size(), {}, [&](std::size_t b, BlockSampler& sampler) {
      evaluations[b] = triangulateBlock(quads, b, partsKey, sampler.scratch(),
                                        mesh.triangles.data() + 2 * quads.firstQuad(b), mStored[b]->measure);
    });
    mJob.evaluations += std::reduce(evaluations.begin(), evaluations.end());
    mesh.positions = std::move(quads.positions);
    if (partsKey != 0) mesh.groupNames = names;
    report(result);
    return result;
  }

  void report(PolygoniseResult& result) const {
    result.report.cellSize = mCellSize;
    for (const StoredBlock* stored : mStored) {
      if (stored->surface->positions.empty()) continue;
      ++result.report.blocks;
      result.report.reusedBlocks += stored->reused;
      if (stored->surface->crossings.empty()) continue;
      result.report.deviation = std::max(result.report.deviation, stored->measure.deviation);
      result.mesh.triangleGroup.insert(result.mesh.triangleGroup.end(), stored->measure.parts.begin(),
                                       stored->measure.parts.end());
    }
  }

  PolygoniseJob& mJob;
  const double mCellSize;
  std::vector<SurfaceBlock> mBlocks;
  std::vector<BlockSampler> mSamplers;
  std::vector<StoredBlock*> mStored;
};

} // namespace

double PolygoniseJob::longestSide() const {
  return std::max({bounds.max[0] - bounds.min[0], bounds.max[1] - bounds.min[1], bounds.max[2] - bounds.min[2]});
}

PolygoniseResult polygoniseAt(PolygoniseJob& job, double cellSize) { return Run(job, cellSize).polygonise(); }

std::uint64_t countTriangles(PolygoniseJob& job, double cellSize) { return Run(job, cellSize).count(); }

} // namespace volcaustic
