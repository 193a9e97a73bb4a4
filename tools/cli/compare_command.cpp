// compare: how far two files of a kind are apart, with a threshold and an exit status.
#include "common.h"
#include "file_kind.h"

#include <volcaustic/image.h>
#include <volcaustic/mesh.h>
#include <volcaustic/vdb.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

constexpr int kBeyondThreshold = 1;

struct Compare {
  CommonOptions common;
  std::string a, b;
  double threshold = 0;
  std::string metric = "max";
};

void declareCompare(CLI::App& command, Compare& o) {
  command.add_option("A", o.a, "volume, image or mesh")->required();
  command.add_option("B", o.b, "another of the same kind")->required();
  command.add_option("--threshold", o.threshold, "greatest difference that still counts as equal; default 0")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--metric", o.metric, "difference that is held against the threshold: max, rmse or mean; default max")
      ->check(CLI::IsMember({"max", "rmse", "mean"}));
  command.footer(
      "Exit status: 0 within the threshold, 1 beyond it. Images: by channel. Volumes: by grid, over the union of "
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

std::vector<Difference> differences(const Compare& o, const RunContext& ctx) {
  const FileKind kind = fileKind(o.a);
  if (fileKind(o.b) != kind) throw Error(ErrorKind::Input, o.b + ": is of another kind than " + o.a);
  switch (kind) {
  case FileKind::Volume:
    return compareVdb(o.a, o.b, ctx);
  case FileKind::Image:
    return compareImages(readImage(o.a, ctx), readImage(o.b, ctx));
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

int runCompare(const Compare& o) {
  Job job("compare", o.common);
  job.addInput(o.a);
  job.addInput(o.b);
  const std::vector<Difference> all = differences(o, job.context());
  // Written so that a difference that is not a number is not within.
  const bool within =
      std::all_of(all.begin(), all.end(), [&](const Difference& d) { return measured(d, o.metric) <= o.threshold; });
  Json& list = job.report()["differences"] = Json::array();
  if (!job.json())
    fmt::print("{:<20} {:>13} {:>13} {:>13} {:>13} {:>13}\n", "", "mean", "RMSE", "maximum", "mean of A", "mean of B");
  for (const Difference& d : all) {
    list.push_back({{"name", d.name},
                    {"meanAbsolute", d.meanAbsolute},
                    {"rootMeanSquare", d.rootMeanSquare},
                    {"maximum", d.maximum},
                    {"meanOfA", d.meanOfA},
                    {"meanOfB", d.meanOfB}});
    if (!job.json())
      fmt::print("{:<20} {:>13.6g} {:>13.6g} {:>13.6g} {:>13.6g} {:>13.6g}\n", d.name, d.meanAbsolute, d.rootMeanSquare,
                 d.maximum, d.meanOfA, d.meanOfB);
  }
  job.report().update({{"metric", o.metric}, {"threshold", o.threshold}, {"within", within}});
  job.console().say(fmt::format("{}: {} of every difference against {:g}",
                                within ? "within the threshold" : "beyond the threshold", o.metric, o.threshold));
  job.finish();
  return within ? 0 : kBeyondThreshold;
}

} // namespace

void addCompareCommand(CLI::App& app, Action& action) {
  addCommand<Compare>(app, action, "compare", "how far two volumes, images or meshes are apart", declareCompare,
                      runCompare);
}

} // namespace volcaustic::cli
