// What the image readers and writers of this folder share.
#pragma once

#include "volcaustic/image.h"

#include <cstddef>
#include <string>
#include <vector>

namespace volcaustic {

/// Numbers of the channels that `layers` names, in their order; all of them when it names none. A `*` stands for any
/// letters. \throws Error(Usage) "place: ..." when a name fits no channel.
std::vector<std::size_t> chosenChannels(const std::vector<std::string>& channels,
                                        const std::vector<std::string>& layers, const std::string& place);

/// R, G and B of the picture, else of the first layer that has them, else an only channel or Y as grey, else nothing:
/// what of the chosen channels is colour.
std::vector<std::size_t> colourChannels(const Image& image, const std::vector<std::size_t>& chosen);

/// Writes the channels to one multi-layer OpenEXR part. \throws Error(File).
void writeExr(const std::filesystem::path& target, const Image& image, const std::vector<std::size_t>& channels,
              const ImageWriteOptions& options);

/// What of an image goes into a format that knows colour and alpha only; planes are the image's.
struct ColourPlanes {
  std::vector<const std::vector<float>*> colours;     ///< three, or one of grey
  std::vector<const std::vector<float>*> backgrounds; ///< to be taken out of the colours; three or none
  const std::vector<float>* alpha = nullptr;
};

/// \throws Error(Usage) "place: ..." when the chosen channels are no picture.
ColourPlanes colourPlanes(const Image& image, const std::vector<std::size_t>& channels, bool alpha,
                          const std::string& place);

/// Pixel by pixel, colours and alpha side by side, linear.
std::vector<float> interleaved(const ColourPlanes& planes, bool alpha);

/// From linear light with alpha multiplied in to what integers of so many bits store: straight alpha, exposure, tone,
/// sRGB, and for 8 bits a dither, after which every value is a code divided by 255.
void encodeForDisplay(std::vector<float>& pixels, std::size_t width, std::size_t colours, bool alpha, int bits,
                      const ImageWriteOptions& options);

} // namespace volcaustic
