// What the image readers and writers of this folder share.
#pragma once

#include "volcaustic/image.h"

#include <cmath>

namespace volcaustic {

/// Writes every channel to one multi-layer OpenEXR part. \throws Error(File).
void writeExr(const std::filesystem::path& target, const Image& image, const ImageWriteOptions& options);

/// IEC 61966-2-1, both ways; values outside 0..1 are continued by the same curves.
inline float srgbFromLinear(float v) { return v <= 0.0031308F ? 12.92F * v : 1.055F * std::pow(v, 1 / 2.4F) - 0.055F; }
inline float linearFromSrgb(float v) { return v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F); }

} // namespace volcaustic
