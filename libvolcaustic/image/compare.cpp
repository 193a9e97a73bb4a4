#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volcaustic {

namespace {

std::string size(const Image& image) { return std::to_string(image.width) + " x " + std::to_string(image.height); }

/// Equal values, infinities and NaNs included, differ by nothing; a value that is not finite on one side only by
/// infinity.
double differenceOf(float a, float b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  const double difference = std::abs(double(a) - double(b));
  return std::isfinite(difference) ? difference : std::numeric_limits<double>::infinity();
}

} // namespace

std::vector<Difference> compareImages(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error(ErrorKind::Input, "compare: the images have different sizes, " + size(a) + " and " + size(b));
  for (const std::string& name : b.channels)
    if (a.find(name) < 0) throw Error(ErrorKind::Input, "compare: the first image has no channel '" + name + "'");

  std::vector<Difference> differences;
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const int other = b.find(a.channels[c]);
    if (other < 0) throw Error(ErrorKind::Input, "compare: the second image has no channel '" + a.channels[c] + "'");
    const std::vector<float>&p = a.planes[c], &q = b.planes[other];
    Difference d{.name = a.channels[c]};
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double difference = differenceOf(p[i], q[i]);
      d.meanAbsolute += difference;
      d.rootMeanSquare += difference * difference;
      d.maximum = std::max(d.maximum, difference);
      d.meanOfA += p[i];
      d.meanOfB += q[i];
    }
    const auto count = static_cast<double>(std::max<std::size_t>(p.size(), 1));
    d.meanAbsolute /= count;
    d.rootMeanSquare = std::sqrt(d.rootMeanSquare / count);
    d.meanOfA /= count;
    d.meanOfB /= count;
    differences.push_back(std::move(d));
  }
  return differences;
}

} // namespace volcaustic
