// info: shapes.
#include "info_report.h"
#include "text_table.h"

#include <volcaustic/mesh.h>
#include <volcaustic/polygonise.h>
#include <volcaustic/shape_fields.h>
#include <volcaustic/shape_file.h>

#include <fmt/format.h>
#include <map>
#include <optional>

namespace volcaustic::cli {

namespace {

constexpr int kCells = 64; // along its longest side, for its volume and area

/// How many nodes there are of each type, copies by reference counted as often as they occur.
void countTypes(const Shape& shape, std::map<std::size_t, std::uint64_t>& counts) {
  const ShapeNode& node = shape.node();
  ++counts[node.kind.index()];
  for (const Shape& part : node.parts) countTypes(part, counts);
  for (const Deviation& d : node.deviations) countTypes(d.region, counts);
}

struct Extent {
  Box bounds;
  double volume = 0, area = 0;
};

/// Of what has an end and an inside; else it says why not.
std::optional<Extent> extentOf(const Shape& shape, const ShapeField& field, Job& job, std::string& reason) {
  try {
    Extent extent{field.bounds()};
    const MeshReport mesh = checkMesh(polygonise(shape, {.resolution = kCells}, job.context()), job.context());
    extent.volume = mesh.signedVolume;
    extent.area = mesh.area;
    return extent;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::Input) throw;
    reason = error.what();
    return std::nullopt;
  }
}

std::string vec(const Vec3d& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]); }

} // namespace

Json shapeInfo(const std::string& path, Job& job) {
  const Shape shape = readShape(path);
  const ShapeField field(shape);
  std::map<std::size_t, std::uint64_t> counts;
  countTypes(shape, counts);
  std::string reason;
  const std::optional<Extent> extent = extentOf(shape, field, job, reason);

  Json types = Json::object();
  std::string text;
  for (const auto& [type, count] : counts) {
    types[kShapeTypes[type]] = count;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, kShapeTypes[type]);
  }
  const std::string hash = fmt::format("{:016x}", shapeHash(shape));
  Json entry{{"kind", "shape"}, {"shapeHash", hash}, {"types", types}, {"parts", field.partNames()}};
  entry["bounds"] = extent ? Json{{"min", extent->bounds.min}, {"max", extent->bounds.max}} : Json();
  entry["volume"] = extent ? Json(extent->volume) : Json();
  entry["area"] = extent ? Json(extent->area) : Json();
  entry["shape"] = Json::parse(shapeToJson(shape))["shape"];
  if (job.json()) return entry;

  fmt::print("{}: shape {}\n", path, hash);
  fmt::print("{}", wrapped("  nodes     ", text));
  std::string parts;
  for (const std::string& name : field.partNames()) parts += (parts.empty() ? "" : ", ") + (name.empty() ? "-" : name);
  fmt::print("{}", wrapped("  parts     ", plain(parts, 400)));
  if (extent) {
    fmt::print("  box       {} to {} world units\n", vec(extent->bounds.min), vec(extent->bounds.max));
    fmt::print("  volume    {:.5g} world^3; area {:.5g} world^2 (of triangles, {} cells along its longest side)\n",
               extent->volume, extent->area, kCells);
  } else {
    fmt::print("{}", wrapped("  box       ", plain(reason, 200)));
  }
  return entry;
}

} // namespace volcaustic::cli
