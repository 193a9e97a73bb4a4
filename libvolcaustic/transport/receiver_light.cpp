#include "transport/receiver_light.h"

#include "core/parallel.h"
#include "transport/receiver_direct.h"

namespace volcaustic {

ReceiverLight::ReceiverLight(const ReceiverSet& set, const Domain& domain, const Ambient& ambient,
                             const RunContext& ctx)
    : mSet(set)
    , mDomain(domain)
    , mAmbient(ambient)
    , mCtx(ctx)
    , mDirect(3 * static_cast<std::size_t>(set.texelCount()))
    , mLanded(mDirect.size())
    , mUnits(mDirect.size(), 0) {}

void ReceiverLight::addDirect(const LightPart& part, const kernels::EmissionFrame& frame,
                              std::span<const float> entry) {
  addDirectLight(mSet, mDomain, mAmbient, part, frame, entry, mDirect, mCtx);
}

void ReceiverLight::addLandings(const kernels::EmissionFrame& frame, std::span<const kernels::Landing> landings) {
  addLandedPower(mSet, frame, landings, mUnits, mLanded, mCtx);
}

/// Texels without surface get the mean of those with surface around them, which are of the same chart.
void ReceiverLight::fillBorders(std::vector<float>& light) const {
  const auto texels = mSet.texels();
  for (const ReceiverChart& chart : mSet.charts()) {
    if (mSet.isFlat(chart.receiver)) continue;
    const TexelRange& t = chart.texels;
    const auto inside = [&](std::int32_t c, std::int32_t r) {
      return c >= t.column && c < t.column + t.columns && r >= t.row && r < t.row + t.rows;
    };
    for (std::int32_t row = t.row; row < t.row + t.rows; ++row)
      for (std::int32_t column = t.column; column < t.column + t.columns; ++column) {
        const std::int64_t at = mSet.texelAt(chart.receiver, column, row);
        if (texels[at].area > 0) continue;
        kernels::Double3 sum(0, 0, 0);
        int count = 0;
        for (int i = 0; i < 9; ++i) {
          const std::int32_t c = column + i % 3 - 1, r = row + i / 3 - 1;
          const std::int64_t beside = mSet.texelAt(chart.receiver, c, r);
          if (!inside(c, r) || !(texels[beside].area > 0)) continue;
          sum += {light[3 * beside], light[3 * beside + 1], light[3 * beside + 2]};
          ++count;
        }
        for (int i = 0; i < 3 && count > 0; ++i) light[3 * at + i] = static_cast<float>(sum[i] / count);
      }
  }
}

ReceivedLight ReceiverLight::finish() {
  ReceivedLight light;
  light.caustic = std::move(mLanded);
  light.direct = std::move(mDirect);
  const auto texels = mSet.texels();
  parallelFor(mSet.texelCount(), 1 << 14, mCtx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t t = begin; t < end; ++t)
      for (int c = 0; c < 3; ++c)
        light.caustic[3 * t + c] = texels[t].area > 0 ? light.caustic[3 * t + c] / texels[t].area : 0;
  });
  fillBorders(light.caustic);
  fillBorders(light.direct);
  light.irradiance.resize(light.direct.size());
  for (std::size_t i = 0; i < light.irradiance.size(); ++i) light.irradiance[i] = light.caustic[i] + light.direct[i];
  return light;
}

} // namespace volcaustic
