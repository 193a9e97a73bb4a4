#include "shapes/program.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace volcaustic {

namespace {

/// Points in array after array, as programs take them.
struct Points {
  Points(std::span<const Vec3d> points, std::size_t begin)
      : count(static_cast<int>(std::min<std::size_t>(points.size() - begin, kShapeBatch))) {
    for (int i = 0; i < count; ++i) {
      x[i] = points[begin + i][0];
      y[i] = points[begin + i][1];
      z[i] = points[begin + i][2];
    }
  }
  operator ShapePoints() const { return {x.data(), y.data(), z.data(), count}; }

  int count;
  BatchNumbers x, y, z;
};

/// A cube that points of the shape may be in, and the program for it.
struct Cube {
  Vec3d corner;
  double edge;
  std::shared_ptr<const ShapeProgram> program;
};

/// Finds a box around what is inside. From a cube of all that coordinates reach, cubes are divided, and those that
/// nothing is in dropped, until they are small against the box of them all; then each face is looked for by itself.
class BoundsSearch {
public:
  explicit BoundsSearch(const ShapeProgram& program) : mProgram(std::make_shared<ShapeProgram>(program)) {}

  Box run() {
    std::vector<Cube> cubes{{{kCorner, kCorner, kCorner}, kEdge, mProgram}};
    for (double edge = kEdge;; edge *= .5) {
      if (cubes.empty()) return {};
      const double longest = longestSide(hull(cubes));
      if (cubes.size() > kMany || edge < longest / 16 || edge < kSmallest) {
        if (longest > kReach)
          throw Error(ErrorKind::Input, "shape: has no end (it reaches beyond 1e9 world units); intersect it with a "
                                        "solid that has one");
        return closeBox(cubes, longest);
      }
      std::vector<Cube> halves;
      for (const Cube& cube : cubes) divide(cube, [&](Cube half) { halves.push_back(std::move(half)); });
      cubes = std::move(halves);
    }
  }

private:
  static constexpr double kReach = 0x1p30, kSmallest = 0x1p-60;
  /// The cube of all that is looked at. Its middle is off by what is no fraction of a power of two: so hardly ever does
  /// a cube's face lie in one of a shape, which it would touch from outside.
  static constexpr double kCorner = -1.0683 * kReach, kEdge = 2.2 * kReach;
  static constexpr std::size_t kMany = 4096;

  static Box hull(const std::vector<Cube>& cubes) {
    Box box{cubes.front().corner, cubes.front().corner};
    for (const Cube& cube : cubes)
      for (int a = 0; a < 3; ++a) {
        box.min[a] = std::min(box.min[a], cube.corner[a]);
        box.max[a] = std::max(box.max[a], cube.corner[a] + cube.edge);
      }
    return box;
  }
  static double longestSide(const Box& b) {
    return std::max({b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]});
  }

  /// Gets the eighths of a cube that points of the shape may be in.
  template <class Take>
  void divide(const Cube& cube, const Take& take) {
    for (int i = 0; i < 8; ++i) {
      Cube half{cube.corner, .5 * cube.edge, nullptr};
      for (int a = 0; a < 3; ++a) half.corner[a] += i >> a & 1 ? half.edge : 0;
      Box box{half.corner, half.corner};
      for (double& c : box.max) c += half.edge;
      auto pruned = std::make_shared<ShapeProgram>();
      if (cube.program->prune(box, *pruned, mScratch).high < 0) continue;
      half.program = std::move(pruned);
      take(std::move(half));
    }
  }

  Box closeBox(const std::vector<Cube>& cubes, double longest) {
    const Box around = hull(cubes);
    Box box = around;
    for (int a = 0; a < 3; ++a) {
      box.min[a] = face(around, a, -1, longest / 256);
      box.max[a] = face(around, a, 1, longest / 256);
    }
    return box;
  }

  /// The coordinate beyond which a box holds nothing, to within `finest`.
  double face(const Box& around, int axis, int side, double finest) {
    const double outermost = side > 0 ? around.max[axis] : around.min[axis];
    double empty = 0, held = around.max[axis] - around.min[axis]; // depths beneath the outermost
    while (held - empty > finest) {
      const double depth = .5 * (empty + held), one = outermost - side * empty, other = outermost - side * depth;
      Box slice = around;
      slice.min[axis] = std::min(one, other);
      slice.max[axis] = std::max(one, other);
      std::size_t looks = 0;
      (mayHold(*mProgram, slice, finest, looks) ? held : empty) = depth;
    }
    return outermost - side * empty;
  }

  /// Whether there may be something in a box, as far as boxes of the finest size tell and not too many of them.
  bool mayHold(const ShapeProgram& program, const Box& box, double finest, std::size_t& looks) {
    ShapeProgram pruned;
    if (program.prune(box, pruned, mScratch).high < 0) return false;
    int widest = 0;
    Vec3d middle;
    for (int a = 0; a < 3; ++a) {
      middle[a] = .5 * (box.min[a] + box.max[a]);
      if (box.max[a] - box.min[a] > box.max[widest] - box.min[widest]) widest = a;
    }
    double value;
    pruned.values({&middle[0], &middle[1], &middle[2], 1}, &value, mScratch);
    if (value >= 0 || box.max[widest] - box.min[widest] <= finest || ++looks > kMostLooks) return true;
    Box low = box, high = box;
    low.max[widest] = high.min[widest] = middle[widest];
    return mayHold(pruned, low, finest, looks) || mayHold(pruned, high, finest, looks);
  }
  static constexpr std::size_t kMostLooks = 4000;

  std::shared_ptr<const ShapeProgram> mProgram;
  ShapeScratch mScratch;
};

} // namespace

ShapeField::ShapeField(const Shape& shape) : mProgram(std::make_unique<const ShapeProgram>(shape)) {}
ShapeField::~ShapeField() = default;
ShapeField::ShapeField(ShapeField&&) noexcept = default;
ShapeField& ShapeField::operator=(ShapeField&&) noexcept = default;

void ShapeField::values(std::span<const Vec3d> pWorld, std::span<double> values) const {
  ShapeScratch scratch;
  for (std::size_t begin = 0; begin < pWorld.size(); begin += kShapeBatch)
    mProgram->values(Points(pWorld, begin), values.data() + begin, scratch);
}

void ShapeField::gradients(std::span<const Vec3d> pWorld, std::span<Vec3d> gradients) const {
  ShapeScratch scratch;
  BatchNumbers value, x, y, z;
  for (std::size_t begin = 0; begin < pWorld.size(); begin += kShapeBatch) {
    const Points points(pWorld, begin);
    mProgram->gradients(points, {value.data(), {x.data(), y.data(), z.data()}}, scratch);
    for (int i = 0; i < points.count; ++i) gradients[begin + i] = {x[i], y[i], z[i]};
  }
}

void ShapeField::parts(std::span<const Vec3d> pWorld, std::span<std::uint32_t> parts) const {
  ShapeScratch scratch;
  for (std::size_t begin = 0; begin < pWorld.size(); begin += kShapeBatch)
    mProgram->parts(Points(pWorld, begin), parts.data() + begin, scratch);
}

Interval ShapeField::bound(const Box& box) const {
  ShapeScratch scratch;
  return mProgram->bound(box, scratch);
}

Box ShapeField::bounds() const {
  if (mProgram->empty()) return {};
  return BoundsSearch(*mProgram).run();
}

const std::vector<std::string>& ShapeField::partNames() const { return mProgram->partNames(); }

} // namespace volcaustic
