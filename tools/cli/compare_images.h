// compare: images by channel, and as they look.
#pragma once

#include "common.h"

#include <volcaustic/image.h>

#include <optional>
#include <string>
#include <vector>

namespace volcaustic::cli {

struct ImageComparison {
  FlipOptions flip;
  std::string map; ///< file for the map of differences; empty for none
  /// Greatest mean FLIP that still counts as equal.
  std::optional<double> threshold;
};

/// Differences by channel. What FLIP says is printed, goes into the report as "flip" and to the map's file; pictures
/// without colours have none, which is an error where somebody asks for it.
std::vector<Difference> comparePictures(Job& job, const std::string& a, const std::string& b,
                                        const ImageComparison& options, std::optional<FlipDifference>& flip);

} // namespace volcaustic::cli
