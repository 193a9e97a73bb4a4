// Which channels of an image are written.
#include "image/image_file.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>
#include <optional>

namespace volcaustic {

namespace {

/// Whether `name` is what `pattern` describes.
bool fits(std::string_view pattern, std::string_view name) {
  const std::size_t star = pattern.find('*');
  if (star == pattern.npos) return pattern == name;
  if (!name.starts_with(pattern.substr(0, star))) return false;
  const std::string_view rest = pattern.substr(star + 1);
  for (std::size_t i = star; i <= name.size(); ++i)
    if (fits(rest, name.substr(i))) return true;
  return false;
}

std::string namesOf(const std::vector<std::string>& channels) {
  constexpr std::size_t kMost = 24;
  std::string names;
  for (std::size_t i = 0; i < std::min(channels.size(), kMost); ++i) names += (i == 0 ? "" : ", ") + channels[i];
  return names + (channels.size() > kMost ? ", ..." : "");
}

/// The one of this name among the chosen channels of an image.
std::optional<std::size_t> channelOf(const Image& image, const std::vector<std::size_t>& chosen,
                                     const std::string& name) {
  const auto found =
      std::find_if(chosen.begin(), chosen.end(), [&](std::size_t i) { return image.channels[i] == name; });
  return found == chosen.end() ? std::nullopt : std::optional(*found);
}

/// R, G and B of a layer ("caustic." or "") among the chosen channels, or nothing.
std::vector<std::size_t> layerOf(const Image& image, const std::vector<std::size_t>& chosen, const std::string& layer) {
  std::vector<std::size_t> rgb;
  for (const char* colour : {"R", "G", "B"})
    if (const auto channel = channelOf(image, chosen, layer + colour)) rgb.push_back(*channel);
  if (rgb.size() < 3) rgb.clear();
  return rgb;
}

} // namespace

std::vector<std::size_t> chosenChannels(const std::vector<std::string>& channels,
                                        const std::vector<std::string>& layers, const std::string& place) {
  std::vector<bool> chosen(channels.size(), layers.empty());
  for (const std::string& pattern : layers) {
    bool any = false;
    for (std::size_t i = 0; i < channels.size(); ++i)
      if (fits(pattern, channels[i])) any = chosen[i] = true;
    if (!any)
      throw Error(ErrorKind::Usage, place + ": no channel is called '" + pattern + "'; there are " + namesOf(channels) +
                                        " (caustic.* for all of a layer)");
  }
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) numbers.push_back(i);
  return numbers;
}

void checkLayers(const std::filesystem::path& path, const std::vector<std::string>& channels,
                 const std::vector<std::string>& layers) {
  (void)chosenChannels(channels, layers, path.string());
}

std::vector<std::size_t> colourChannels(const Image& image, const std::vector<std::size_t>& chosen) {
  if (auto rgb = layerOf(image, chosen, ""); !rgb.empty()) return rgb;
  for (const std::size_t i : chosen) {
    const std::string& name = image.channels[i];
    if (!name.ends_with(".R")) continue;
    if (auto rgb = layerOf(image, chosen, name.substr(0, name.size() - 1)); !rgb.empty()) return rgb;
  }
  if (chosen.size() == 1) return chosen;
  const auto grey = channelOf(image, chosen, "Y");
  return grey ? std::vector{*grey} : std::vector<std::size_t>{};
}

ColourPlanes colourPlanes(const Image& image, const std::vector<std::size_t>& channels, bool alpha,
                          const std::string& place) {
  ColourPlanes planes;
  for (const std::size_t i : colourChannels(image, channels)) planes.colours.push_back(&image.planes[i]);
  if (planes.colours.empty())
    throw Error(ErrorKind::Usage, place + ": needs channels R, G and B of one layer, or a single channel; there are " +
                                      namesOf(image.channels) + "; choose a layer, or write an .exr");
  const bool picture = !layerOf(image, channels, "").empty();

  const std::array background{image.find("background.R"), image.find("background.G"), image.find("background.B")};
  const bool knowsBackground = picture && std::find(background.begin(), background.end(), -1) == background.end();
  const auto chosenAlpha = channelOf(image, channels, "A");
  const std::vector<float>* opacity = alpha && image.find("A") >= 0 ? &image.planes[image.find("A")]
                                      : chosenAlpha                 ? &image.planes[*chosenAlpha]
                                                                    : nullptr;
  if (alpha && (!opacity || !picture))
    throw Error(ErrorKind::Usage, place + ": the image has no alpha (channel A beside R, G and B); write it without");
  if (alpha && knowsBackground)
    for (const int i : background) planes.backgrounds.push_back(&image.planes[i]);
  // An alpha that is 0 everywhere was never filled in.
  const bool filled = opacity && std::any_of(opacity->begin(), opacity->end(), [](float a) { return a > 0; });
  if (picture && (alpha || (filled && !knowsBackground))) planes.alpha = opacity;
  return planes;
}

std::vector<float> interleaved(const ColourPlanes& planes, bool alpha) {
  const std::size_t pixels = planes.colours[0]->size(), colours = planes.colours.size(),
                    channels = colours + (alpha ? 1 : 0);
  std::vector<float> result(pixels * channels);
  for (std::size_t c = 0; c < colours; ++c)
    for (std::size_t i = 0; i < pixels; ++i) {
      const float behind = planes.backgrounds.empty() ? 0 : (*planes.backgrounds[c])[i];
      result[i * channels + c] = (*planes.colours[c])[i] - behind;
    }
  for (std::size_t i = 0; alpha && i < pixels; ++i) result[i * channels + colours] = (*planes.alpha)[i];
  return result;
}

} // namespace volcaustic
