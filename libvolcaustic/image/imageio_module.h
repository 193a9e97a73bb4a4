// The border between the library and the loadable module volcaustic_imageio, which alone links OpenImageIO. OpenImageIO
// brings some 240 shared libraries: a third of a second of every program's start, for those few that touch a picture.
#pragma once

#include "volcaustic/export.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace volcaustic {

/// What the header of an image file claims.
struct ImageFileHeader {
  int width = 0, height = 0, depth = 1;
  std::vector<std::string> channels;
  int alphaChannel = -1;
  bool straightAlpha = false;                  ///< colours are stored without being multiplied by alpha
  bool deep = false;                           ///< several samples a pixel
  bool floatingPoint = false;                  ///< linear values; else integers in sRGB
  std::uint64_t uncompressedBytes = 0;         ///< of pixels in the file; 0 where they are compressed
  std::vector<float> chromaticities;           ///< x, y of red, green, blue and white; empty where nothing is said
  std::map<std::string, std::string> metadata; ///< attributes that are text, or that writers make of text
};

/// Where a picture goes, what its writer would like, and what is written besides its pixels.
struct ImageFileTarget {
  std::string path;      ///< names the format, and the file in messages
  std::string temporary; ///< the file that is written
  int width = 0, height = 0;
  int colours = 3;    ///< or 1, grey
  bool alpha = false; ///< one channel more
  int bits = 8;       ///< of a channel: integers of 8 or 16 in sRGB with straight alpha, or 32-bit floats, linear
  std::map<std::string, std::string> metadata;
};

/// What the file's format makes of that.
struct ImageFileFormat {
  int bits = 8;
  bool alpha = false;
};

/// The module's functions. Both sides come from one build: `version` refuses a module left over from another. Errors
/// are volcaustic::Error, whose header has no code to link.
struct ImageIo {
  const char* version;
  /// Decodes the first picture, pixel by pixel, channels side by side. `accept` sees the header before anything is
  /// allocated and may throw. Sets OpenImageIO to one thread for the rest of the process: for a child that ends soon.
  std::vector<float> (*read)(const std::string& path, const std::function<void(const ImageFileHeader&)>& accept);
  /// Writes one picture. `pixels` is asked once, for what the format holds.
  void (*write)(const ImageFileTarget& target,
                const std::function<std::vector<float>(const ImageFileFormat& format)>& pixels);
};

/// The module's one exported function, "volcausticImageIo".
using ImageIoEntry = const ImageIo* (*)();

/// The module's functions, loaded at the first call. The loader looks in LD_LIBRARY_PATH, then where the run path of
/// the program, or of the shared library volcaustic, points (cmake/VolcausticImageIo.cmake), then in the system's
/// folders. \throws Error(File) "place: ..." when the module or OpenImageIO is not there.
const ImageIo& imageIo(const std::string& place);

} // namespace volcaustic
