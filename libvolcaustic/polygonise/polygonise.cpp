#include "volcaustic/polygonise.h"

#include "polygonise/cell_size.h"
#include "polygonise/run.h"
#include "volcaustic/error.h"

namespace volcaustic {

namespace {

void requireValid(const Shape& shape, const PolygoniseOptions& options) {
  if (options.resolution < 0 || !(options.cellSize >= 0) || !(options.tolerance >= 0) || options.triangles < 0)
    throw Error(ErrorKind::Usage, "polygonise: resolution, cell size, tolerance and number of triangles must be 0 or "
                                  "more");
  if (shape.empty()) throw Error(ErrorKind::Input, "polygonise: the shape is empty; give it a solid");
}

} // namespace

struct Polygoniser::State {
  BlockStore store;
  PolygoniseReport report;
};

Polygoniser::Polygoniser() : mState(std::make_unique<State>()) {}
Polygoniser::~Polygoniser() = default;
Polygoniser::Polygoniser(Polygoniser&&) noexcept = default;
Polygoniser& Polygoniser::operator=(Polygoniser&&) noexcept = default;

Mesh Polygoniser::polygonise(const Shape& shape, const PolygoniseOptions& options, const RunContext& ctx) {
  requireValid(shape, options);
  mState->store.beginShape();
  PolygoniseJob job{ShapeProgram(shape), ShapeField(shape).bounds(), mState->store, ctx};
  if (!(job.longestSide() > 0))
    throw Error(ErrorKind::Input, "polygonise: the shape has no inside; look at what is cut out of it");
  PolygoniseResult result = polygoniseAsAsked(job, options);
  if (result.mesh.empty())
    throw Error(ErrorKind::Input, "polygonise: no point of the lattice is inside the shape; take smaller cells");
  mState->report = result.report;
  mState->report.evaluations = job.evaluations;
  return std::move(result.mesh);
}

const PolygoniseReport& Polygoniser::report() const { return mState->report; }

Mesh polygonise(const Shape& shape, const PolygoniseOptions& options, const RunContext& ctx, PolygoniseReport* report) {
  Polygoniser polygoniser;
  Mesh mesh = polygoniser.polygonise(shape, options, ctx);
  if (report) *report = polygoniser.report();
  return mesh;
}

} // namespace volcaustic
