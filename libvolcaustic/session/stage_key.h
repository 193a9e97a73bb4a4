// What a stage's result depends on, part by part: its hash says whether to run, its parts say why.
#pragma once

#include "core/field_hash.h"

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace volcaustic {

class StageKey {
public:
  /// `version` changes whenever the stage makes something else of the same inputs.
  explicit StageKey(std::string_view version) { mHash.text(version); }

  /// A part at a place of the scene ("lights/0/direction") or of a stage before.
  void add(std::string place, const Hash& part) {
    mHash.text(place).value(part.digest());
    mParts.emplace_back(std::move(place), part.digest());
  }
  void add(std::string place, std::uint64_t part) { add(std::move(place), Hash().value(part)); }
  void add(std::string place, const StageKey& stage) { add(std::move(place), stage.digest()); }
  /// Every described field under `place`; lists of described structs element by element.
  template <class Options>
  void addFields(const std::string& place, Options options) {
    describe(FieldParts{*this, place.empty() ? place : place + "/"}, options);
  }

  [[nodiscard]] std::uint64_t digest() const { return mHash.digest(); }
  [[nodiscard]] std::string hex() const { return mHash.hex(); }
  /// Places whose parts differ, or that only one of both has, in the order of this key, then of the other.
  [[nodiscard]] std::vector<std::string> differences(const StageKey& other) const;

private:
  struct FieldParts {
    StageKey& key;
    std::string prefix;
    template <class T>
    void operator()(const char* name, const T& value, const FieldDoc& doc) const {
      Hash hash;
      FieldHash visitor(hash);
      visitor(name, value, doc);
      key.add(prefix + name, hash);
    }
    template <class T>
    requires std::is_class_v<T>
    void operator()(const char* name, const std::vector<T>& values, const FieldDoc& doc) const {
      if constexpr (std::is_same_v<T, std::string>) {
        (*this).template operator()<std::vector<T>>(name, values, doc);
      } else {
        for (std::size_t i = 0; i < values.size(); ++i)
          key.addFields(prefix + name + "/" + std::to_string(i), values[i]);
      }
    }
  };

  Hash mHash;
  std::vector<std::pair<std::string, std::uint64_t>> mParts;
};

} // namespace volcaustic
