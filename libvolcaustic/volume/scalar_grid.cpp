#include "volume/scalar_grid.h"

#include "volume/grid_values.h"

namespace volcaustic {

namespace {

using Scalars = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                  openvdb::BoolGrid>;
using Vectors = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

template <class List>
bool isOneOf(const std::string& type) {
  bool found = false;
  List::foreach ([&](const auto& grid) { found |= type == std::decay_t<decltype(grid)>::gridType(); });
  return found;
}

/// Shares what is of the type already, else converts value by value.
template <class Target, class List>
typename Target::Ptr converted(const openvdb::GridBase::Ptr& grid, const RunContext& ctx) {
  typename Target::Ptr result;
  grid->apply<List>([&](auto& typed) {
    if constexpr (std::is_same_v<std::decay_t<decltype(typed)>, Target>) {
      result = typed.copy();
    } else {
      result = mappedGrid<Target>(typed, Active::AsBefore, ctx,
                                  [](const auto& value) { return typename Target::ValueType(value); });
      result->insertMeta(typed);
    }
  });
  return result;
}

} // namespace

bool isScalarType(const std::string& type) { return isOneOf<Scalars>(type); }
bool isVectorType(const std::string& type) { return isOneOf<Vectors>(type); }

openvdb::FloatGrid::Ptr asFloatGrid(const openvdb::GridBase::Ptr& grid, const RunContext& ctx) {
  if (const auto vectors = asVec3Grid(grid, ctx))
    return mappedGrid<openvdb::FloatGrid>(*vectors, Active::AsBefore, ctx,
                                          [](const openvdb::Vec3s& value) { return value.length(); });
  return converted<openvdb::FloatGrid, Scalars>(grid, ctx);
}

openvdb::Vec3SGrid::Ptr asVec3Grid(const openvdb::GridBase::Ptr& grid, const RunContext& ctx) {
  return converted<openvdb::Vec3SGrid, Vectors>(grid, ctx);
}

} // namespace volcaustic
