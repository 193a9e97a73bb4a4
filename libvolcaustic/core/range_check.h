// Described options against the ranges of their description.
#pragma once

#include "volcaustic/error.h"
#include "volcaustic/options.h"

#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace volcaustic {

/// \throws Error(kind) for a number that is out of its range or none.
inline void requireWithin(ErrorKind kind, const std::string& place, const char* name, double value, double least,
                          double most) {
  if (std::isfinite(value) && value >= least && value <= most) return;
  std::ostringstream text;
  text << place << ": " << name << " is " << value << ", which is out of range; give a value from " << least << " to "
       << most;
  throw Error(kind, text.str());
}

/// A visitor of describe(): finite numbers within their range, also those of placements and lists.
class RangeCheck {
public:
  RangeCheck(ErrorKind kind, std::string place) : mKind(kind), mPlace(std::move(place)) {}

  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) const {
    check(name, value, doc);
  }

private:
  template <class T>
  requires std::is_arithmetic_v<T>
  void check(const char* name, const T& value, const FieldDoc& doc) const {
    if constexpr (!std::is_same_v<T, bool>)
      requireWithin(mKind, mPlace, name, static_cast<double>(value), doc.min, doc.max);
  }
  void check(const char*, Placement& value, const FieldDoc&) const { describe(*this, value); }
  template <class T, std::size_t N>
  void check(const char* name, std::array<T, N>& values, const FieldDoc& doc) const {
    for (T& value : values) check(name, value, doc);
  }
  template <class T>
  void check(const char* name, std::vector<T>& values, const FieldDoc& doc) const {
    for (T& value : values) check(name, value, doc);
  }

  ErrorKind mKind;
  std::string mPlace;
};

} // namespace volcaustic
