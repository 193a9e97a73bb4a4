// Colour spaces of linear Rec. 709 pixels under D65: the sRGB curve, XYZ, and the opponent and uniform spaces that
// differences are seen in.
#pragma once

#include <array>
#include <cmath>

namespace volcaustic {

/// IEC 61966-2-1, both ways; values outside 0..1 are continued by the same curves.
inline float srgbFromLinear(float v) { return v <= 0.0031308F ? 12.92F * v : 1.055F * std::pow(v, 1 / 2.4F) - 0.055F; }
inline float linearFromSrgb(float v) { return v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F); }

using Colour = std::array<float, 3>;
using ColourMatrix = std::array<Colour, 3>; ///< rows

inline Colour operator*(const ColourMatrix& m, const Colour& c) {
  const auto row = [&](const Colour& r) { return r[0] * c[0] + r[1] * c[1] + r[2] * c[2]; };
  return {row(m[0]), row(m[1]), row(m[2])};
}

/// CIE XYZ divided by the white point's, so that white is (1, 1, 1), and back.
inline constexpr ColourMatrix kRelativeXyzFromRgb{{{0.43388735F, 0.37622401F, 0.18988865F},
                                                   {0.21263901F, 0.71516868F, 0.07219232F},
                                                   {0.01775004F, 0.10944762F, 0.87280234F}}};
inline constexpr ColourMatrix kRgbFromRelativeXyz{{{3.08039909F, -1.53738318F, -0.54301591F},
                                                   {-0.92122336F, 1.87596750F, 0.04525586F},
                                                   {0.05287394F, -0.20397696F, 1.15110302F}}};

/// CIELAB without its cube roots, an opponent space for filters: achromatic, red-green, blue-yellow. B. W. Kolpatzik,
/// C. A. Bouman, Optimized error diffusion for image display, J. Electronic Imaging 1 (1992): "YyCxCz".
inline Colour opponentFromXyz(const Colour& xyz) {
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}
inline Colour xyzFromOpponent(const Colour& o) {
  const float y = (o[0] + 16) * (1 / 116.0F);
  return {y + o[1] * (1 / 500.0F), y, y - o[2] * (1 / 200.0F)};
}

/// CIE 1976 L*a*b*.
inline Colour labFromXyz(const Colour& xyz) {
  constexpr float kDelta = 6 / 29.0F;
  const auto f = [](float t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t * (1 / (3 * kDelta * kDelta)) + 4 / 29.0F;
  };
  const float x = f(xyz[0]), y = f(xyz[1]), z = f(xyz[2]);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

} // namespace volcaustic
