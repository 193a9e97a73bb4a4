#include "core/field_hash.h"
#include "shapes/affine.h"
#include "shapes/noise.h"
#include "shapes/program.h"
#include "shapes/revolution.h"
#include "shapes/solids.h"
#include "shapes/stored_shape.h"
#include "shapes/tables.h"
#include "shapes/waves.h"
#include "volcaustic/error.h"
#include "volcaustic/shape_fields.h"

#include <algorithm>

namespace volcaustic {

/// Writes a shape's nodes out, parts before what works on them.
class ShapeCompiler {
public:
  explicit ShapeCompiler(ShapeProgram& program) : mProgram(program), mTables(std::make_shared<Tables>()) {}

  void run(const Shape& shape) {
    add(shape, kIdentity, 0);
    mProgram.mTables = std::move(mTables);
    mProgram.finish();
  }

private:
  using Op = ShapeProgram::Op;
  using Tables = ShapeProgram::Tables;
  /// Where a node is, and whose surface it makes.
  struct Place {
    Affine toWorld;
    std::uint32_t part;
  };

  std::uint32_t partOf(const std::string& name, std::uint32_t around) {
    if (name.empty()) return around;
    auto& names = mTables->partNames;
    const auto index = std::find(names.begin(), names.end(), name) - names.begin();
    if (index == std::ssize(names)) names.push_back(name);
    return static_cast<std::uint32_t>(index);
  }

  /// \param part that nodes without a name belong to
  void add(const Shape& shape, const Affine& around, std::uint32_t part) {
    const ShapeNode& node = shape.node();
    const Place place{product(around, affine(node.placement)), partOf(node.name, part)};
    std::visit([&](const auto& kind) { addKind(kind, node, place); }, node.kind);
  }

  void put(ShapeProgram::Instruction instruction, std::size_t begin) {
    instruction.size = static_cast<std::uint32_t>(mProgram.mCode.size() - begin + 1);
    mProgram.mCode.push_back(instruction);
  }
  std::size_t here() const { return mProgram.mCode.size(); }

  template <class Solid>
  void putFunction(std::unique_ptr<ShapeFunction> function, const Solid& solid, const Place& place) {
    Hash hash;
    hash.value(shapes::Kind(solid).index());
    addFields(hash, solid);
    for (const auto& row : place.toWorld) hash.values(std::span<const double>(row));
    mTables->functions.push_back({placedFunction(std::move(function), place.toWorld), hash.digest()});
    ShapeProgram::Instruction i{Op::Function};
    i.index = static_cast<std::uint32_t>(mTables->functions.size() - 1);
    i.part = place.part;
    put(i, here());
  }

  void putQuadric(const QuadraticForm& form, const std::vector<Deviation>& deviations, const Place& place) {
    std::vector<QuadraticForm> regions;
    std::vector<double> weights;
    ShapeProgram::Instruction i{Op::Quadric};
    i.part = place.part;
    i.firstDeviation = static_cast<std::uint32_t>(mProgram.mDeviations.size());
    i.deviations = static_cast<std::uint32_t>(deviations.size());
    for (const Deviation& d : deviations) {
      const ShapeNode& region = d.region.node();
      regions.push_back(placedForm(quadraticForm(region.kind), product(place.toWorld, affine(region.placement))));
      weights.push_back(d.weight);
      mProgram.mDeviations.push_back(static_cast<std::uint32_t>(regions.size() - 1));
    }
    mTables->quadrics.emplace_back(placedForm(form, place.toWorld), regions, weights);
    i.index = static_cast<std::uint32_t>(mTables->quadrics.size() - 1);
    put(i, here());
  }

  void putOperation(Op op, double constant, std::size_t begin) {
    ShapeProgram::Instruction i{op};
    i.constant = constant;
    put(i, begin);
  }

  /// A set operation; a blend is a length of the node's own space.
  void putJoin(Op sharp, double blend, const Place& place, std::size_t begin) {
    const double k = blend * leastStretch(place.toWorld);
    const Op smooth = sharp == Op::Maximum ? Op::SmoothMaximum : Op::SmoothMinimum;
    putOperation(k > 0 ? smooth : sharp, k, begin);
  }

  /// Joins what add(0) .. add(count - 1) put, in halves: a stack of some copies, and bounds of few of them at once.
  template <class Add>
  void joinAll(Op op, double blend, const Place& place, std::size_t first, std::size_t count, const Add& addOne) {
    if (count == 1) {
      addOne(first);
      return;
    }
    const std::size_t begin = here(), half = (count + 1) / 2;
    joinAll(op, blend, place, first, half, addOne);
    joinAll(op, blend, place, first + half, count - half, addOne);
    putJoin(op, blend, place, begin);
  }

  void joinParts(Op op, double blend, const ShapeNode& node, const Place& place, std::size_t first = 0) {
    joinAll(op, blend, place, first, node.parts.size() - first,
            [&](std::size_t i) { add(node.parts[i], place.toWorld, place.part); });
  }

