/// \file background.h
/// What is around the domain, infinitely far away: a colour, a gradient, or a map of all directions.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/image.h"
#include "volcaustic/run_context.h"
#include "volcaustic/types.h"

#include <filesystem>
#include <memory>

namespace volcaustic {

/// Radiance from every direction, W/(m2 sr). What a camera ray meets when it leaves the domain, and what lights of the
/// type Environment shine with.
struct Background {
  Rgb bottom{0.02, 0.02, 0.03}; ///< looking straight down; in between it follows the sine of the height
  Rgb top{0.10, 0.12, 0.16};    ///< looking straight up; equal to `bottom` it is one colour
  Vec3d up{0, 0, 1};            ///< world space, any length: the gradient's axis, the map's pole
  /// A picture in latitude and longitude that takes the gradient's place: its upper edge is `up`, its middle the
  /// direction across `up` that is nearest to +x, and what is right of the middle is on the right of somebody who
  /// stands inside and looks there (docs/formats.md, "Environment maps").
  std::filesystem::path file{};
  double turn = 0;                      ///< degrees that the map is turned about `up`, counterclockwise seen from there
  Rgb scale{1, 1, 1};                   ///< multiplies the map
  bool visible = true;                  ///< false: cameras see black; lights of the type Environment shine as before
  std::shared_ptr<const Image> image{}; ///< the map, as readEnvironment makes it; wins over `file`
};

/// Reads a map: what readImage reads, as the three channels R, G and B (of the first layer, or of one channel as grey).
/// Pixels that are negative or not finite become 0, with a warning. \throws Error(File), Error(Input) for damaged
/// files, maps in other projections (as far as they say so) and pictures without colour.
VOLCAUSTIC_API std::shared_ptr<const Image> readEnvironment(const std::filesystem::path& path,
                                                            const RunContext& ctx = {});

} // namespace volcaustic
