#include "volume/host_grids.h"

#include <algorithm>
#include <string_view>

namespace volcaustic {

namespace {

/// A program that opens volumes of light.
struct Host {
  HostPreset preset;
  bool half;
  std::string_view unused[4]; ///< kinds of grids
};

// Unreal has four channels for each of two textures: emission and density fill the first. Houdini's volumes are worked
// on further, so that nothing is taken from them. No shader of the others has a use for the mean direction.
constexpr Host kHosts[] = {
    {HostPreset::Blender, true, {"direction"}},
    {HostPreset::Houdini, false, {}},
    {HostPreset::Arnold, true, {"direction"}},
    {HostPreset::Unreal, true, {"direction", "radiance", "caustic", "direct"}},
    {HostPreset::Renderman, true, {"direction"}},
};

constexpr std::string_view kKindsOfLight[] = {"radiance", "caustic", "direct", "direction", "emission", "density"};

bool isVolumeOfLight(const openvdb::GridPtrVec& grids) {
  return std::any_of(grids.begin(), grids.end(), [](const auto& grid) { return grid->getName() == "emission"; });
}

template <class Names>
bool contains(const Names& names, std::string_view grid) {
  const std::string_view kind = grid.substr(0, grid.find('_')); // of which light
  return !kind.empty() && std::find(std::begin(names), std::end(names), kind) != std::end(names);
}

} // namespace

openvdb::GridPtrVec gridsForHost(const openvdb::GridPtrVec& grids, HostPreset preset) {
  const auto host =
      std::find_if(std::begin(kHosts), std::end(kHosts), [&](const Host& h) { return h.preset == preset; });
  if (host == std::end(kHosts) || !isVolumeOfLight(grids)) return grids;
  openvdb::GridPtrVec list;
  for (const auto& grid : grids) {
    if (contains(host->unused, grid->getName())) continue;
    list.push_back(grid->copyGrid());
    if (host->half && contains(kKindsOfLight, grid->getName())) list.back()->setSaveFloatAsHalf(true);
  }
  return list;
}

} // namespace volcaustic