  // Solids.
  template <class QuadricKind>
  void addKind(const QuadricKind& kind, const ShapeNode& node, const Place& place) {
    const std::size_t begin = here();
    putQuadric(quadraticForm(node.kind), node.deviations, place);
    addEnds(kind, place, begin);
  }
  template <class Kind>
  void addEnds(const Kind&, const Place&, std::size_t) {}
  void addEnds(const shapes::Cylinder& s, const Place& place, std::size_t begin) {
    if (!s.endless) cut(-.5 * s.height, .5 * s.height, place, begin);
  }
  void addEnds(const shapes::Hyperboloid& s, const Place& place, std::size_t begin) {
    if (!s.endless) cut(-.5 * s.height, .5 * s.height, place, begin);
  }
  void addEnds(const shapes::Cone& s, const Place& place, std::size_t begin) {
    if (!s.endless) cut(0, s.height, place, begin);
  }
  void addEnds(const shapes::Paraboloid& s, const Place& place, std::size_t begin) {
    if (!s.endless) cut(-s.height, s.height, place, begin);
  }
  /// To low <= z <= high of the node's own space.
  void cut(double low, double high, const Place& place, std::size_t begin) {
    const double middle = .5 * (low + high), half = .5 * (high - low);
    QuadraticForm slab{{0, 0, middle}, {0, 0, -1 / (half * half)}, {}, 1};
    putQuadric(slab, {}, place);
    putOperation(Op::Minimum, 0, begin);
  }

  void addKind(const shapes::Cuboid& s, const ShapeNode&, const Place& place) { putFunction(makeCuboid(s), s, place); }
  void addKind(const shapes::Torus& s, const ShapeNode&, const Place& place) { putFunction(makeTorus(s), s, place); }
  void addKind(const shapes::Capsule& s, const ShapeNode&, const Place& place) {
    putFunction(makeCapsule(s), s, place);
  }
  void addKind(const shapes::Revolution& s, const ShapeNode&, const Place& place) {
    putFunction(makeRevolution(s), s, place);
  }
  void addKind(const shapes::Extrusion& s, const ShapeNode&, const Place& place) {
    putFunction(makeExtrusion(s), s, place);
  }

  // Operations.
  void addKind(const shapes::Union& s, const ShapeNode& node, const Place& place) {
    joinParts(Op::Maximum, s.blend, node, place);
  }
  void addKind(const shapes::Intersection& s, const ShapeNode& node, const Place& place) {
    joinParts(Op::Minimum, s.blend, node, place);
  }
  void addKind(const shapes::Difference& s, const ShapeNode& node, const Place& place) {
    const std::size_t begin = here();
    add(node.parts[0], place.toWorld, place.part);
    if (node.parts.size() == 1) return;
    const std::size_t others = here();
    joinParts(Op::Maximum, s.blend, node, place, 1);
    putOperation(Op::Negate, 0, others);
    putJoin(Op::Minimum, s.blend, place, begin);
  }
  void addKind(const shapes::Complement&, const ShapeNode& node, const Place& place) {
    const std::size_t begin = here();
    add(node.parts[0], place.toWorld, place.part);
    putOperation(Op::Negate, 0, begin);
  }
  void addKind(const shapes::Offset& s, const ShapeNode& node, const Place& place) {
    const std::size_t begin = here();
    add(node.parts[0], place.toWorld, place.part);
    putOperation(Op::AddConstant, s.distance * leastStretch(place.toWorld), begin);
  }
  /// f and not f - thickness.
  void addKind(const shapes::Shell& s, const ShapeNode& node, const Place& place) {
    const std::size_t begin = here();
    add(node.parts[0], place.toWorld, place.part);
    const std::size_t inner = here();
    add(node.parts[0], place.toWorld, place.part);
    putOperation(Op::AddConstant, -s.thickness * leastStretch(place.toWorld), inner);
    putOperation(Op::Negate, 0, inner);
    putOperation(Op::Minimum, 0, begin);
  }
  void addKind(const shapes::NoiseDisplacement& s, const ShapeNode& node, const Place& place) {
    displace(makeNoise(s), s, node, place);
  }
  void addKind(const shapes::WaveDisplacement& s, const ShapeNode& node, const Place& place) {
    displace(makeWaves(s), s, node, place);
  }
  template <class Displacement>
  void displace(std::unique_ptr<ShapeFunction> function, const Displacement& s, const ShapeNode& node,
                const Place& place) {
    const std::size_t begin = here();
    add(node.parts[0], place.toWorld, place.part);
    putFunction(std::move(function), s, place);
    putOperation(Op::Add, 0, begin);
  }

  void addKind(const shapes::Array& s, const ShapeNode& node, const Place& place) {
    std::vector<Affine> steps{kIdentity};
    const Affine step = affine(s.step);
    while (steps.size() < std::size_t(s.count)) steps.push_back(product(step, steps.back()));
    addCopies(steps, s.blend, node, place);
  }
  void addKind(const shapes::Instances& s, const ShapeNode& node, const Place& place) {
    std::vector<Affine> steps;
    for (const Placement& p : s.placements) steps.push_back(affine(p));
    addCopies(steps, s.blend, node, place);
  }
  void addCopies(const std::vector<Affine>& steps, double blend, const ShapeNode& node, const Place& place) {
    joinAll(Op::Maximum, blend, place, 0, steps.size(),
            [&](std::size_t i) { add(node.parts[0], product(place.toWorld, steps[i]), place.part); });
  }

  ShapeProgram& mProgram;
  std::shared_ptr<Tables> mTables;
};

ShapeProgram::ShapeProgram(const Shape& shape) {
  if (shape.empty()) {
    mTables = std::make_shared<Tables>();
    return;
  }
  if (StoredShape::of(shape).size > StoredShape::kLargest)
    throw Error(ErrorKind::Input, "shape: more than a million solids and operations once its copies are written out; "
                                  "take fewer copies");
  ShapeCompiler(*this).run(shape);
}

} // namespace volcaustic
