#include "compare_images.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

bool isPicture(const Image& image) {
  const auto has = [&](const char* channel) { return image.find(channel) >= 0; };
  return image.channels.size() == 1 || (has("R") && has("G") && has("B"));
}

/// Files of display values say so.
bool isDisplayed(const Image& image) {
  const auto space = image.metadata.find("colorInteropID");
  return space != image.metadata.end() && space->second == kDisplayColours;
}

/// Numbers in .exr, colours in everything else.
void writeMap(Job& job, const std::string& path, const Image& like, const FlipDifference& flip) {
  Image map;
  if (std::filesystem::path(path).extension() == ".exr") {
    map.width = like.width;
    map.height = like.height;
    map.add("Y") = flip.map;
  } else {
    map = differencePicture(like.width, like.height, flip.map);
  }
  ImageWriteOptions write;
  write.half = false;
  writeImage(path, map, write, job.context());
  job.addOutput(path);
}

Json flipReport(const FlipDifference& flip, const FlipOptions& options) {
  Json report = {{"mean", flip.mean}, {"maximum", flip.maximum}, {"pixelsPerDegree", options.pixelsPerDegree}};
  report["exposures"] = flip.exposures;
  return report;
}

} // namespace

std::vector<Difference> comparePictures(Job& job, const std::string& a, const std::string& b,
                                        const ImageComparison& options, std::optional<FlipDifference>& flip) {
  const Image first = readImage(a, job.context()), second = readImage(b, job.context());
  std::vector<Difference> differences = compareImages(first, second);
  const bool wanted = !options.map.empty() || options.threshold.has_value();
  if (!wanted && !isPicture(first)) return differences;
  FlipOptions how = options.flip;
  how.highDynamicRange = !(isDisplayed(first) && isDisplayed(second));
  flip = job.timed("flip", [&] { return flipDifference(first, second, how, job.context()); });
  job.report()["flip"] = flipReport(*flip, how);
  if (!options.map.empty()) writeMap(job, options.map, first, *flip);
  return differences;
}

} // namespace volcaustic::cli
