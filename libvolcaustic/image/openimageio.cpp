// The loadable module volcaustic_imageio: image files through OpenImageIO. Nothing of the library is linked into it.
#include "image/imageio_module.h"
#include "volcaustic/error.h"

#include <locale>
#include <memory>
#include <OpenImageIO/imageio.h>
#include <sstream>

namespace volcaustic {

namespace {

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

/// Attributes that are numbers in the file and text in an Image.
constexpr const char* kNumbers[] = {"worldToCamera", "worldToNDC", "screenWindowWidth", "pixelAspectRatio"};

/// What tells of the file rather than of the picture.
bool isOfTheFile(const std::string& name) {
  return name == "compression" || name == "planarconfig" || name.starts_with("oiio:") || name.starts_with("openexr:") ||
         name.starts_with("tiff:") || name.starts_with("png:") || name.starts_with("jpeg:");
}

std::map<std::string, std::string> metadataOf(const ImageSpec& spec) {
  std::map<std::string, std::string> metadata;
  for (const auto& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    if (attribute.type() == OIIO::TypeString && !isOfTheFile(name))
      metadata[name == "Software" ? "software" : name] = attribute.get_string();
  }
  for (const char* name : kNumbers) {
    const OIIO::ParamValue* found = spec.find_attribute(name); // upper or lower case
    if (!found || found->type().basetype != TypeDesc::FLOAT) continue;
    if (found->type() == TypeDesc::FLOAT && found->get_float() == 1) continue; // as where nothing is said
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(9);
    const auto* numbers = static_cast<const float*>(found->data());
    for (std::size_t i = 0; i < found->type().basevalues(); ++i) text << (i == 0 ? "" : " ") << numbers[i];
    metadata[name] = text.str();
  }
  return metadata;
}

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
  if (const OIIO::ParamValue* primaries = spec.find_attribute("chromaticities");
      primaries && primaries->type().basetype == TypeDesc::FLOAT && primaries->type().numelements() == 8)
    for (int i = 0; i < 8; ++i) header.chromaticities.push_back(primaries->get_float_indexed(i));
  header.metadata = metadataOf(spec);
  return header;
}

std::unique_ptr<ImageInput> open(const std::string& path) {
  ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  auto input = ImageInput::open(path, &wanted);
  if (!input) throw Error(ErrorKind::Input, path + ": cannot be read as an image: " + OIIO::geterror());
  return input;
}

/// Opens with the OpenEXR reader that keeps no pool of threads, but for what that of OpenEXR 3.1 cannot decode.
std::unique_ptr<ImageInput> openWithFewThreads(const std::string& path) {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1); // none besides the caller's
  OIIO::attribute("openexr:core", 1);
  auto input = open(path);
  if (!std::string(input->spec().get_string_attribute("compression")).starts_with("dwa")) return input;
  OIIO::attribute("openexr:core", 0);
  return open(path);
}

std::vector<float> read(const std::string& path, const std::function<void(const ImageFileHeader&)>& accept) {
  const auto input = openWithFewThreads(path);
  const ImageFileHeader header = headerOf(input->spec());
  accept(header);
  std::vector<float> pixels(std::size_t(header.width) * std::size_t(header.height) * header.channels.size());
  if (!input->read_image(0, 0, 0, static_cast<int>(header.channels.size()), TypeDesc::FLOAT, pixels.data()))
    throw Error(ErrorKind::Input, path + ": damaged: " + input->geterror());
  return pixels;
}

int bitsOf(const ImageSpec& spec) {
  return spec.format.is_floating_point() ? 32 : spec.format == TypeDesc::UINT8 ? 8 : 16;
}

void write(const ImageFileTarget& target,
           const std::function<std::vector<float>(const ImageFileFormat& format)>& pixels) {
  const auto output = ImageOutput::create(target.path);
  if (!output) {
    (void)OIIO::geterror(); // taken, so that it is not reported elsewhere
    throw Error(ErrorKind::Usage, target.path + ": no image format of this extension can be written; use .exr or .png");
  }
  const bool alpha = target.alpha && output->supports("alpha");
  const TypeDesc type = target.bits == 32 ? TypeDesc::FLOAT : target.bits == 16 ? TypeDesc::UINT16 : TypeDesc::UINT8;
  ImageSpec spec(target.width, target.height, target.colours + (alpha ? 1 : 0), type);
  if (alpha) {
    spec.alpha_channel = target.colours;
    spec.channelnames.back() = "A";
  }
  for (const auto& [key, value] : target.metadata)
    if (key != "software" && key != "colorInteropID") spec.attribute(key, value);
  spec.attribute("Software", "volcaustic " VOLCAUSTIC_VERSION);
  spec.attribute("oiio:ColorSpace", target.bits == 32 ? "Linear" : "sRGB");
  if (alpha && target.bits != 32) spec.attribute("oiio:UnassociatedAlpha", 1);
  output->threads(1);
  const bool open = output->open(target.temporary, spec);
  const bool good =
      open && output->write_image(TypeDesc::FLOAT, pixels({bitsOf(output->spec()), alpha}).data()) && output->close();
  if (!good) throw Error(ErrorKind::File, target.path + ": cannot be written: " + output->geterror());
}

} // namespace

} // namespace volcaustic

extern "C" VOLCAUSTIC_API const volcaustic::ImageIo* volcausticImageIo() {
  static constexpr volcaustic::ImageIo kFunctions{VOLCAUSTIC_VERSION, volcaustic::read, volcaustic::write};
  return &kFunctions;
}
