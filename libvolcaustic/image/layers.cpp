// Which channels of an image are written.
#include "image/image_file.h"
#include "volcaustic/error.h"

#include <algorithm>
#include <array>

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

std::string namesOf(const Image& image) {
  constexpr std::size_t kMost = 24;
  std::string names;
  for (std::size_t i = 0; i < std::min(image.channels.size(), kMost); ++i)
    names += (i == 0 ? "" : ", ") + image.channels[i];
  return names + (image.channels.size() > kMost ? ", ..." : "");
}

/// Finds planes among the chosen channels of an image by name.
class Chosen {
public:
  Chosen(const Image& image, const std::vector<std::size_t>& channels) : mImage(image), mChannels(channels) {}

  const std::vector<float>* plane(const std::string& name) const {
    for (const std::size_t i : mChannels)
      if (mImage.channels[i] == name) return &mImage.planes[i];
    return nullptr;
  }
  /// R, G and B of a layer ("caustic." or ""), or nothing.
  std::vector<const std::vector<float>*> layer(const std::string& name) const {
    std::vector<const std::vector<float>*> rgb{plane(name + "R"), plane(name + "G"), plane(name + "B")};
    if (std::find(rgb.begin(), rgb.end(), nullptr) != rgb.end()) rgb.clear();
    return rgb;
  }
  /// The first whole layer that has a name, else an only channel as grey, else nothing.
  std::vector<const std::vector<float>*> layerOrGrey() const {
    for (const std::size_t i : mChannels) {
      const std::string& name = mImage.channels[i];
      if (!name.ends_with(".R")) continue;
      if (auto rgb = layer(name.substr(0, name.size() - 1)); !rgb.empty()) return rgb;
    }
    const std::vector<float>* grey = mChannels.size() == 1 ? &mImage.planes[mChannels[0]] : plane("Y");
    return grey ? std::vector{grey} : std::vector<const std::vector<float>*>{};
  }

private:
  const Image& mImage;
  const std::vector<std::size_t>& mChannels;
};

} // namespace

std::vector<std::size_t> chosenChannels(const Image& image, const std::vector<std::string>& layers,
                                        const std::string& place) {
  std::vector<bool> chosen(image.channels.size(), layers.empty());
  for (const std::string& pattern : layers) {
    bool any = false;
    for (std::size_t i = 0; i < image.channels.size(); ++i)
      if (fits(pattern, image.channels[i])) any = chosen[i] = true;
    if (!any)
      throw Error(ErrorKind::Usage, place + ": no channel is called '" + pattern + "'; there are " + namesOf(image) +
                                        " (caustic.* for all of a layer)");
  }
  std::vector<std::size_t> channels;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) channels.push_back(i);
  return channels;
}

ColourPlanes colourPlanes(const Image& image, const std::vector<std::size_t>& channels, bool alpha,
                          const std::string& place) {
  const Chosen chosen(image, channels);
  ColourPlanes planes;
  planes.colours = chosen.layer("");
  const bool picture = !planes.colours.empty();
  if (!picture) planes.colours = chosen.layerOrGrey();
  if (planes.colours.empty())
    throw Error(ErrorKind::Usage, place + ": needs channels R, G and B of one layer, or a single channel; there are " +
                                      namesOf(image) + "; choose a layer, or write an .exr");

  const std::array background{image.find("background.R"), image.find("background.G"), image.find("background.B")};
  const bool knowsBackground = picture && std::find(background.begin(), background.end(), -1) == background.end();
  const std::vector<float>* opacity =
      alpha && image.find("A") >= 0 ? &image.planes[image.find("A")] : chosen.plane("A");
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
