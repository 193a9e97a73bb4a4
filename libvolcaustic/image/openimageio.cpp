// The loadable module volcaustic_imageio: image files through OpenImageIO. Nothing of the library is linked into it.
#include "image/imageio_module.h"
#include "volcaustic/error.h"

#include <OpenImageIO/imageio.h>

namespace volcaustic {

namespace {

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

ImageFileHeader headerOf(const ImageSpec& spec) {
  ImageFileHeader header;
  header.width = spec.width;
  header.height = spec.height;
  header.depth = spec.depth;
  for (int c = 0; c < spec.nchannels; ++c) header.channels.push_back(spec.channel_name(c));
  header.alphaChannel = spec.alpha_channel;
  header.straightAlpha = spec.get_int_attribute("oiio:UnassociatedAlpha") != 0;
  header.deep = spec.deep;
  header.floatingPoint = spec.format.is_floating_point();
  if (spec.get_string_attribute("compression") == "none") header.uncompressedBytes = spec.image_bytes(true);
  for (const auto& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeString) header.metadata[attribute.name().string()] = attribute.get_string();
  return header;
}

std::vector<float> read(const std::string& path, const std::function<void(const ImageFileHeader&)>& accept) {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", 1);
  OIIO::attribute("openexr:core", 1); // the OpenEXR reader that keeps no pool of threads
  ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = ImageInput::open(path, &wanted);
  if (!input) throw Error(ErrorKind::Input, path + ": cannot be read as an image: " + OIIO::geterror());
  const ImageFileHeader header = headerOf(input->spec());
  accept(header);
  std::vector<float> pixels(std::size_t(header.width) * std::size_t(header.height) * header.channels.size());
  if (!input->read_image(0, 0, 0, static_cast<int>(header.channels.size()), TypeDesc::FLOAT, pixels.data()))
    throw Error(ErrorKind::Input, path + ": damaged: " + input->geterror());
  return pixels;
}

void write(const ImageFileTarget& target, const std::function<std::vector<float>(bool floatingPoint)>& pixels) {
  const auto output = ImageOutput::create(target.path);
  if (!output) {
    (void)OIIO::geterror(); // taken, so that it is not reported elsewhere
    throw Error(ErrorKind::Usage, target.path + ": no image format of this extension can be written; use .exr or .png");
  }
  ImageSpec spec(target.width, target.height, 3, target.prefersFloat ? TypeDesc::FLOAT : TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", target.prefersFloat ? "Linear" : "sRGB");
  for (const auto& [key, value] : target.metadata) spec.attribute(key, value);
  output->threads(1);
  const bool good = output->open(target.temporary, spec) &&
                    output->write_image(TypeDesc::FLOAT, pixels(output->spec().format.is_floating_point()).data()) &&
                    output->close();
  if (!good) throw Error(ErrorKind::File, target.path + ": cannot be written: " + output->geterror());
}

} // namespace

} // namespace volcaustic

extern "C" VOLCAUSTIC_API const volcaustic::ImageIo* volcausticImageIo() {
  static constexpr volcaustic::ImageIo kFunctions{VOLCAUSTIC_VERSION, volcaustic::read, volcaustic::write};
  return &kFunctions;
}
