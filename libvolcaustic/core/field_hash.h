// Described structs (volcaustic/options.h) into a hash: keys of stages, of shapes.
#pragma once

#include "core/hash.h"
#include "volcaustic/options.h"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// A visitor of describe() that adds every field, its name included.
class FieldHash {
public:
  explicit FieldHash(Hash& hash) : mHash(hash) {}
  template <class T>
  void operator()(const char* name, const T& value, const FieldDoc&) {
    mHash.text(name);
    add(value);
  }

private:
  void add(const std::string& v) { mHash.text(v); }
  void add(const std::filesystem::path& v) { mHash.text(v.string()); }
  template <class T>
  void add(const std::vector<T>& v) {
    mHash.value(v.size());
    for (const T& element : v) add(element);
  }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& v) {
    mHash.values(std::span<const T>(v));
  }
  template <class T>
  void add(const T& v) {
    if constexpr (std::is_class_v<T>) {
      T copy = v; // describe() hands out references that a reader may write to
      describe(*this, copy);
    } else {
      mHash.value(v);
    }
  }

  Hash& mHash;
};

template <class Options>
void addFields(Hash& hash, Options options) {
  FieldHash visitor(hash);
  describe(visitor, options);
}

} // namespace volcaustic
