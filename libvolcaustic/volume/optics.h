// Optical properties on brick grids: bodies painted over the ambient medium by coverage, and the Gaussian on the index.
#pragma once

#include "core/brick_grid.h"
#include "volcaustic/medium.h"
#include "volume/voxelise.h"

#include <optional>
#include <span>

namespace volcaustic {

/// A medium in the making. A grid that would be the ambient value everywhere is absent.
struct OpticsBricks {
  BrickGrid<float> index, coverage;
  std::optional<BrickGrid<Vec3f>> attenuation, scattering;
  std::optional<BrickGrid<float>> asymmetry;
};

/// The ambient medium over a domain, with grids for what some body changes.
/// \throws Error(Input) when the brick tables alone are beyond the memory limit.
OpticsBricks ambientOptics(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies,
                           const RunContext& ctx = {});

/// Paints a body over what is there: value + c (material - value) with coverage c for the optics, and
/// 1 - (1 - coverage)(1 - c) for the coverage, as of bodies that are placed independently inside a voxel.
void paintBody(OpticsBricks& optics, const CoveragePatch& patch, const Material& material, const RunContext& ctx = {});

/// Makes bricks whose 512 voxels are equal constant again, and gives their memory back.
void collapseUniform(OpticsBricks& optics, const RunContext& ctx = {});

/// Separable Gaussian of `width` taps (odd, 1 to 11) with a standard deviation of width/6 voxels. Beyond the domain its
/// nearest voxel continues. Where all voxels in reach are equal the value keeps its bits.
BrickGrid<float> gaussianBlur(const BrickGrid<float>& grid, int width, const RunContext& ctx = {});

} // namespace volcaustic
