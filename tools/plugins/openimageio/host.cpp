#include "host.h"

#include <dlfcn.h>

namespace volcaustic::plugin {

namespace {

constexpr const char* kLibrary = "libvolcaustic_c.so.1";

template <class Function>
bool find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

bool findAll(void* library, Host& h) {
  return find(library, "volcaustic_message", h.message) && find(library, "volcaustic_open", h.open) &&
         find(library, "volcaustic_close", h.close) && find(library, "volcaustic_set_scene", h.setScene) &&
         find(library, "volcaustic_frames", h.frames) && find(library, "volcaustic_grid_count", h.gridCount) &&
         find(library, "volcaustic_grid_at", h.gridAt) && find(library, "volcaustic_read_grid", h.readGrid) &&
         find(library, "volcaustic_picture_of", h.pictureOf) && find(library, "volcaustic_channel", h.channel) &&
         find(library, "volcaustic_read_picture", h.readPicture);
}

struct Loaded {
  Host functions;
  std::string error;
};

/// Never closed: it has threads.
Loaded load() {
  Loaded result;
  void* library = dlopen(kLibrary, RTLD_LAZY | RTLD_LOCAL);
  if (!library) {
    const char* reason = dlerror();
    result.error =
        std::string(reason ? reason : kLibrary) + "; install volcaustic, or name its folder in LD_LIBRARY_PATH";
    return result;
  }
  decltype(&volcaustic_interface) interface = nullptr;
  if (!find(library, "volcaustic_interface", interface) || interface() < VOLCAUSTIC_C_INTERFACE ||
      !findAll(library, result.functions))
    result.error = std::string(kLibrary) + " is older than this plugin; install both from one release of volcaustic";
  return result;
}

} // namespace

const Host* host(std::string& error) {
  static const Loaded loaded = load();
  error = loaded.error;
  return error.empty() ? &loaded.functions : nullptr;
}

} // namespace volcaustic::plugin
