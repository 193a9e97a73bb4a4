#include "scene/gltf_animation.h"

#include "scene/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace volcaustic {

namespace {

enum class Interpolation { Step, Linear, CubicSpline };

Interpolation interpolationOf(const GltfValue& sampler) {
  const auto value = sampler.find("interpolation");
  if (!value || value->text() == "LINEAR") return Interpolation::Linear;
  if (value->text() == "STEP") return Interpolation::Step;
  if (value->text() == "CUBICSPLINE") return Interpolation::CubicSpline;
  value->fail(excerpt(value->text()) + " is not known; give STEP, LINEAR or CUBICSPLINE");
}

/// Between unit quaternions, the short way round.
void slerp(std::span<const double> from, std::span<const double> to, double t, std::span<double> out) {
  double cosine = 0;
  for (std::size_t c = 0; c < 4; ++c) cosine += from[c] * to[c];
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
  // Closer than this, the chord is the arc to the last digit.
  const bool isStraight = sine < 1e-6;
  const double a = isStraight ? 1 - t : std::sin((1 - t) * angle) / sine,
               b = isStraight ? t : std::sin(t * angle) / sine;
  for (std::size_t c = 0; c < 4; ++c) out[c] = a * from[c] + sign * b * to[c];
}

/// Keys of one animated property.
class Track {
public:
  Track(GltfFile& file, const GltfValue& sampler, std::size_t width)
      : mWidth(width), mInterpolation(interpolationOf(sampler)) {
    const GltfAccessor input(file, sampler.at("input"), "SCALAR");
    const GltfAccessor output(file, sampler.at("output"), width == 4 ? "VEC4" : "VEC3");
    mTimes = input.numbers();
    mValues = output.numbers();
    const std::size_t each = mInterpolation == Interpolation::CubicSpline ? 3 : 1;
    if (output.count() != each * input.count())
      sampler.at("output").fail(std::to_string(output.count()) + " values for " + std::to_string(input.count()) +
                                " times; " + std::to_string(each) + " for each are needed");
    for (std::size_t i = 1; i < mTimes.size(); ++i)
      if (!(mTimes[i] > mTimes[i - 1]))
        sampler.at("input").fail("time number " + std::to_string(i) + " does not come after the one before it");
  }

  [[nodiscard]] std::vector<double> at(double seconds) const {
    const auto next =
        static_cast<std::size_t>(std::upper_bound(mTimes.begin(), mTimes.end(), seconds) - mTimes.begin());
    if (next == 0) return copy(key(0));
    if (next == mTimes.size() || mInterpolation == Interpolation::Step) return copy(key(next - 1));
    const double span = mTimes[next] - mTimes[next - 1], t = (seconds - mTimes[next - 1]) / span;
    std::vector<double> value(mWidth);
    if (mInterpolation == Interpolation::CubicSpline)
      spline(next, t, span, value);
    else if (mWidth == 4)
      slerp(key(next - 1), key(next), t, value);
    else
      for (std::size_t c = 0; c < mWidth; ++c) value[c] = std::lerp(key(next - 1)[c], key(next)[c], t);
    return value;
  }

private:
  static std::vector<double> copy(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }

  /// Value `part` of key `i`; splines hold in-tangent, value and out-tangent.
  [[nodiscard]] std::span<const double> element(std::size_t i, std::size_t part) const {
    const bool isSpline = mInterpolation == Interpolation::CubicSpline;
    return std::span(mValues).subspan((isSpline ? 3 * i + part : i) * mWidth, mWidth);
  }
  [[nodiscard]] std::span<const double> key(std::size_t i) const { return element(i, 1); }

  /// Hermite's cubic, as appendix C of the glTF 2.0 specification writes it.
  void spline(std::size_t next, double t, double span, std::span<double> out) const {
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t c = 0; c < mWidth; ++c)
      out[c] = (2 * t3 - 3 * t2 + 1) * key(next - 1)[c] + span * (t3 - 2 * t2 + t) * element(next - 1, 2)[c] +
               (3 * t2 - 2 * t3) * key(next)[c] + span * (t3 - t2) * element(next, 0)[c];
  }

  std::size_t mWidth;
  Interpolation mInterpolation;
  std::vector<double> mTimes, mValues;
};

Vec3d triple(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

std::array<double, 4> quaternion(const std::vector<double>& v, const GltfValue& place) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  if (!(length > 1e-6)) place.fail("a rotation has no length; export it again");
  return {v[0] / length, v[1] / length, v[2] / length, v[3] / length};
}

class Poses {
public:
  Poses(GltfFile& file, double seconds, GltfNotes& notes) : mFile(file), mSeconds(seconds), mNotes(notes) {}

  void play(const GltfValue& animation) {
    const GltfValue channels = animation.at("channels"), samplers = animation.at("samplers");
    for (std::size_t i = 0; i < channels.size(); ++i) playChannel(channels[i], samplers);
  }

  std::map<std::size_t, GltfPose> poses;

private:
  void playChannel(const GltfValue& channel, const GltfValue& samplers) {
    const GltfValue target = channel.at("target"), path = target.at("path");
    const auto node = target.find("node");
    const std::string& property = path.text();
    if (!node || property == "pointer") return mNotes.add(channel, "only nodes are animated; this channel is left out");
    if (property == "weights") return mNotes.add(channel, "morph targets are not read; their animation is left out");
    const std::uint64_t number = channel.at("sampler").whole();
    if (number >= samplers.size()) channel.at("sampler").fail("there is no such sampler; export it again");
    GltfPose& pose = poses[mFile.indexOf(*node, "nodes")];
    if (property == "translation")
      set(pose.translation, channel, [&] { return triple(sample(samplers[number], 3)); });
    else if (property == "scale")
      set(pose.scale, channel, [&] { return triple(sample(samplers[number], 3)); });
    else if (property == "rotation")
      set(pose.rotation, channel, [&] { return quaternion(sample(samplers[number], 4), samplers[number]); });
    else
      path.fail(excerpt(property) + " is not known; give translation, rotation or scale");
  }

  std::vector<double> sample(const GltfValue& sampler, std::size_t width) {
    return Track(mFile, sampler, width).at(mSeconds);
  }

  template <class Value, class Sample>
  void set(std::optional<Value>& value, const GltfValue& channel, const Sample& sampled) {
    if (value)
      mNotes.add(channel, "another channel moves the same property of the node; the first one does");
    else
      value = sampled();
  }

  GltfFile& mFile;
  double mSeconds;
  GltfNotes& mNotes;
};

} // namespace

std::map<std::size_t, GltfPose> gltfPoses(GltfFile& file, double seconds, GltfNotes& notes) {
  Poses poses(file, seconds, notes);
  for (std::size_t i = 0; i < file.count("animations"); ++i) poses.play(file.item("animations", i));
  return std::move(poses.poses);
}

} // namespace volcaustic
