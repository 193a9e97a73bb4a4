// The palette of a medium's optics: every set of attenuation, scattering and asymmetry once. Keys are told apart by a
// hash of 64 bits; sorted hashes number them, so the numbers depend on no order of threads. That no two keys shared a
// hash is checked, and the seed changed if they did.
#pragma once

#include "kernels/flat_medium.h"
#include "kernels/painting.h"

namespace volcaustic::kernels {

struct OpticsKey {
  float of[7]; ///< attenuation, scattering, asymmetry

  VOLCAUSTIC_HD explicit OpticsKey(const PointOptics& o)
      : of{o.attenuation.x, o.attenuation.y, o.attenuation.z, o.scattering.x,
           o.scattering.y,  o.scattering.z,  o.asymmetry} {}
  VOLCAUSTIC_HD std::uint32_t bits(int i) const {
    union {
      float number;
      std::uint32_t word;
    } u{of[i]};
    return u.word;
  }
  VOLCAUSTIC_HD bool same(const OpticsKey& other) const {
    for (int i = 0; i < 7; ++i)
      if (bits(i) != other.bits(i)) return false;
    return true;
  }
  VOLCAUSTIC_HD std::uint64_t hash(std::uint64_t seed) const {
    std::uint64_t h = seed;
    for (int i = 0; i < 7; ++i) {
      h = (h ^ bits(i)) * 0x9e3779b97f4a7c15ull;
      h ^= h >> 29;
    }
    return h;
  }
};

/// What has a number in the palette: the constants, then one value for each slot whose optics are one, or each of the
/// 512 voxels of one whose optics differ.
struct PaletteItems {
  PaintedBricks painted;
  std::int64_t constants, slots;
  const std::uint32_t* varying; ///< slots before each whose optics differ
  std::uint64_t seed;

  VOLCAUSTIC_HD std::int64_t firstVoxel(std::int64_t slot) const {
    return (std::int64_t{varying[slot]} + 1) * kVoxelsOfBrick;
  }
  VOLCAUSTIC_HD std::int64_t placeOfConstant(std::int64_t i) const { return firstVoxel(slots) + i; }
  VOLCAUSTIC_HD std::int64_t placeOfSlot(std::int64_t slot) const { return placeOfConstant(constants) + slot; }
  VOLCAUSTIC_HD bool varies(std::int64_t slot) const { return varying[slot] != varying[slot + 1]; }
  /// Of the voxel, or of the brick.
  VOLCAUSTIC_HD OpticsKey ofSlot(std::int64_t slot, int voxel) const {
    return OpticsKey(painted.at(painted.bricks[slot], voxel));
  }
  /// 0 for the ambient medium, so that it comes first.
  VOLCAUSTIC_HD std::uint64_t hash(const OpticsKey& key) const {
    return key.same(OpticsKey(painted.ambient)) ? 0 : key.hash(seed) | 1;
  }
};

/// An element a slot: a count of 1 where the optics differ inside it.
struct MarkVaryingOptics {
  const std::uint8_t* varies;
  std::uint32_t* marks;
  VOLCAUSTIC_HD void operator()(std::int64_t slot) const { marks[slot] = (varies[slot] & kOpticsBits) != 0; }
};

/// Calls visit(place, key) for the items: an element each for constants, a block each for slots. Places are those of
/// FlatMedium::voxelOptics first, whose slot 0 is the ambient medium; then come the constants, then the slots.
template <class Visit>
struct ForConstants {
  PaletteItems items;
  Visit visit;
  VOLCAUSTIC_HD void operator()(std::int64_t i) const {
    visit(items.placeOfConstant(i), OpticsKey(items.painted.constants[i]));
  }
};
template <class Visit>
struct ForSlots {
  PaletteItems items;
  Visit visit;
  struct Shared {};
  template <class Block>
  VOLCAUSTIC_HD void operator()(Block& block, Shared&, std::int64_t slot) const {
    block.forEach(1, [&](int) { visit(items.placeOfSlot(slot), items.ofSlot(slot, 0)); });
    if (!items.varies(slot)) return;
    block.forEach(kVoxelsOfBrick, [&](int v) { visit(items.firstVoxel(slot) + v, items.ofSlot(slot, v)); });
  }
};

struct WriteHashes {
  PaletteItems items;
  std::uint64_t* hashes;
  VOLCAUSTIC_HD void operator()(std::int64_t place, const OpticsKey& key) const { hashes[place] = items.hash(key); }
};

/// The number of a hash among the sorted ones.
struct PaletteNumbers {
  const std::uint64_t* hashes;
  std::int64_t count;
  VOLCAUSTIC_HD std::int32_t of(std::uint64_t hash) const {
    std::int64_t low = 0, high = count; // hashes[low] <= hash
    while (high - low > 1) {
      const std::int64_t middle = low + (high - low) / 2;
      (hashes[middle] <= hash ? low : high) = middle;
    }
    return static_cast<std::int32_t>(low);
  }
};

/// The first place of each number, and the number of each place.
struct WriteNumbers {
  PaletteItems items;
  PaletteNumbers numbers;
  std::uint32_t* firsts; ///< all ones to begin with
  std::int32_t* entries;
  VOLCAUSTIC_HD void operator()(std::int64_t place, const OpticsKey& key) const {
    const std::int32_t number = numbers.of(items.hash(key));
    entries[place] = number;
    if (firsts[number] > static_cast<std::uint32_t>(place))
      lowerShared(firsts + number, static_cast<std::uint32_t>(place));
  }
};
/// The palette, by the keys of the first places.
struct WriteOptics {
  PaletteItems items;
  const std::uint32_t* firsts;
  const std::int32_t* entries;
  OpticsKey* keys;
  VOLCAUSTIC_HD void operator()(std::int64_t place, const OpticsKey& key) const {
    if (firsts[entries[place]] == static_cast<std::uint32_t>(place)) keys[entries[place]] = key;
  }
};
/// Counts keys that share their hash with another one.
struct CheckOptics {
  const std::int32_t* entries;
  const OpticsKey* keys;
  std::uint32_t* wrong;
  VOLCAUSTIC_HD void operator()(std::int64_t place, const OpticsKey& key) const {
    if (!key.same(keys[entries[place]])) addShared(wrong, 1);
  }
};

/// An element a brick: its entry in opticsSlots.
struct PlaceOptics {
  PaletteItems items;
  const std::int32_t* entries;
  std::int32_t* opticsSlots;
  VOLCAUSTIC_HD void operator()(std::int64_t b) const {
    const std::int32_t slot = items.painted.slots[b];
    if (slot > 0 && items.varies(slot - 1))
      opticsSlots[b] = static_cast<std::int32_t>(items.varying[slot - 1]) + 1;
    else
      opticsSlots[b] =
          slot == 0 ? 0 : -entries[slot < 0 ? items.placeOfConstant(-slot - 1) : items.placeOfSlot(slot - 1)];
  }
};

} // namespace volcaustic::kernels
