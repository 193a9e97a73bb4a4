// XXH64 (Yann Collet, xxHash fast digest algorithm, seed 0): eight bytes a step in four lanes, for files. Hash in
// hash.h is for keys. Not for security.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace volcaustic {

class XxHash64 {
public:
  /// The parts that the bytes come in do not matter.
  void add(const void* data, std::size_t size) {
    if (size == 0) return; // of an empty list, whose data may be null
    const auto* p = static_cast<const unsigned char*>(data);
    const std::size_t held = mSize % kStripe;
    mSize += size;
    if (held > 0) {
      const std::size_t taken = std::min(size, kStripe - held);
      std::memcpy(mRest.data() + held, p, taken);
      if (held + taken < kStripe) return;
      addStripe(mRest.data());
      p += taken;
      size -= taken;
    }
    for (; size >= kStripe; p += kStripe, size -= kStripe) addStripe(p);
    if (size > 0) std::memcpy(mRest.data(), p, size);
  }

  [[nodiscard]] std::uint64_t digest() const {
    std::uint64_t h = kPrime5;
    if (mSize >= kStripe) {
      h = std::rotl(mLanes[0], 1) + std::rotl(mLanes[1], 7) + std::rotl(mLanes[2], 12) + std::rotl(mLanes[3], 18);
      for (const std::uint64_t lane : mLanes) h = (h ^ round(0, lane)) * kPrime1 + kPrime4;
    }
    h += mSize;
    const unsigned char *p = mRest.data(), *end = p + mSize % kStripe;
    for (; end - p >= 8; p += 8) h = std::rotl(h ^ round(0, load<std::uint64_t>(p)), 27) * kPrime1 + kPrime4;
    for (; end - p >= 4; p += 4) h = std::rotl(h ^ load<std::uint32_t>(p) * kPrime1, 23) * kPrime2 + kPrime3;
    for (; p != end; ++p) h = std::rotl(h ^ *p * kPrime5, 11) * kPrime1;
    h = (h ^ h >> 33) * kPrime2;
    h = (h ^ h >> 29) * kPrime3;
    return h ^ h >> 32;
  }

private:
  static constexpr std::size_t kStripe = 32;
  static constexpr std::uint64_t kPrime1 = 0x9E3779B185EBCA87u, kPrime2 = 0xC2B2AE3D27D4EB4Fu,
                                 kPrime3 = 0x165667B19E3779F9u, kPrime4 = 0x85EBCA77C2B2AE63u,
                                 kPrime5 = 0x27D4EB2F165667C5u;

  /// Little-endian machines only, as all that the library runs on.
  template <class T>
  static std::uint64_t load(const unsigned char* p) {
    static_assert(std::endian::native == std::endian::little);
    T value;
    std::memcpy(&value, p, sizeof value);
    return value;
  }
  static std::uint64_t round(std::uint64_t lane, std::uint64_t word) {
    return std::rotl(lane + word * kPrime2, 31) * kPrime1;
  }
  void addStripe(const unsigned char* p) {
    for (std::size_t lane = 0; lane < mLanes.size(); ++lane)
      mLanes[lane] = round(mLanes[lane], load<std::uint64_t>(p + 8 * lane));
  }

  std::array<std::uint64_t, 4> mLanes{kPrime1 + kPrime2, kPrime2, 0, 0 - kPrime1};
  std::array<unsigned char, kStripe> mRest{};
  std::uint64_t mSize = 0;
};

} // namespace volcaustic
