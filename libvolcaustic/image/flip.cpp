// The FLIP difference: how strongly two pictures differ to someone who flips between them.
//
// P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild, FLIP: A Difference Evaluator
// for Alternating Images, Proc. ACM Computer Graphics and Interactive Techniques 3(2), 2020 ("2020" below);
// P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moller, Visualizing Errors in Rendered High Dynamic Range Images,
// Eurographics Short Papers, 2021 ("2021").
#include "core/parallel.h"
#include "image/colour.h"
#include "image/plane_filter.h"
#include "volcaustic/error.h"
#include "volcaustic/image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

constexpr std::int64_t kPixelsAtOnce = 1 << 14;
constexpr int kMostExposures = 64;

/// Calls body(i) for each pixel.
template <class Body>
void forEachPixel(std::size_t count, const RunContext& ctx, const Body& body) {
  parallelFor(static_cast<std::int64_t>(count), kPixelsAtOnce, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) body(static_cast<std::size_t>(i));
  });
}

// --- What the eye keeps of a picture -------------------------------------------------------------------------------

/// Weights f(0), f(1), ... of a function of the distance in pixels.
template <class Function>
FilterWeights sampled(int reach, const Function& f) {
  FilterWeights weights;
  for (int x = -reach; x <= reach; ++x) weights.push_back(static_cast<float>(f(static_cast<double>(x))));
  return weights;
}

/// Divides positive weights by their sum and negative ones by theirs (2020, section 4.2.1): an edge or a point of the
/// full contrast then answers with 1 however many pixels a degree has.
void normaliseSigns(FilterWeights& weights) {
  float above = 0, below = 0;
  for (const float w : weights) (w > 0 ? above : below) += std::abs(w);
  for (float& w : weights) w /= w > 0 ? above : below > 0 ? below : 1;
}

/// One or two Gaussians for each opponent channel: the contrast sensitivities of 2020, section 4.1.1 and table 1, in
/// the pixels' own space; and the derivatives of a Gaussian that find edges and points, section 4.2.1.
struct Eye {
  explicit Eye(double pixelsPerDegree) {
    const double pi = std::numbers::pi;
    const auto reach = static_cast<int>(std::ceil(3 * std::sqrt(kBlue / (2 * pi * pi)) * pixelsPerDegree));
    const auto gaussian = [&](double b) {
      return sampled(reach, [&](double x) { return std::exp(-std::pow(pi * x / pixelsPerDegree, 2) / b); });
    };
    achromatic = gaussian(0.0047);
    redGreen = gaussian(0.0053);
    blueYellow[0] = gaussian(kBlue);
    blueYellow[1] = gaussian(0.025);
    const auto volume = [&](double a, double b, const FilterWeights& w) {
      return a * std::sqrt(pi / b) * std::pow(sumOf(w), 2);
    };
    const double wide = volume(34.1, kBlue, blueYellow[0]), narrow = volume(13.5, 0.025, blueYellow[1]);
    widePart = static_cast<float>(wide / (wide + narrow));
    for (FilterWeights* weights : {&achromatic, &redGreen, &blueYellow[0], &blueYellow[1]}) normaliseSigns(*weights);

    const double deviation = 0.5 * 0.082 * pixelsPerDegree;
    const auto bell = [&](double x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    const auto featureReach = static_cast<int>(std::ceil(3 * deviation));
    across = sampled(featureReach, bell);
    slope = sampled(featureReach, [&](double x) { return -x * bell(x); });
    bend = sampled(featureReach, [&](double x) { return (x * x / (deviation * deviation) - 1) * bell(x); });
    for (FilterWeights* weights : {&across, &slope, &bend}) normaliseSigns(*weights);
  }

  static constexpr double kBlue = 0.04; ///< b of the widest Gaussian
  static double sumOf(const FilterWeights& weights) {
    double sum = 0;
    for (const float w : weights) sum += w;
    return sum;
  }

  FilterWeights achromatic, redGreen, blueYellow[2];
  float widePart; ///< of the first blue-yellow Gaussian
  FilterWeights across, slope, bend;
};

/// A picture as it is compared: filtered and perceptually uniform colours, and its features.
struct Percept {
  Plane lab[3]; ///< Hunt-adjusted
  Plane edges, points;
};

/// L*a*b* with chroma in proportion to lightness: colours fade in the dark (Hunt; 2020, equation 5).
Colour huntAdjusted(const Colour& lab) { return {lab[0], 0.01F * lab[0] * lab[1], 0.01F * lab[0] * lab[2]}; }

/// Length of the gradient, or of the second derivatives, of a plane.
Plane strength(const Plane& plane, PlaneSize size, const FilterWeights& derivative, const FilterWeights& across,
               const RunContext& ctx) {
  Plane x = filtered(plane, size, derivative, across, ctx);
  const Plane y = filtered(plane, size, across, derivative, ctx);
  forEachPixel(x.size(), ctx, [&](std::size_t i) { x[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]); });
  return x;
}

