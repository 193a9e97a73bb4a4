#include "transport/picture.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volcaustic {

namespace {

constexpr int kFewestSamples = 4;     ///< a pixel, before its tile's noise is judged
constexpr double kDarkest = 1.0 / 64; ///< of the picture's mean luminance; what is darker is judged as if it were not

Image emptyImage(const Camera& camera, const RunContext& ctx) {
  Image image;
  image.width = camera.resolution[0];
  image.height = camera.resolution[1];
  image.channels = pictureChannels();
  image.planes.resize(image.channels.size());
  parallelFor(static_cast<std::int64_t>(image.planes.size()), 1, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      image.planes[i].resize(static_cast<std::size_t>(image.width) * image.height);
  });
  return image;
}

std::int32_t tilesAlong(std::int32_t pixels) { return (pixels + kViewTile - 1) / kViewTile; }

} // namespace

std::vector<std::string> pictureChannels(std::span<const std::string> lights) {
  std::vector<std::string> channels{"R", "G", "B", "A"};
  const auto addColours = [&](const std::string& layer) {
    for (const char* colour : {".R", ".G", ".B"}) channels.push_back(layer + colour);
  };
  for (const char* layer : {"caustic", "direct", "background", "receiver", "transmittance"}) addColours(layer);
  channels.insert(channels.end(), {"depth.Z", "steps.Y"});
  for (const std::string& light : lights) {
    addColours(light);
    for (const char* part : kLightParts) addColours(light + "." + part);
  }
  return channels;
}

Picture::Picture(const Camera& camera, const ViewOptions& options, double voxelSize, const RunContext& ctx)
    : mOptions(options)
    , mCtx(ctx)
    , mColumns(tilesAlong(camera.resolution[0]))
    , mRows(tilesAlong(camera.resolution[1])) {
  const bool adapts = options.noise > 0 && options.samples > 1;
  const std::uint64_t pixels = std::uint64_t(camera.resolution[0]) * camera.resolution[1];
  ctx.requireMemory((kernels::kPixelPlanes + (adapts ? 1 : 0)) * pixels * sizeof(float), "camera.resolution");
  mResult.image = emptyImage(camera, ctx);
  for (int i = 0; i < kernels::kPixelPlanes; ++i) mPlanes.of[i] = mResult.image.planes[i].data();
  mPlanes.voxelSize = static_cast<float>(voxelSize);
  if (!adapts) return;
  mSpread.resize(pixels);
  mPlanes.spread = mSpread.data();
}

ViewResult Picture::render(ViewTracer& tracer, const ViewObserver& observer) {
  std::vector<std::int32_t> tiles(static_cast<std::size_t>(mColumns) * mRows);
  std::iota(tiles.begin(), tiles.end(), 0);
  const int all = mOptions.samples * mOptions.samples;
  for (int done = 0; done < all && !tiles.empty();) {
    const int end = std::min(all, std::max(2 * done, 1));
    const ViewCounts counts = tracer.add({done, end, tiles});
    mResult.steps += counts.steps;
    mResult.raysNotFinite += counts.notFinite;
    mResult.raysAtStepLimit += counts.stepLimit;
    mResult.samples += pixelsOf(tiles) * (end - done);
    ++mResult.passes;
    done = end;
    if (observer) observer(mResult);
    if (mPlanes.spread && done >= kFewestSamples && done < all) tiles = unfinished(tiles, done);
  }
  return std::move(mResult);
}

kernels::Int3 Picture::cornerOf(std::int32_t tile) const {
  return {tile % mColumns * kViewTile, tile / mColumns * kViewTile, 0};
}

template <class Visit>
void Picture::forEachPixel(std::int32_t tile, const Visit& visit) const {
  const kernels::Int3 corner = cornerOf(tile);
  const std::int64_t width = mResult.image.width;
  for (int r = corner.y; r < std::min(corner.y + kViewTile, mResult.image.height); ++r)
    for (int c = corner.x; c < std::min<int>(corner.x + kViewTile, mResult.image.width); ++c) visit(r * width + c);
}

std::int64_t Picture::pixelsOf(const std::vector<std::int32_t>& tiles) const {
  std::int64_t pixels = 0;
  for (const std::int32_t tile : tiles) {
    const kernels::Int3 corner = cornerOf(tile);
    pixels += std::int64_t{std::min(kViewTile, mResult.image.width - corner.x)} *
              std::min(kViewTile, mResult.image.height - corner.y);
  }
  return pixels;
}

std::vector<std::int32_t> Picture::unfinished(const std::vector<std::int32_t>& tiles, int samples) const {
  double sum = 0;
  for (std::size_t i = 0; i < mResult.image.planes[0].size(); ++i)
    sum += kernels::luminance(kernels::Float3(mPlanes.of[0][i], mPlanes.of[1][i], mPlanes.of[2][i]));
  const double floor = kDarkest * sum / static_cast<double>(mResult.image.planes[0].size());

  std::vector<std::uint8_t> noisy(static_cast<std::size_t>(mColumns) * mRows);
  parallelFor(static_cast<std::int64_t>(tiles.size()), 16, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) noisy[tiles[i]] = isNoisy(tiles[i], samples, floor);
  });
  std::vector<std::int32_t> left;
  for (const std::int32_t tile : tiles) {
    bool any = false;
    for (int y = std::max(tile / mColumns - 1, 0); y <= std::min(tile / mColumns + 1, mRows - 1); ++y)
      for (int x = std::max(tile % mColumns - 1, 0); x <= std::min(tile % mColumns + 1, mColumns - 1); ++x)
        any |= noisy[y * mColumns + x] != 0;
    if (any) left.push_back(tile);
  }
  return left;
}

bool Picture::isNoisy(std::int32_t tile, int samples, double floor) const {
  double variance = 0, mean = 0;
  std::int64_t pixels = 0;
  forEachPixel(tile, [&](std::int64_t i) {
    variance += mSpread[i];
    mean += kernels::luminance(kernels::Float3(mPlanes.of[0][i], mPlanes.of[1][i], mPlanes.of[2][i]));
    ++pixels;
  });
  // Of the pixels' means, which are of so many samples each.
  const double error = std::sqrt(variance / static_cast<double>(pixels) / samples / (samples - 1));
  return error > mOptions.noise * std::max(mean / static_cast<double>(pixels), floor);
}

} // namespace volcaustic
