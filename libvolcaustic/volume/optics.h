// Optical properties on brick grids: bodies painted over the ambient medium by coverage, and the Gaussian on the index.
#pragma once

#include "backends/optics_bricks.h"
#include "kernels/painting.h"
#include "volcaustic/medium.h"
#include "volume/voxelise.h"

#include <span>

namespace volcaustic {

/// kernels::PaintedGrids that the bodies change; index and coverage are always among them.
std::uint8_t changedGrids(const Ambient& ambient, std::span<const Body> bodies);

/// The ambient medium over a domain, with grids for what some body changes.
/// \throws Error(Input) when the brick tables alone are beyond the memory limit.
OpticsBricks ambientOptics(const Domain& domain, const Ambient& ambient, std::span<const Body> bodies,
                           const RunContext& ctx = {});

/// Paints a body over what is there: value + c (material - value) with coverage c for the optics, and
/// 1 - (1 - coverage)(1 - c) for the coverage, as of bodies that are placed independently inside a voxel.
void paintBody(OpticsBricks& optics, const CoveragePatch& patch, const Material& material, const RunContext& ctx = {});

/// Makes bricks whose 512 voxels are equal constant again, and gives their memory back.
void collapseUniform(OpticsBricks& optics, const RunContext& ctx = {});

/// Of a normalised Gaussian of `width` taps (odd, 1 to 11) with a standard deviation of width/6; the middle one is what
/// they leave of 1.
kernels::BlurWeights gaussianWeights(int width);

/// Separable Gaussian of `width` taps (odd, 1 to 11) with a standard deviation of width/6 voxels. Beyond the domain its
/// nearest voxel continues. Where all voxels in reach are equal the value keeps its bits.
BrickGrid<float> gaussianBlur(const BrickGrid<float>& grid, int width, const RunContext& ctx = {});

} // namespace volcaustic
