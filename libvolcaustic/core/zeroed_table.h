// An array that begins as zeros and costs memory only where it is written to: the system hands out its pages on the
// first write. For tables with an entry for each brick of a domain, most of which say "nothing here".
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace volcaustic {

template <class T>
class ZeroedTable {
  static_assert(std::is_trivially_copyable_v<T>);

public:
  ZeroedTable() = default;
  explicit ZeroedTable(std::size_t size)
      : mSize(size), mData(static_cast<T*>(std::calloc(size > 0 ? size : 1, sizeof(T)))) {
    if (!mData) throw std::bad_alloc();
  }

  [[nodiscard]] std::size_t size() const { return mSize; }
  [[nodiscard]] const T* data() const { return mData.get(); }
  [[nodiscard]] const T& operator[](std::size_t i) const { return mData[i]; }
  [[nodiscard]] T& operator[](std::size_t i) { return mData[i]; }

private:
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::size_t mSize = 0;
  std::unique_ptr<T[], Free> mData;
};

} // namespace volcaustic
