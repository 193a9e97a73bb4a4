// A shape as a list of instructions for a stack of numbers: copies are written out, placements are taken into the
// functions. What cannot matter in a box is cut out of the program for it, so that the cost of a point goes by what is
// near it (Keeter, Massively parallel rendering of complex closed-form implicit surfaces, 2020).
#pragma once

#include "shapes/batch.h"
#include "shapes/interval.h"
#include "volcaustic/shape.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace volcaustic {

/// Room for evaluations, of one thread; grows to what the programs it is used with need.
class ShapeScratch {
public:
  /// Numbers of a batch for `depth` levels of the stack.
  double* numbers(std::size_t depth);
  std::uint32_t* parts(std::size_t depth);

  std::vector<Interval> bounds; // of each instruction

private:
  std::vector<double> mNumbers;
  std::vector<std::uint32_t> mParts;
};

class ShapeProgram {
public:
  ShapeProgram() = default; ///< of the empty shape
  /// \throws Error(Input) for a shape of more than a million instructions
  explicit ShapeProgram(const Shape& shape);

  /// A program without instructions has no value: everything is outside.
  [[nodiscard]] bool empty() const { return mCode.empty(); }
  [[nodiscard]] std::size_t size() const { return mCode.size(); }

  /// Holds the values of all points of the box.
  [[nodiscard]] Interval bound(const Box& box, ShapeScratch& scratch) const;
  /// bound(), and into `pruned` (another program, whose memory is used again) what gives the same values and parts to
  /// the bit at every point of the box.
  Interval prune(const Box& box, ShapeProgram& pruned, ShapeScratch& scratch) const;

  /// Values at points of world space, positive inside. The value at a point does not depend on the other points.
  void values(const ShapePoints& points, double* values, ShapeScratch& scratch) const;
  /// Values and gradients.
  void gradients(const ShapePoints& points, const ShapeValues& values, ShapeScratch& scratch) const;
  /// Of the part that makes the surface next to each point: an index into partNames().
  void parts(const ShapePoints& points, std::uint32_t* parts, ShapeScratch& scratch) const;

  /// Programs of the same hash, also of different shapes, give the same values and names of parts at all points.
  [[nodiscard]] std::uint64_t hash() const;
  [[nodiscard]] const std::vector<std::string>& partNames() const;

private:
  enum class Op : std::uint8_t {
    Function,      ///< puts a function's value on the stack
    Quadric,       ///< the same of a quadric with some of its deviations
    Maximum,       ///< of the two topmost numbers: union
    Minimum,       ///< intersection
    SmoothMaximum, ///< the same where they are within `constant` of each other, joined smoothly
    SmoothMinimum,
    Add,         ///< the two topmost numbers
    AddConstant, ///< `constant` to the topmost number
    Negate,      ///< the topmost number
  };
  struct Instruction {
    Op op;
    std::uint32_t size = 1;  ///< instructions of what it works on, itself included; they stand right before it
    std::uint32_t index = 0; ///< of the function
    std::uint32_t part = 0;  ///< that a function makes the surface of
    std::uint32_t firstDeviation = 0, deviations = 0; ///< of a quadric, in mDeviations
    double constant = 0;
  };
  struct Tables; // functions and names, shared by all programs that were cut out of one
  friend class ShapeCompiler;
  friend class ShapeRun;

  /// Of the root of the first of the two that instruction `i` works on; the second is i - 1.
  [[nodiscard]] std::size_t firstOf(std::size_t i) const { return i - 1 - mCode[i - 1].size; }
  [[nodiscard]] std::span<const std::uint32_t> deviationsOf(const Instruction& at) const;
  void computeBounds(const Box& box, std::vector<Interval>& bounds) const;
  void keep(std::size_t i, const ShapeProgram& from, const Box& box, const std::vector<Interval>& bounds);
  void finish();

  std::vector<Instruction> mCode; // each after what it works on
  std::vector<std::uint32_t> mDeviations;
  std::uint32_t mDepth = 0; // of the stack
  std::shared_ptr<const Tables> mTables;
};

} // namespace volcaustic
