#include "image/image_file.h"
#include "volcaustic/background.h"
#include "volcaustic/error.h"

#include <limits>
#include <numeric>

namespace volcaustic {

std::shared_ptr<const Image> readEnvironment(const std::filesystem::path& path, const RunContext& ctx) {
  const std::string place = path.string();
  Image picture = readImage(path, ctx);
  const auto projection = picture.metadata.find("textureformat");
  if (projection != picture.metadata.end() && projection->second.starts_with("CubeFace"))
    throw Error(ErrorKind::Input,
                place + ": its envmap is a cube; convert it to latitude and longitude (exrenvmap -l)");
  std::vector<std::size_t> all(picture.channels.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<std::size_t> colours = colourChannels(picture, all);
  if (colours.empty()) throw Error(ErrorKind::Input, place + ": has no channels R, G and B of one layer, and no grey");

  auto map = std::make_shared<Image>();
  map->width = picture.width;
  map->height = picture.height;
  map->channels = {"R", "G", "B"};
  std::size_t wrong = 0;
  for (const std::size_t i : colours) {
    map->planes.push_back(std::move(picture.planes[i]));
    for (float& v : map->planes.back())
      if (!(v >= 0 && v <= std::numeric_limits<float>::max())) {
        v = 0;
        ++wrong;
      }
  }
  if (wrong > 0)
    ctx.warn(place + ": " + std::to_string(wrong) + " numbers are negative or not finite; they are taken as 0");
  map->planes.resize(3, map->planes.front());
  return map;
}

} // namespace volcaustic