/// Of display values 0..1, linear.
Percept perceive(const Plane (&rgb)[3], PlaneSize size, const Eye& eye, const RunContext& ctx) {
  const std::size_t count = rgb[0].size();
  Plane opponent[3] = {Plane(count), Plane(count), Plane(count)};
  forEachPixel(count, ctx, [&](std::size_t i) {
    const Colour o = opponentFromXyz(kRelativeXyzFromRgb * Colour{rgb[0][i], rgb[1][i], rgb[2][i]});
    for (int c = 0; c < 3; ++c) opponent[c][i] = o[c];
  });
  Percept percept;
  percept.lab[0] = filtered(opponent[0], size, eye.achromatic, eye.achromatic, ctx);
  percept.lab[1] = filtered(opponent[1], size, eye.redGreen, eye.redGreen, ctx);
  percept.lab[2] = filtered(opponent[2], size, eye.blueYellow[0], eye.blueYellow[0], ctx);
  const Plane narrow = filtered(opponent[2], size, eye.blueYellow[1], eye.blueYellow[1], ctx);
  forEachPixel(count, ctx, [&](std::size_t i) {
    const float blueYellow = eye.widePart * percept.lab[2][i] + (1 - eye.widePart) * narrow[i];
    Colour seen = kRgbFromRelativeXyz * xyzFromOpponent({percept.lab[0][i], percept.lab[1][i], blueYellow});
    for (float& v : seen) v = std::clamp(v, 0.0F, 1.0F);
    const Colour lab = huntAdjusted(labFromXyz(kRelativeXyzFromRgb * seen));
    for (int c = 0; c < 3; ++c) percept.lab[c][i] = lab[c];
    opponent[0][i] = (opponent[0][i] + 16) * (1 / 116.0F); // features are looked for in Y, 0..1, before the filter
  });
  percept.edges = strength(opponent[0], size, eye.slope, eye.across, ctx);
  percept.points = strength(opponent[0], size, eye.bend, eye.across, ctx);
  return percept;
}

// --- How two of them differ ----------------------------------------------------------------------------------------

/// Differences of lightness and of chroma, added (HyAB; 2020, equation 6).
float hyab(const Colour& a, const Colour& b) { return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]); }

/// Compresses the large differences: those up to 0.4 of the largest possible fill 0..0.95 (2020, section 4.1.4).
class ColourScale {
public:
  float operator()(float difference) const {
    const float e = std::pow(difference, kPower), knee = kKnee * mLargest;
    return e < knee ? kAtKnee / knee * e : kAtKnee + (e - knee) / (mLargest - knee) * (1 - kAtKnee);
  }

private:
  static constexpr float kPower = 0.7F, kKnee = 0.4F, kAtKnee = 0.95F;
  /// Between the primaries green and blue.
  static float largest() {
    const auto seen = [](const Colour& rgb) { return huntAdjusted(labFromXyz(kRelativeXyzFromRgb * rgb)); };
    return std::pow(hyab(seen({0, 1, 0}), seen({0, 0, 1})), kPower);
  }
  float mLargest = largest();
};

/// Raises `map` to the difference of two pictures where that is larger (2020, equations 8 and 9; 2021, equation 3).
void raise(Plane& map, const Percept& a, const Percept& b, const RunContext& ctx) {
  const ColourScale scale;
  forEachPixel(map.size(), ctx, [&](std::size_t i) {
    const float colour = scale(hyab({a.lab[0][i], a.lab[1][i], a.lab[2][i]}, {b.lab[0][i], b.lab[1][i], b.lab[2][i]}));
    const float feature = std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
    const float features = std::sqrt(feature / std::numbers::sqrt2_v<float>);
    map[i] = std::max(map[i], std::pow(colour, 1 - features));
  });
}

// --- Exposures -----------------------------------------------------------------------------------------------------

/// The tone curve of 2021: K. Narkowicz, ACES filmic tone mapping curve (2015), of 0.6 times the light.
float toned(float v) {
  v = 0.6F * std::clamp(v, 0.0F, 1e6F);
  return std::min(v * (2.51F * v + 0.03F) / (v * (2.43F * v + 0.59F) + 0.14F), 1.0F);
}

