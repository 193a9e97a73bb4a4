#include "volume/medium_store.h"

#include "volcaustic/error.h"
#include "volume/grids.h"

namespace volcaustic {

namespace {

openvdb::Vec3s toVdb(const Rgb& c) { return {float(c[0]), float(c[1]), float(c[2])}; }
Vec3f toFloat(const Rgb& c) { return {float(c[0]), float(c[1]), float(c[2])}; }

/// Grids of the bricks, each set of bricks freed as soon as it is converted.
MediumGrids toGrids(OpticsBricks optics, const Domain& domain, const Ambient& ambient, const RunContext& ctx) {
  MediumGrids grids;
  grids.index = toFloatGrid(optics.index, domain, "index", ctx);
  optics.index = {};
  auto coverage = toFloatGrid(optics.coverage, domain, "coverage", ctx);
  coverage->setGridClass(openvdb::GRID_FOG_VOLUME);
  grids.coverage = coverage;
  optics.coverage = {};
  const auto spectrum = [&](std::optional<BrickGrid<Vec3f>>& bricks, const Rgb& ambientValue, const char* name) {
    auto grid = bricks ? toVec3Grid(*bricks, domain, name, ctx) : constantVec3(domain, ambientValue, name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setVectorType(openvdb::VEC_INVARIANT);
    bricks.reset();
    return grid;
  };
  grids.attenuation = spectrum(optics.attenuation, ambient.attenuation, "attenuation");
  grids.scattering = spectrum(optics.scattering, ambient.scattering, "scattering");
  if (optics.asymmetry) grids.asymmetry = toFloatGrid(*optics.asymmetry, domain, "asymmetry", ctx);
  return grids;
}

} // namespace

openvdb::FloatGrid::Ptr constantFloat(const Domain& domain, double value, const char* name) {
  auto grid = openvdb::FloatGrid::create(static_cast<float>(value));
  grid->setName(name);
  grid->setTransform(domainTransform(domain));
  return grid;
}

openvdb::Vec3SGrid::Ptr constantVec3(const Domain& domain, const Rgb& value, const char* name) {
  auto grid = openvdb::Vec3SGrid::create(toVdb(value));
  grid->setName(name);
  grid->setTransform(domainTransform(domain));
  return grid;
}

MediumStore::MediumStore(OpticsBricks&& bricks, const Domain& domain, const Ambient& ambient, const RunContext& ctx)
    : mBricks(std::make_shared<OpticsBricks>(std::move(bricks))), mDomain(domain), mAmbient(ambient) {
  mCtx.threads = ctx.threads;
  mCtx.memoryLimit = ctx.memoryLimit;
}

MediumStore::MediumStore(std::shared_ptr<const DeviceBricks> bricks, const Domain& domain, const Ambient& ambient,
                         const RunContext& ctx)
    : mOnDevice(std::move(bricks)), mDomain(domain), mAmbient(ambient) {
  mCtx.threads = ctx.threads;
  mCtx.memoryLimit = ctx.memoryLimit;
}

void MediumStore::copyFromDevice() {
  if (!mBricks && !mGrids && mOnDevice) mBricks = std::make_shared<OpticsBricks>(mOnDevice->download(mCtx));
}

const MediumGrids& MediumStore::grids() {
  const std::lock_guard lock(mMutex);
  if (mGrids) return *mGrids;
  copyFromDevice();
  if (!mBricks) throw Error(ErrorKind::Internal, "medium: an earlier conversion to grids failed; build it again");
  // Whoever else holds the bricks keeps them.
  const std::shared_ptr<OpticsBricks> bricks = std::move(mBricks);
  mGrids = toGrids(bricks.use_count() == 1 ? std::move(*bricks) : *bricks, mDomain, mAmbient, mCtx);
  return *mGrids;
}

std::shared_ptr<const OpticsBricks> MediumStore::bricks() {
  const std::lock_guard lock(mMutex);
  copyFromDevice();
  return mBricks;
}

std::shared_ptr<const OpticsBricks> bricksOf(const Medium& medium, const RunContext& ctx) {
  if (auto bricks = medium.store().bricks()) return bricks;
  const Vec3i& dims = medium.domain().dims;
  const MediumGrids& grids = medium.grids();
  const Ambient& ambient = medium.ambient();
  OpticsBricks optics;
  optics.index = fromFloatGrid(*grids.index, dims, static_cast<float>(ambient.index), ctx);
  optics.attenuation = fromVec3Grid(*grids.attenuation, dims, toFloat(ambient.attenuation), ctx);
  optics.scattering = fromVec3Grid(*grids.scattering, dims, toFloat(ambient.scattering), ctx);
  if (grids.asymmetry)
    optics.asymmetry = fromFloatGrid(*grids.asymmetry, dims, static_cast<float>(ambient.asymmetry), ctx);
  return std::make_shared<const OpticsBricks>(std::move(optics));
}

const MediumGrids& Medium::grids() const { return mStore->grids(); }

} // namespace volcaustic
