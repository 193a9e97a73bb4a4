// Sparse RGB or vector fields as the kernels read them: 8x8x8 bricks, each one value or 512.
#pragma once

#include "kernels/flat_medium.h"

namespace volcaustic::kernels {

struct SparseField {
  Int3 dims, brickDims;
  const std::int32_t* slots = nullptr; ///< of each brick (z fastest); -1 is a brick of one value
  const float* constants = nullptr;    ///< three for each brick
  const float* voxels = nullptr;       ///< three for each of a slot's 512 voxels, z fastest

  VOLCAUSTIC_HD Float3 at(const Int3& v) const {
    const std::int64_t brick =
        (static_cast<std::int64_t>(v.x >> 3) * brickDims.y + (v.y >> 3)) * brickDims.z + (v.z >> 3);
    return slots[brick] < 0 ? load(constants, brick)
                            : load(voxels, slots[brick] * std::int64_t{512} + FlatMedium::voxelOffset(v));
  }

  /// Trilinear between voxel centres, constant beyond the outermost ones.
  VOLCAUSTIC_HD Float3 sample(const Float3& p) const {
    Int3 low;
    Float3 t;
    axis(p.x, dims.x, low.x, t.x);
    axis(p.y, dims.y, low.y, t.y);
    axis(p.z, dims.z, low.z, t.z);
    if ((low.x & 7) < 7 && (low.y & 7) < 7 && (low.z & 7) < 7) return sampleInBrick(low, t);
    const Int3 one{smaller(low.x + 1, dims.x - 1), smaller(low.y + 1, dims.y - 1), smaller(low.z + 1, dims.z - 1)};
    const auto row = [&](int x, int y) { return lerp(at({x, y, low.z}), at({x, y, one.z}), t.z); };
    return lerp(lerp(row(low.x, low.y), row(low.x, one.y), t.y), lerp(row(one.x, low.y), row(one.x, one.y), t.y), t.x);
  }

private:
  VOLCAUSTIC_HD static Float3 load(const float* array, std::int64_t i) {
    return {array[3 * i], array[3 * i + 1], array[3 * i + 2]};
  }
  VOLCAUSTIC_HD static Float3 lerp(const Float3& a, const Float3& b, float t) { return a + (b - a) * t; }
  VOLCAUSTIC_HD static void axis(float p, int dim, std::int32_t& low, float& t) {
    const float q = clampTo(p - 0.5f, 0.0f, static_cast<float>(dim - 1));
    low = clampTo(static_cast<int>(q), 0, larger(dim - 2, 0));
    t = q - static_cast<float>(low);
  }
  VOLCAUSTIC_HD Float3 sampleInBrick(const Int3& low, const Float3& t) const {
    const std::int64_t brick =
        (static_cast<std::int64_t>(low.x >> 3) * brickDims.y + (low.y >> 3)) * brickDims.z + (low.z >> 3);
    if (slots[brick] < 0) return load(constants, brick);
    const std::int64_t c = slots[brick] * std::int64_t{512} + FlatMedium::voxelOffset(low);
    const auto row = [&](std::int64_t i) { return lerp(load(voxels, i), load(voxels, i + 1), t.z); };
    return lerp(lerp(row(c), row(c + 8), t.y), lerp(row(c + 64), row(c + 72), t.y), t.x);
  }
};

} // namespace volcaustic::kernels
