#include "volcaustic/image.h"

#include <algorithm>

namespace volcaustic {

int Image::find(std::string_view channel) const {
  const auto found = std::find(channels.begin(), channels.end(), channel);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

std::vector<float>& Image::add(std::string name) {
  channels.push_back(std::move(name));
  return planes.emplace_back(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F);
}

} // namespace volcaustic
