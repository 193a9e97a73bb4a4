// libvolcaustic_c.so, loaded when the first scene is opened: programs that list OpenImageIO's formats stay fast.
#pragma once

#include <string>
#include <volcaustic_c.h>

namespace volcaustic::plugin {

/// The functions of volcaustic_c.h that the plugin calls.
struct Host {
  decltype(&volcaustic_message) message = nullptr;
  decltype(&volcaustic_open) open = nullptr;
  decltype(&volcaustic_close) close = nullptr;
  decltype(&volcaustic_set_scene) setScene = nullptr;
  decltype(&volcaustic_frames) frames = nullptr;
  decltype(&volcaustic_grid_count) gridCount = nullptr;
  decltype(&volcaustic_grid_at) gridAt = nullptr;
  decltype(&volcaustic_read_grid) readGrid = nullptr;
  decltype(&volcaustic_picture_of) pictureOf = nullptr;
  decltype(&volcaustic_channel) channel = nullptr;
  decltype(&volcaustic_read_picture) readPicture = nullptr;
};

/// Null where the library cannot be loaded or is too old; then `error` has a line.
const Host* host(std::string& error);

} // namespace volcaustic::plugin
