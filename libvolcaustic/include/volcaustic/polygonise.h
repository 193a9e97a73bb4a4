/// \file polygonise.h
/// Triangles of functional objects.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/mesh.h"
#include "volcaustic/run_context.h"
#include "volcaustic/shape.h"

#include <cstdint>
#include <memory>

namespace volcaustic {

/// How fine triangles are: 0 leaves each open. The finest cells that one of the first three asks for are taken;
/// `triangles` is a limit. Where nothing is asked for there are 128 cells along the longest side of the shape.
struct PolygoniseOptions {
  int resolution = 0;   ///< cells along the longest side of the shape, or up to a tenth more
  double cellSize = 0;  ///< world; it replaces `resolution`
  double tolerance = 0; ///< world: greatest distance between triangles and surface
  int triangles = 0;    ///< at most as many, and where it alone is given nearly as many
};

struct PolygoniseReport {
  double cellSize = 0;            ///< world
  double deviation = 0;           ///< world: greatest distance found between triangles and surface
  std::uint64_t blocks = 0;       ///< of 8^3 cells that the surface passes through
  std::uint64_t reusedBlocks = 0; ///< of them taken from the shape before
  std::uint64_t evaluations = 0;  ///< points at which the shape was evaluated
};

/// Polygonises shape after shape, and takes over what a shape has in common with the one before: of a sequence in which
/// a part moves, only the blocks of cells around that part are made anew.
class VOLCAUSTIC_API Polygoniser {
public:
  Polygoniser();
  ~Polygoniser();
  Polygoniser(Polygoniser&&) noexcept;
  Polygoniser& operator=(Polygoniser&&) noexcept;

  /// A closed, oriented manifold with sharp edges kept; triangleGroup tells the part (ShapeField::partNames) that each
  /// triangle belongs to. The same triangles whatever came before. \throws Error(Input) for a shape without end or
  /// without an inside, or cells so small that there are more than 32768 along an axis
  Mesh polygonise(const Shape& shape, const PolygoniseOptions& options = {}, const RunContext& ctx = {});
  [[nodiscard]] const PolygoniseReport& report() const; ///< of the last call

private:
  struct State;
  std::unique_ptr<State> mState;
};

/// Of one shape alone.
VOLCAUSTIC_API Mesh polygonise(const Shape& shape, const PolygoniseOptions& options = {}, const RunContext& ctx = {},
                               PolygoniseReport* report = nullptr);

} // namespace volcaustic
