// An array that begins as zeros and costs memory only where it is written to: the system hands out its pages on the
// first write. For tables with an entry for each brick of a domain, most of which say "nothing here".
#pragma once

#include "core/large_memory.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace volcaustic {

template <class T>
class ZeroedTable {
  static_assert(std::is_trivially_copyable_v<T>);

public:
  ZeroedTable() = default;
  explicit ZeroedTable(std::size_t size) : mSize(size), mData(static_cast<T*>(allocateZeroed(bytes()))) {}
  /// The copy costs what the original does: zeros are not written again.
  ZeroedTable(const ZeroedTable& other) : ZeroedTable(other.mSize) {
    other.forEachWord(0, mSize, [&](std::size_t at, Word word) { std::memcpy(raw() + at, &word, sizeof word); });
  }
  ZeroedTable(ZeroedTable&& other) noexcept
      : mSize(std::exchange(other.mSize, 0)), mData(std::exchange(other.mData, nullptr)) {}
  ZeroedTable& operator=(ZeroedTable other) noexcept {
    std::swap(mSize, other.mSize);
    std::swap(mData, other.mData);
    return *this;
  }
  ~ZeroedTable() {
    if (mData) freeZeroed(mData, bytes());
  }

  [[nodiscard]] std::size_t size() const { return mSize; }
  [[nodiscard]] const T* data() const { return mData; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return mData[i]; }
  [[nodiscard]] T& operator[](std::size_t i) { return mData[i]; }

  /// Calls visit(i) for every entry of [begin, end) that is not zero, in order; runs of zeros are passed over quickly.
  template <class Visit>
  void forEachNonZero(std::size_t begin, std::size_t end, Visit&& visit) const {
    static_assert(sizeof(Word) % sizeof(T) == 0);
    forEachWord(begin, end, [&](std::size_t at, Word) {
      const std::size_t first = at / sizeof(T), last = first + sizeof(Word) / sizeof(T);
      for (std::size_t i = first < begin ? begin : first; i < last && i < end; ++i)
        if (mData[i] != T{}) visit(i);
    });
  }

private:
  using Word = std::uint64_t;

  /// Whole words, so that one can be read wherever an entry is.
  [[nodiscard]] std::size_t bytes() const {
    return (mSize * sizeof(T) + sizeof(Word) - 1) / sizeof(Word) * sizeof(Word);
  }
  [[nodiscard]] char* raw() { return reinterpret_cast<char*>(mData); }

  /// Calls visit(offset in bytes, word) for the words with entries of [begin, end) that are not zero.
  template <class Visit>
  void forEachWord(std::size_t begin, std::size_t end, Visit&& visit) const {
    const char* bytes = reinterpret_cast<const char*>(mData);
    for (std::size_t at = begin * sizeof(T) / sizeof(Word) * sizeof(Word); at < end * sizeof(T); at += sizeof(Word)) {
      Word word;
      std::memcpy(&word, bytes + at, sizeof word);
      if (word != 0) visit(at, word);
    }
  }

  std::size_t mSize = 0;
  T* mData = nullptr;
};

} // namespace volcaustic
