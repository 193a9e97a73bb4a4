// info: volumes.
#include "info_report.h"
#include "text_table.h"

#include <volcaustic/vdb.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

Json gridReport(const GridInfo& g) {
  return {{"name", g.name},
          {"type", g.type},
          {"class", g.gridClass},
          {"vectorType", g.vectorType},
          {"activeVoxels", g.activeVoxels},
          {"leafNodes", g.leafNodes},
          {"activeTiles", g.activeTiles},
          {"memoryBytes", g.memoryBytes},
          {"indexMin", g.indexMin},
          {"indexMax", g.indexMax},
          {"world", {{"min", g.world.min}, {"max", g.world.max}}},
          {"voxelSize", g.voxelSize},
          {"mirrored", g.mirrored},
          {"minimum", g.minimum},
          {"maximum", g.maximum},
          {"mean", g.mean},
          {"metadata", g.metadata}};
}

/// "Tree_vec3s_5_4_3", the usual tree, as "vec3s".
std::string valueType(const GridInfo& g) {
  constexpr std::string_view kBefore = "Tree_", kAfter = "_5_4_3";
  if (!g.type.starts_with(kBefore) || !g.type.ends_with(kAfter)) return plain(g.type);
  return g.type.substr(kBefore.size(), g.type.size() - kBefore.size() - kAfter.size());
}

/// Points and masks have voxels without values.
bool hasValues(const GridInfo& g) {
  const std::string type = valueType(g);
  return g.activeVoxels > 0 && !type.starts_with("ptdata") && type != "mask" && type != "string";
}

std::int64_t dim(const GridInfo& g, int axis) { return std::int64_t{g.indexMax[axis]} - g.indexMin[axis] + 1; }

/// One number for cubes, three for others.
std::string voxelText(const Vec3d& h) {
  const auto same = [&](int a) { return std::abs(h[a] - h[0]) <= 1e-6 * std::abs(h[0]); };
  return same(1) && same(2) ? fmt::format("{:.6g}", h[0]) : fmt::format("{:.6g} x {:.6g} x {:.6g}", h[0], h[1], h[2]);
}

/// Whether the voxels' axes are the world's: then the box in the world is as long as its voxels.
bool isAligned(const GridInfo& g) {
  for (int a = 0; a < 3; ++a) {
    const double side = g.voxelSize[a] * static_cast<double>(dim(g, a));
    if (std::abs(g.world.max[a] - g.world.min[a] - side) > 1e-4 * side) return false;
  }
  return true;
}

std::string axesText(const GridInfo& g) {
  return std::string(isAligned(g) ? "aligned" : "turned") + (g.mirrored ? ", mirrored" : "");
}

std::string corner(const Vec3d& v) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", v[0], v[1], v[2]); }

void printValues(const std::vector<GridInfo>& grids) {
  using enum TextTable::Align;
  TextTable table({{"grid", Left},
                   {"type", Left},
                   {"class", Left},
                   {"active voxels"},
                   {"MiB"},
                   {"minimum"},
                   {"maximum"},
                   {"mean"}});
  for (const GridInfo& g : grids) {
    const auto value = [&](double v) { return hasValues(g) ? fmt::format("{:.6g}", v) : "-"; };
    table.add({plain(g.name), valueType(g), plain(g.gridClass), fmt::format("{}", g.activeVoxels),
               fmt::format("{:.2f}", static_cast<double>(g.memoryBytes) / (1 << 20)), value(g.minimum),
               value(g.maximum), value(g.mean)});
  }
  fmt::print("{}", table.text("  "));
}

void printPlaces(const std::vector<GridInfo>& grids) {
  using enum TextTable::Align;
  TextTable table({{"grid", Left}, {"voxel [world]"}, {"axes", Left}, {"dims"}, {"world box", Left}});
  for (const GridInfo& g : grids) {
    const bool empty = g.activeVoxels == 0;
    table.add({plain(g.name), voxelText(g.voxelSize), empty ? "-" : axesText(g),
               empty ? "-" : fmt::format("{} x {} x {}", dim(g, 0), dim(g, 1), dim(g, 2)),
               empty ? "no active voxel" : corner(g.world.min) + " to " + corner(g.world.max)});
  }
  fmt::print("{}", table.text("  "));
}

void printMetadata(const std::string& title, const std::map<std::string, std::string>& metadata) {
  for (const auto& [key, value] : metadata) fmt::print("  {}{}: {}\n", title, plain(key), plain(value, 80));
}

void printVolume(const std::string& path, const VdbInfo& info, bool verbose) {
  std::uint64_t bytes = 0;
  for (const GridInfo& g : info.grids) bytes += g.memoryBytes;
  fmt::print("{}: volume, {} grid{}, {:.2f} MiB in memory\n", path, info.grids.size(),
             info.grids.size() == 1 ? "" : "s", static_cast<double>(bytes) / (1 << 20));
  printMetadata("", info.metadata);
  if (info.grids.empty()) return;
  printValues(info.grids);
  printPlaces(info.grids);
  if (verbose)
    for (const GridInfo& g : info.grids) printMetadata(plain(g.name) + " ", g.metadata);
}

} // namespace

Json volumeInfo(const std::string& path, Job& job) {
  const VdbInfo info = inspectVdb(path, job.context());
  if (!job.json()) printVolume(path, info, job.console().isVerbose());
  Json grids = Json::array();
  for (const GridInfo& grid : info.grids) grids.push_back(gridReport(grid));
  return {{"kind", "volume"}, {"grids", std::move(grids)}, {"metadata", info.metadata}};
}

} // namespace volcaustic::cli
