// A .usda for .vdb files, in the terms of OpenUSD's schemas UsdVol (Volume, OpenVDBAsset) and UsdGeom.
#include "volcaustic/usd.h"

#include "core/atomic_file.h"
#include "volume/vdb_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <locale>
#include <map>
#include <optional>
#include <set>
#include <sstream>

namespace volcaustic {

namespace {

struct Field {
  std::string prim;      ///< an identifier, unique among the fields
  std::string name;      ///< of the grid
  int index = 0;         ///< among the grids of that name
  const char* type;      ///< one of UsdVol's fieldDataType
  const char* gridClass; ///< fieldClass
  const char* role;      ///< vectorDataRoleHint
  std::map<int, std::string> files;
};

struct TypeName {
  const char *value, *usd;
};
constexpr TypeName kTypes[] = {{"float", "float"}, {"double", "double"}, {"int32", "int"},    {"int64", "int64"},
                               {"bool", "bool"},   {"mask", "mask"},     {"vec3s", "float3"}, {"vec3d", "double3"},
                               {"vec3i", "int3"},  {"string", "string"}};

/// Null where OpenUSD has no such type, as for points.
const char* dataType(const openvdb::GridBase& grid) {
  for (const TypeName& type : kTypes)
    if (grid.valueType() == type.value && !grid.type().starts_with("Tree_ptdata")) return type.usd;
  return nullptr;
}

const char* classOf(const openvdb::GridBase& grid) {
  switch (grid.getGridClass()) {
  case openvdb::GRID_LEVEL_SET:
    return "levelSet";
  case openvdb::GRID_FOG_VOLUME:
    return "fogVolume";
  case openvdb::GRID_STAGGERED:
    return "staggered";
  default:
    return "unknown";
  }
}

const char* roleOf(const openvdb::GridBase& grid, const std::string& type) {
  if (!type.ends_with('3')) return "None";
  switch (grid.getVectorType()) {
  case openvdb::VEC_INVARIANT:
    return "Color";
  case openvdb::VEC_COVARIANT:
  case openvdb::VEC_COVARIANT_NORMALIZE:
    return "Normal";
  case openvdb::VEC_CONTRAVARIANT_ABSOLUTE:
    return "Point";
  default:
    return "Vector";
  }
}

/// Letters, digits and underscores, the first no digit; another name where it is taken.
std::string identifier(const std::string& name, std::set<std::string>& taken) {
  std::string id = name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) ? "_" + name : name;
  for (char& c : id)
    if (!std::isalnum(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) > 127) c = '_';
  std::string free = id;
  for (int i = 1; !taken.insert(free).second; ++i) free = id + "_" + std::to_string(i);
  return free;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

/// A file as seen from the stage's folder.
std::string asset(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::filesystem::path seen = std::filesystem::absolute(file).lexically_normal().lexically_proximate(folder);
  std::string text = seen.generic_string();
  if (seen.is_relative() && !text.starts_with("..")) text = "./" + text;
  const char* mark = text.find('@') == std::string::npos ? "@" : "@@@";
  return mark + text + mark;
}

Vec3d vec3(const openvdb::Vec3d& v) { return {v[0], v[1], v[2]}; }

/// The domain that the file names, else the boxes of the grids' active voxels together.
std::optional<Box> boxOf(const VdbFile& file) {
  const auto dims = file.metadata.getMetadata<openvdb::Vec3IMetadata>(metadata_key::kDims);
  const auto corner = file.metadata.getMetadata<openvdb::Vec3DMetadata>(metadata_key::kMinCorner);
  const auto edge = file.metadata.getMetadata<openvdb::DoubleMetadata>(metadata_key::kVoxelSize);
  if (dims && corner && edge)
    return Box{vec3(corner->value()), vec3(corner->value() + openvdb::Vec3d(dims->value()) * edge->value())};
  openvdb::BBoxd box;
  for (const auto& grid : file.grids)
    if (const openvdb::CoordBBox active = grid->evalActiveVoxelBoundingBox(); !active.empty())
      box.expand(
          grid->transform().indexToWorld(openvdb::BBoxd(active.min().asVec3d() - 0.5, active.max().asVec3d() + 0.5)));
  if (box.empty()) return std::nullopt;
  return Box{vec3(box.min()), vec3(box.max())};
}

/// What the stage will say, gathered file by file.
class Stage {
public:
  explicit Stage(const std::filesystem::path& path)
      : mFolder(std::filesystem::absolute(path).lexically_normal().parent_path()) {}

  void add(const UsdFrame& frame, const RunContext& ctx) {
    const std::string place = frame.file.string();
    if (frame.file.extension() != ".vdb")
      throw Error(ErrorKind::Usage, place + ": OpenUSD reads volumes from .vdb files; name one");
    const VdbFile file = readVdbFile(frame.file, ctx);
    std::map<std::string, int> seen;
    bool any = false;
    for (const auto& grid : file.grids) {
      const char* type = dataType(*grid);
      const std::string name = grid->getName();
      const int index = seen[name]++;
      if (!type) {
        ctx.warn(place + ": " + name + ": OpenUSD knows no fields of type " + grid->type() + "; left out");
        continue;
      }
      any = true;
      Field& field = find(name, index, *grid, type);
      if (std::strcmp(field.type, type) != 0)
        throw Error(ErrorKind::Input, place + ": " + name + ": is " + type + ", but " + field.type +
                                          " in the frames before; give one sequence its own stage");
      field.files[frame.frame] = asset(frame.file, mFolder);
    }
    if (!any) throw Error(ErrorKind::Input, place + ": holds no grid that OpenUSD knows");
    if (const std::optional<Box> box = boxOf(file)) mExtents[frame.frame] = *box;
    mFrames.insert(frame.frame);
  }

