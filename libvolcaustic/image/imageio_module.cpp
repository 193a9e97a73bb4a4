#include "image/imageio_module.h"

#include "volcaustic/error.h"

#include <dlfcn.h>
#include <string_view>

namespace volcaustic {

namespace {

constexpr const char* kModule = "volcaustic_imageio.so";

/// Never closed: OpenImageIO registers what runs at the end of the process.
const ImageIo& load() {
  void* module = dlopen(kModule, RTLD_LAZY | RTLD_LOCAL);
  if (!module) throw Error(ErrorKind::File, dlerror());
  const auto entry = reinterpret_cast<ImageIoEntry>(dlsym(module, "volcausticImageIo"));
  if (!entry) throw Error(ErrorKind::File, dlerror());
  const ImageIo& functions = *entry();
  if (std::string_view(functions.version) != VOLCAUSTIC_VERSION)
    throw Error(ErrorKind::File, std::string(kModule) + " is of version " + functions.version);
  return functions;
}

} // namespace

const ImageIo& imageIo(const std::string& place) {
  try {
    static const ImageIo& functions = load(); // tried again at the next call when it throws
    return functions;
  } catch (const Error& error) {
    throw Error(ErrorKind::File, place + ": needs the module " + kModule + " of volcaustic " VOLCAUSTIC_VERSION ": " +
                                     error.what() +
                                     "; install it and OpenImageIO, name its folder in LD_LIBRARY_PATH, or write .exr");
  }
}

} // namespace volcaustic
