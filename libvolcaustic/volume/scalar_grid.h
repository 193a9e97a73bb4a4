// Grids of any number type as the two types that volcaustic computes with.
#pragma once

#include "volcaustic/run_context.h"

#include <openvdb/openvdb.h>
#include <string>

namespace volcaustic {

/// By the name of a grid's type: one number a voxel (float, double, half in the file, int, bool), or three of them.
bool isScalarType(const std::string& type);
bool isVectorType(const std::string& type);

/// The grid as one of floats: numbers rounded, of vectors their length. Active voxels, transform and metadata stay;
/// floats share the tree. Null for any other type.
openvdb::FloatGrid::Ptr asFloatGrid(const openvdb::GridBase::Ptr& grid, const RunContext& ctx);
/// The same for vectors. Null for any other type.
openvdb::Vec3SGrid::Ptr asVec3Grid(const openvdb::GridBase::Ptr& grid, const RunContext& ctx);

} // namespace volcaustic