/// The light that the tone curve takes to 0.85.
double nearlyWhite() {
  const double t = 0.85, a = 0.36 * (2.51 - t * 2.43), b = 0.6 * (0.03 - t * 0.59), c = -t * 0.14;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

/// Puts the middle one of some numbers in its place and returns where.
std::vector<float>::iterator toMedian(std::vector<float>& numbers) {
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return middle;
}

/// Stops at which a picture is looked at: from where its brightest pixel is nearly white to where its median is (2021,
/// section 3.1). Where most of it is black, which no exposure makes white, the median is that of all the rest.
std::vector<double> exposures(const Plane (&rgb)[3]) {
  std::vector<float> luminance(rgb[0].size());
  for (std::size_t i = 0; i < luminance.size(); ++i)
    luminance[i] = (kRelativeXyzFromRgb * Colour{rgb[0][i], rgb[1][i], rgb[2][i]})[1];
  const auto lit = [](float y) { return y > 0 && std::isfinite(y); };
  auto median = toMedian(luminance);
  if (!lit(*median)) {
    std::erase_if(luminance, [&](float y) { return !lit(y); });
    if (luminance.empty()) return {0};
    median = toMedian(luminance);
  }
  const double stop = std::log2(nearlyWhite() / *median);
  const double start = std::log2(nearlyWhite() / *std::max_element(median, luminance.end()));
  if (!(stop > start)) return {stop};
  const int count = std::clamp(static_cast<int>(std::ceil(stop - start)), 2, kMostExposures);
  std::vector<double> stops;
  for (int i = 0; i < count; ++i) stops.push_back(start + (stop - start) * i / (count - 1));
  return stops;
}

// --- Pictures ------------------------------------------------------------------------------------------------------

/// Red, green and blue, or one plane of grey thrice. Values that are not finite become 0.
struct Finite {
  Plane rgb[3];

  Finite(const Image& image, const char* which) {
    for (int c = 0; c < 3; ++c) {
      const int plane = image.channels.size() == 1 ? 0 : image.find(std::string(1, "RGB"[c]));
      if (plane < 0)
        throw Error(ErrorKind::Input, std::string("flip: the ") + which +
                                          " image has no channels R, G and B, nor a single one; choose a layer of it");
      rgb[c] = image.planes[static_cast<std::size_t>(plane)];
      for (float& v : rgb[c])
        if (!std::isfinite(v)) v = 0;
    }
  }
};

/// Where one picture is not finite and the other is something else, they differ wholly.
void raiseWhereNotFinite(Plane& map, const Image& a, const Image& b) {
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const int other = b.find(a.channels[c]);
    if (other < 0) continue;
    const Plane &p = a.planes[c], &q = b.planes[static_cast<std::size_t>(other)];
    const bool colour = a.channels.size() == 1 || a.channels[c] == "R" || a.channels[c] == "G" || a.channels[c] == "B";
    for (std::size_t i = 0; colour && i < map.size(); ++i) {
      const bool finite = std::isfinite(p[i]) && std::isfinite(q[i]);
      if (!finite && p[i] != q[i] && !(std::isnan(p[i]) && std::isnan(q[i]))) map[i] = 1;
    }
  }
}

void requireComparable(const Image& a, const Image& b, const FlipOptions& options, const RunContext& ctx) {
  if (a.width != b.width || a.height != b.height || a.width < 1 || a.height < 1)
    throw Error(ErrorKind::Input, "flip: the images have different sizes; scale one of them");
  if (!(options.pixelsPerDegree >= 1 && options.pixelsPerDegree <= 1000))
    throw Error(ErrorKind::Usage, "flip: pixelsPerDegree must be from 1 to 1000");
  constexpr std::uint64_t kPlanesAtOnce = 32;
  ctx.requireMemory(kPlanesAtOnce * sizeof(float) * static_cast<std::uint64_t>(a.width) *
                        static_cast<std::uint64_t>(a.height),
                    "flip");
}

} // namespace

FlipDifference flipDifference(const Image& reference, const Image& test, const FlipOptions& options,
                              const RunContext& ctx) {
  requireComparable(reference, test, options, ctx);
  const Finite pictures[2] = {{reference, "first"}, {test, "second"}};
  const PlaneSize size{static_cast<std::size_t>(reference.width), static_cast<std::size_t>(reference.height)};
  const Eye eye(options.pixelsPerDegree);

  FlipDifference result;
  result.map.resize(size.width * size.height);
  if (options.highDynamicRange) result.exposures = exposures(pictures[0].rgb);
  const auto percept = [&](const Finite& picture, const auto& displayed) {
    Plane rgb[3] = {picture.rgb[0], picture.rgb[1], picture.rgb[2]};
    forEachPixel(rgb[0].size(), ctx, [&](std::size_t i) {
      for (Plane& plane : rgb) plane[i] = displayed(plane[i]);
    });
    return perceive(rgb, size, eye, ctx);
  };
  const auto raiseAt = [&](const auto& displayed) {
    raise(result.map, percept(pictures[0], displayed), percept(pictures[1], displayed), ctx);
  };
  if (!options.highDynamicRange) raiseAt([](float v) { return std::clamp(v, 0.0F, 1.0F); });
  for (std::size_t i = 0; i < result.exposures.size(); ++i) {
    ctx.progress("flip", static_cast<double>(i) / static_cast<double>(result.exposures.size()));
    const auto gain = static_cast<float>(std::exp2(result.exposures[i]));
    raiseAt([gain](float v) { return toned(v * gain); });
  }
  raiseWhereNotFinite(result.map, reference, test);

  double sum = 0;
  for (const float v : result.map) sum += v;
  result.mean = sum / static_cast<double>(result.map.size());
  result.maximum = *std::max_element(result.map.begin(), result.map.end());
  return result;
}

} // namespace volcaustic