  [[nodiscard]] std::string text(const UsdWriteOptions& options) const {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(9);
    out << "#usda 1.0\n(\n    defaultPrim = \"volcaustic\"\n    doc = \"written by volcaustic " VOLCAUSTIC_VERSION
           "\"\n";
    if (mFrames.size() > 1)
      out << "    endTimeCode = " << *mFrames.rbegin() << "\n    framesPerSecond = " << options.rate << '\n';
    out << "    metersPerUnit = " << options.metersPerUnit << '\n';
    if (mFrames.size() > 1)
      out << "    startTimeCode = " << *mFrames.begin() << "\n    timeCodesPerSecond = " << options.rate << '\n';
    out << "    upAxis = \"" << (options.upAxis == UpAxis::Y ? 'Y' : 'Z') << "\"\n)\n\n"
        << "def Xform \"volcaustic\" (\n    kind = \"component\"\n)\n{\n    def Volume \"volume\"\n    {\n";
    writeExtent(out);
    for (const Field& field : mFields)
      out << "        custom rel field:" << field.prim << " = </volcaustic/volume/" << field.prim << ">\n";
    for (const Field& field : mFields) writeField(out, field);
    out << "    }\n}\n";
    return out.str();
  }

private:
  Field& find(const std::string& name, int index, const openvdb::GridBase& grid, const char* type) {
    for (Field& field : mFields)
      if (field.name == name && field.index == index) return field;
    return mFields.emplace_back(
        Field{identifier(name, mPrims), name, index, type, classOf(grid), roleOf(grid, type), {}});
  }

  static void writeBox(std::ostream& out, const Box& box) {
    out << "[(" << box.min[0] << ", " << box.min[1] << ", " << box.min[2] << "), (" << box.max[0] << ", " << box.max[1]
        << ", " << box.max[2] << ")]";
  }

  void writeExtent(std::ostream& out) const {
    if (mExtents.empty()) return;
    const auto same = [&](const auto& item) {
      return item.second.min == mExtents.begin()->second.min && item.second.max == mExtents.begin()->second.max;
    };
    out << "        float3[] extent";
    if (std::all_of(mExtents.begin(), mExtents.end(), same)) {
      out << " = ";
      writeBox(out, mExtents.begin()->second);
    } else {
      out << ".timeSamples = {\n";
      for (const auto& [frame, box] : mExtents) {
        out << "            " << frame << ": ";
        writeBox(out, box);
        out << ",\n";
      }
      out << "        }";
    }
    out << '\n';
  }

  /// One file is a value; of several each is a sample, and none where a frame has no such grid, so that a reader never
  /// holds one in the place of others.
  void writeField(std::ostream& out, const Field& field) const {
    out << "\n        def OpenVDBAsset \"" << field.prim << "\"\n        {\n            token fieldClass = \""
        << field.gridClass << "\"\n            token fieldDataType = \"" << field.type
        << "\"\n            int fieldIndex = " << field.index
        << "\n            token fieldName = " << quoted(field.name) << "\n            asset filePath";
    if (mFrames.size() == 1) {
      out << " = " << field.files.begin()->second << '\n';
    } else {
      out << ".timeSamples = {\n";
      for (const int frame : mFrames) {
        const auto file = field.files.find(frame);
        out << "                " << frame << ": " << (file == field.files.end() ? "None" : file->second) << ",\n";
      }
      out << "            }\n";
    }
    out << "            token vectorDataRoleHint = \"" << field.role << "\"\n        }\n";
  }

  std::filesystem::path mFolder;
  std::vector<Field> mFields;
  std::set<std::string> mPrims;
  std::map<int, Box> mExtents;
  std::set<int> mFrames;
};

} // namespace

void writeUsd(const std::filesystem::path& path, std::span<const UsdFrame> frames, const UsdWriteOptions& options,
              const RunContext& ctx) {
  const std::string place = path.string();
  if (path.extension() != ".usda") throw Error(ErrorKind::Usage, place + ": is a stage in text; name it by .usda");
  if (frames.empty()) throw Error(ErrorKind::Usage, place + ": needs a volume; give one");
  Stage stage(path);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ctx.progress("stage", static_cast<double>(i) / static_cast<double>(frames.size()));
    stage.add(frames[i], ctx);
  }
  AtomicFile file(path);
  std::ofstream out(file.path(), std::ios::binary);
  out << stage.text(options);
  out.close();
  if (!out)
    throw Error(ErrorKind::File, place + ": cannot be written: " + std::strerror(errno) + "; check the disk's space");
  file.commit();
}

} // namespace volcaustic
