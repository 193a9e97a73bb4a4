// compare: how far two files of a kind are apart, with a threshold and an exit status.
#include "common.h"
#include "compare_images.h"
#include "file_kind.h"
#include "option_flags.h"

#include <volcaustic/mesh.h>
#include <volcaustic/vdb.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace volcaustic::cli {

namespace {

constexpr int kBeyondThreshold = 1;

struct Compare {
  CommonOptions common;
  std::string a, b;
  std::optional<double> threshold; ///< 0 when there is none of FLIP's either
  std::string metric = "max";
  ImageComparison images;
};

constexpr const char* kImages = "Images";

void declareCompare(CLI::App& command, Compare& o) {
  command.add_option("A", o.a, "volume, image or mesh")->required();
  command.add_option("B", o.b, "another of the same kind")->required();
  command
      .add_option("--threshold", o.threshold,
                  "greatest difference that still counts as equal; default 0, or none with --flip-threshold")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--metric", o.metric, "difference that is held against the threshold: max, rmse or mean; default max")
      ->check(CLI::IsMember({"max", "rmse", "mean"}));
  command
      .add_option("--flip-threshold", o.images.threshold,
                  "greatest mean FLIP, 0 to 1, that still counts as equal: how different the pictures look")
      ->check(CLI::Range(0.0, 1.0))
      ->group(kImages);
  command
      .add_option("--map", o.images.map,
                  "file for the map of FLIP: colours from black (0) to white (1), or numbers in .exr")
      ->group(kImages);
  addFlags(command, o.images.flip, {{"pixelsPerDegree"}, {}});
  command.get_option("--pixels-per-degree")->group(kImages);
  command.footer(
      "Exit status: 0 within the thresholds, 1 beyond one. Images: by channel, and FLIP of the picture, A being the "
      "reference. Volumes: by grid, over the union of "
      "active voxels. Meshes: counts, volume and area, each as a part of the larger of the two.");
}

/// A measure of two meshes as a relative difference.
Difference relative(const char* name, double a, double b) {
  const double scale = std::max(std::abs(a), std::abs(b));
  const double difference = a == b ? 0 : std::abs(a - b) / scale;
  return {name, difference, difference, difference, a, b};
}

std::vector<Difference> compareMeshes(const Compare& o, const RunContext& ctx) {
  const MeshReport a = checkMesh(readMesh(o.a, ctx), ctx), b = checkMesh(readMesh(o.b, ctx), ctx);
  const auto count = [](const char* name, std::uint64_t x, std::uint64_t y) {
    return relative(name, static_cast<double>(x), static_cast<double>(y));
  };
  return {relative("volume", a.signedVolume, b.signedVolume), relative("area", a.area, b.area),
          count("vertices", a.vertices, b.vertices),          count("triangles", a.triangles, b.triangles),
          count("components", a.components, b.components),    count("openEdges", a.openEdges, b.openEdges)};
}

std::vector<Difference> differences(Job& job, const Compare& o, std::optional<FlipDifference>& flip) {
  const RunContext& ctx = job.context();
  const FileKind kind = fileKind(o.a);
  if (fileKind(o.b) != kind) throw Error(ErrorKind::Input, o.b + ": is of another kind than " + o.a);
  if (kind != FileKind::Image && (!o.images.map.empty() || o.images.threshold))
    throw Error(ErrorKind::Usage, o.a + ": is no image; --map and --flip-threshold are for images");
  switch (kind) {
  case FileKind::Volume:
    return compareVdb(o.a, o.b, ctx);
  case FileKind::Image:
    return comparePictures(job, o.a, o.b, o.images, flip);
  case FileKind::Mesh:
    return compareMeshes(o, ctx);
  case FileKind::Scene:
    break;
  }
  throw Error(ErrorKind::Usage, o.a + ": scenes are not compared; `volcaustic info` prints a hash of each");
}

double measured(const Difference& d, const std::string& metric) {
  return metric == "max" ? d.maximum : metric == "rmse" ? d.rootMeanSquare : d.meanAbsolute;
}

Json reportOf(const Difference& d) {
  return {{"name", d.name},       {"meanAbsolute", d.meanAbsolute}, {"rootMeanSquare", d.rootMeanSquare},
          {"maximum", d.maximum}, {"meanOfA", d.meanOfA},           {"meanOfB", d.meanOfB}};
}

void printTable(const std::vector<Difference>& all, const std::optional<FlipDifference>& flip) {
  fmt::print("{:<20} {:>13} {:>13} {:>13} {:>13} {:>13}\n", "", "mean", "RMSE", "maximum", "mean of A", "mean of B");
  for (const Difference& d : all)
    fmt::print("{:<20} {:>13.6g} {:>13.6g} {:>13.6g} {:>13.6g} {:>13.6g}\n", d.name, d.meanAbsolute, d.rootMeanSquare,
               d.maximum, d.meanOfA, d.meanOfB);
  if (flip) fmt::print("{:<20} {:>13.6g} {:>13} {:>13.6g}\n", "FLIP", flip->mean, "", flip->maximum);
}

int runCompare(const Compare& o) {
  Job job("compare", o.common);
  job.addInput(o.a);
  job.addInput(o.b);
  if (!o.images.map.empty()) checkOutput(o.images.map, FileKind::Image);
  std::optional<FlipDifference> flip;
  const std::vector<Difference> all = differences(job, o, flip);
  const bool byValue = o.threshold || !o.images.threshold;
  const double threshold = o.threshold.value_or(0);
  // Written so that a difference that is not a number is not within.
  const auto near = [&](const Difference& d) { return measured(d, o.metric) <= threshold; };
  const bool within = (!byValue || std::all_of(all.begin(), all.end(), near)) &&
                      (!o.images.threshold || flip->mean <= *o.images.threshold);
  Json& list = job.report()["differences"] = Json::array();
  for (const Difference& d : all) list.push_back(reportOf(d));
  if (!job.json()) printTable(all, flip);
  job.report()["within"] = within;
  std::string judged;
  if (byValue) {
    job.report().update({{"metric", o.metric}, {"threshold", threshold}});
    judged = fmt::format("{} of every difference against {:g}", o.metric, threshold);
  }
  if (o.images.threshold) {
    job.report()["flipThreshold"] = *o.images.threshold;
    judged += fmt::format("{}mean FLIP against {:g}", byValue ? ", " : "", *o.images.threshold);
  }
  job.console().say(fmt::format("{}: {}", within ? "within the threshold" : "beyond the threshold", judged));
  job.finish();
  return within ? 0 : kBeyondThreshold;
}

} // namespace

void addCompareCommand(CLI::App& app, Action& action) {
  addCommand<Compare>(app, action, "compare", "how far two volumes, images or meshes are apart", declareCompare,
                      runCompare);
}

} // namespace volcaustic::cli
