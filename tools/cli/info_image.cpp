// info: images.
#include "info_report.h"
#include "text_table.h"

#include <volcaustic/image.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

/// Least, greatest and mean finite value, and how many are not finite.
Json planeReport(const std::vector<float>& plane) {
  double least = INFINITY, greatest = -INFINITY, sum = 0;
  std::uint64_t finite = 0;
  for (const float value : plane) {
    if (!std::isfinite(value)) continue;
    least = std::min<double>(least, value);
    greatest = std::max<double>(greatest, value);
    sum += value;
    ++finite;
  }
  if (finite == 0) return {{"minimum", nullptr}, {"maximum", nullptr}, {"mean", nullptr}, {"notFinite", plane.size()}};
  return {{"minimum", least},
          {"maximum", greatest},
          {"mean", sum / static_cast<double>(finite)},
          {"notFinite", plane.size() - finite}};
}

void printImage(const std::string& path, const Image& image, const Json& channels) {
  fmt::print("{}: image, {} x {} pixels, {} channel{}\n", path, image.width, image.height, image.channels.size(),
             image.channels.size() == 1 ? "" : "s");
  for (const auto& [key, value] : image.metadata) fmt::print("  {}: {}\n", plain(key), plain(value, 80));
  TextTable table({{"channel", TextTable::Align::Left}, {"minimum"}, {"maximum"}, {"mean"}, {"not finite"}});
  const auto number = [](const Json& v) {
    return v.is_null() ? std::string("-") : fmt::format("{:.6g}", v.get<double>());
  };
  for (const Json& c : channels)
    table.add({plain(c["name"].get<std::string>()), number(c["minimum"]), number(c["maximum"]), number(c["mean"]),
               fmt::format("{}", c["notFinite"].get<std::uint64_t>())});
  fmt::print("{}", table.text("  "));
}

} // namespace

Json imageInfo(const std::string& path, Job& job) {
  const Image image = readImage(path, job.context());
  Json channels = Json::array();
  for (std::size_t i = 0; i < image.channels.size(); ++i) {
    Json channel{{"name", image.channels[i]}};
    channel.update(planeReport(image.planes[i]));
    channels.push_back(std::move(channel));
  }
  if (!job.json()) printImage(path, image, channels);
  return {{"kind", "image"},
          {"width", image.width},
          {"height", image.height},
          {"channels", std::move(channels)},
          {"metadata", image.metadata}};
}

} // namespace volcaustic::cli
