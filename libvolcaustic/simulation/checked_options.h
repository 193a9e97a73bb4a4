// Described options against the ranges of their description.
#pragma once

#include "volcaustic/error.h"
#include "volcaustic/options.h"

#include <cmath>
#include <string>

namespace volcaustic {

/// A visitor of described fields. \throws Error(Usage) for the first that is out of its range or not a number.
class RangeCheck {
public:
  explicit RangeCheck(std::string place) : mPlace(std::move(place)) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const char* name, const Number& value, const FieldDoc& doc) const { check(name, value, doc); }
  void operator()(const char* name, const Vec3d& values, const FieldDoc& doc) const {
    for (const double value : values) check(name, value, doc);
  }

private:
  void check(const char* name, double value, const FieldDoc& doc) const {
    if (std::isfinite(value) && value >= doc.min && value <= doc.max) return;
    throw Error(ErrorKind::Usage, mPlace + ": " + name + " is " + std::to_string(value) + "; give a number from " +
                                      std::to_string(doc.min) + " to " + std::to_string(doc.max));
  }

  std::string mPlace;
};

template <class Options>
void checkRanges(const char* place, Options options) {
  describe(RangeCheck(place), options);
}

} // namespace volcaustic
