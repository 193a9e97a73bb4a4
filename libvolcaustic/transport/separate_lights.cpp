#include "transport/separate_lights.h"

#include "transport/lit_receivers.h"
#include "transport/passes.h"
#include "transport/picture.h"
#include "volcaustic/error.h"
#include "volume/radiance_bricks.h"

#include <algorithm>
#include <functional>
#include <set>

namespace volcaustic {

namespace {

void add(Rgb& a, const Rgb& b) { std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::plus<>()); }

void add(EnergyBalance& a, const EnergyBalance& b) {
  for (Rgb EnergyBalance::*power :
       {&EnergyBalance::emitted, &EnergyBalance::absorbed, &EnergyBalance::scattered, &EnergyBalance::escaped,
        &EnergyBalance::received, &EnergyBalance::cutOff, &EnergyBalance::tracedLoss, &EnergyBalance::depositedLoss})
    add(a.*power, b.*power);
  for (std::int64_t EnergyBalance::*count :
       {&EnergyBalance::photonsEmitted, &EnergyBalance::photonsTraced, &EnergyBalance::photonsAtStepLimit,
        &EnergyBalance::photonsNotFinite, &EnergyBalance::steps, &EnergyBalance::voxelsCrossed})
    a.*count += b.*count;
}

void add(std::vector<PassPart>& a, const std::vector<PassPart>& b) {
  for (const PassPart& part : b) {
    const auto same = std::find_if(a.begin(), a.end(), [&](const PassPart& p) { return p.name == part.name; });
    if (same != a.end())
      same->ms += part.ms;
    else
      a.push_back(part);
  }
}

/// Irradiance of the same receivers under several lights.
LitReceivers sumOfReceivers(const std::vector<PhotonResult>& lights) {
  if (lights.empty() || !lights.front().receivers) return {};
  LitReceiverData sum = lights.front().receivers.data();
  const auto add = [](std::vector<float>& a, const std::vector<float>& b) {
    std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::plus<>());
  };
  for (std::size_t i = 1; i < lights.size(); ++i) {
    const ReceivedLight& light = lights[i].receivers.data().light;
    add(sum.light.irradiance, light.irradiance);
    add(sum.light.caustic, light.caustic);
    add(sum.light.direct, light.direct);
  }
  return LitReceivers(std::make_shared<const LitReceiverData>(std::move(sum)));
}

/// Whether a channel is the same whatever the lights.
bool isOfTheCamera(const std::string& channel) {
  return channel == "A" || channel.starts_with("transmittance.") || channel == "depth.Z" || channel == "steps.Y";
}

/// Adds a picture to the sum of those before it, and the layers of its light.
void addPicture(ViewResult& sum, ViewResult one, const std::string& light) {
  const Image& image = one.image;
  const std::size_t pixels = image.planes.front().size();
  std::vector<std::vector<float>> whole(3, std::vector<float>(pixels));
  for (const char* part : kLightParts)
    for (int c = 0; c < 3; ++c) {
      const std::string channel = std::string(part) + "." + "RGB"[c];
      const std::vector<float>& plane = image.planes[image.find(channel)];
      std::transform(whole[c].begin(), whole[c].end(), plane.begin(), whole[c].begin(), std::plus<>());
      sum.image.planes[sum.image.find(light + "." + channel)] = plane;
    }
  for (int c = 0; c < 3; ++c) sum.image.planes[sum.image.find(light + "." + "RGB"[c])] = std::move(whole[c]);
  for (std::size_t i = 0; i < image.channels.size(); ++i) {
    std::vector<float>& to = sum.image.planes[sum.image.find(image.channels[i])];
    if (sum.passes == 0)
      to = std::move(one.image.planes[i]);
    else if (!isOfTheCamera(image.channels[i]))
      std::transform(to.begin(), to.end(), image.planes[i].begin(), to.begin(), std::plus<>());
  }
  sum.steps += one.steps;
  sum.raysNotFinite += one.raysNotFinite;
  sum.raysAtStepLimit += one.raysAtStepLimit;
  sum.samples += one.samples;
  sum.passes += one.passes;
}

} // namespace

std::vector<std::string> lightLayers(std::span<const Light> lights) {
  std::set<std::string> taken{"caustic", "direct", "background", "receiver", "transmittance", "depth", "steps"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const auto isPlain = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    };
    std::string name = lights[i].name.empty() ? "light" + std::to_string(i) : lights[i].name;
    std::replace_if(name.begin(), name.end(), std::not_fn(isPlain), '_');
    if (!taken.insert(name).second)
      throw Error(ErrorKind::Usage, "lights[" + std::to_string(i) + "] (" + lights[i].name +
                                        "): separate lights have layers of their own, and one is called '" + name +
                                        "' already; give another name");
    names.push_back(std::move(name));
  }
  return names;
}

RunContext shareOf(const RunContext& ctx, int number, int count, const std::vector<PhotonResult>& before) {
  RunContext share = ctx;
  if (ctx.onProgress)
    share.onProgress = [&ctx, number, count](std::string_view stage, double fraction) {
      ctx.onProgress(stage, (number + fraction) / count);
    };
  std::uint64_t taken = 0;
  for (const PhotonResult& r : before)
    taken += r.radiance.bricks().caustic.memoryBytes() + r.radiance.bricks().direct.stored.memoryBytes();
  const std::uint64_t limit = ctx.effectiveMemoryLimit();
  share.memoryLimit = limit - std::min(limit - 1, taken);
  return share;
}

PhotonResult sumOf(std::vector<PhotonResult> lights, const Domain& domain, const RunContext& ctx) {
  PhotonResult sum;
  std::vector<const RadianceBricks*> bricks;
  for (const PhotonResult& light : lights) {
    bricks.push_back(&light.radiance.bricks());
    add(sum.balance, light.balance);
    add(sum.parts, light.parts);
    sum.sumsBytes = std::max(sum.sumsBytes, light.sumsBytes);
  }
  sum.radiance =
      RadianceVolume(domain, bricks.empty() ? std::make_shared<const RadianceBricks>(domain.dims) : sumOf(bricks, ctx));
  sum.receivers = sumOfReceivers(lights);
  sum.lights = std::move(lights);
  return sum;
}

ViewResult renderView(const Medium& medium, const FlatMediumStorage& flat, const PhotonResult& photons,
                      const Camera& camera, const Background& background, const ViewOptions& options,
                      const RunContext& ctx, const ViewObserver& observer) {
  const std::vector<PhotonResult>& lights = photons.lights;
  if (lights.empty())
    return renderView(medium, flat, photons.radiance, photons.receivers, camera, background, options, ctx, observer);
  std::vector<std::string> names;
  for (const PhotonResult& light : lights) names.push_back(light.light);
  ViewResult sum;
  sum.image.width = camera.resolution[0];
  sum.image.height = camera.resolution[1];
  sum.image.channels = pictureChannels(names);
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(sum.image.width) * static_cast<std::uint64_t>(sum.image.height);
  ctx.requireMemory(sum.image.channels.size() * pixels * sizeof(float), "camera.resolution");
  sum.image.planes.resize(sum.image.channels.size());
  Background dark = background;
  dark.visible = false;
  for (int i = 0; i < static_cast<int>(lights.size()); ++i) {
    const RunContext share = shareOf(ctx, i, static_cast<int>(lights.size()), {});
    addPicture(sum,
               renderView(medium, flat, lights[i].radiance, lights[i].receivers, camera, i == 0 ? background : dark,
                          options, share),
               names[i]);
    if (observer) observer(sum);
  }
  return sum;
}

} // namespace volcaustic
