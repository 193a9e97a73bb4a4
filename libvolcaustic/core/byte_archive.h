// Numbers, strings and vectors as bytes and back, for files that only the machine and version that wrote them read.
#pragma once

#include "volcaustic/run_context.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <type_traits>
#include <vector>

namespace volcaustic {

class ByteWriter {
public:
  /// Looks at ctx.cancel between pieces; what cannot be written is left to whoever looks at the stream.
  ByteWriter(std::streambuf& to, const RunContext& ctx) : mTo(to), mContext(ctx) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(const T& value) { raw(&value, sizeof value); }
  void operator()(const std::string& s) { text(s); }
  template <class T>
  void operator()(const std::vector<T>& v) {
    (*this)(static_cast<std::uint64_t>(v.size()));
    if constexpr (std::is_trivially_copyable_v<T>)
      raw(v.data(), v.size() * sizeof(T));
    else
      for (const T& element : v) (*this)(element);
  }
  void raw(const void* data, std::size_t size) {
    const auto* p = static_cast<const char*>(data);
    for (std::size_t at = 0; at < size; at += kPiece) {
      const auto part = static_cast<std::streamsize>(std::min(kPiece, size - at));
      mIsGood = mIsGood && mTo.sputn(p + at, part) == part;
      mSincePause += static_cast<std::size_t>(part);
      if (mSincePause < kPiece) continue;
      mContext.throwIfCancelled();
      mSincePause = 0;
    }
  }
  /// Whether everything was written.
  [[nodiscard]] bool good() const { return mIsGood; }

private:
  void text(const std::string& s) {
    (*this)(static_cast<std::uint64_t>(s.size()));
    raw(s.data(), s.size());
  }
  static constexpr std::size_t kPiece = 4 << 20;
  std::streambuf& mTo;
  const RunContext& mContext;
  std::size_t mSincePause = 0;
  bool mIsGood = true;
};

/// Reads what a ByteWriter wrote. \throws std::out_of_range where less is there than is asked for.
class ByteReader {
public:
  ByteReader(const char* begin, const char* end) : mAt(begin), mEnd(end) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void operator()(T& value) { raw(&value, sizeof value); }
  void operator()(std::string& s) {
    s.resize(count(1));
    raw(s.data(), s.size());
  }
  template <class T>
  void operator()(std::vector<T>& v) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      v.resize(count(sizeof(T)));
      raw(v.data(), v.size() * sizeof(T));
    } else {
      v.resize(count(1));
      for (T& element : v) (*this)(element);
    }
  }
  template <class T>
  T get() {
    T value;
    (*this)(value);
    return value;
  }
  void raw(void* data, std::size_t size) {
    if (size > static_cast<std::size_t>(mEnd - mAt)) throw std::out_of_range("bytes");
    if (size > 0) std::memcpy(data, mAt, size);
    mAt += size;
  }

private:
  /// A number of elements, each of at least `size` bytes, that can still be there.
  std::size_t count(std::size_t size) {
    const auto n = get<std::uint64_t>();
    if (n > static_cast<std::size_t>(mEnd - mAt) / size) throw std::out_of_range("bytes");
    return static_cast<std::size_t>(n);
  }
  const char *mAt, *mEnd;
};

} // namespace volcaustic
