// The storage behind RadianceVolume.
#pragma once

#include "kernels/lamp.h"
#include "volcaustic/run_context.h"
#include "volume/fluence_grid.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace volcaustic {

/// Light that never met a bend; kernels::DirectField's arrays.
struct DirectLight {
  DirectLight() = default;
  explicit DirectLight(const Vec3i& dims);

  std::vector<kernels::Lamp> lamps;
  std::vector<std::int32_t> setBegins{0, 0}, setLamps; ///< set 0: all lamps
  ZeroedTable<std::int32_t> sets;
  FluenceGrid stored;

  [[nodiscard]] kernels::DirectField view() const;
  /// Whether the brick's light is one value.
  [[nodiscard]] bool isConstant(std::int64_t brick) const;
};

struct RadianceBricks {
  RadianceBricks() = default;
  explicit RadianceBricks(const Vec3i& dims) : direct(dims), caustic(dims) {}

  DirectLight direct;
  FluenceGrid caustic; ///< of traced photons

  /// Bricks whose light is not one value.
  [[nodiscard]] std::vector<std::int64_t> varyingBricks() const;
};

/// All light of several volumes of the same size.
std::shared_ptr<const RadianceBricks> sumOf(std::span<const RadianceBricks* const> lights, const RunContext& ctx);

/// What a voxel's two parts of light are turned into.
using LightValue = std::function<Vec3f(const kernels::Light& direct, const kernels::Light& caustic)>;

/// A value for every voxel; bricks of one value stay so.
BrickGrid<Vec3f> valuesOf(const RadianceBricks& light, const LightValue& value, const RunContext& ctx);

} // namespace volcaustic
