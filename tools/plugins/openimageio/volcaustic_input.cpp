// OpenImageIO's format "volcaustic": scene files by the extension .volcaustic as pictures, one sub-image a frame, and
// with
// "?grid=NAME" grids of the first frame as 3-D images. Nothing is computed before pixels are asked for, but for the
// medium that says how large a grid is.
#include "host.h"

#include <charconv>
#include <map>
#include <memory>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <string>
#include <vector>

namespace volcaustic::plugin {

namespace {

/// "scene.volcaustic?grid=radiance&frame=3&photons.grid=[64,64]"
struct Request {
  std::string path, grid;
  std::vector<std::string> sets; ///< every argument with a dot in its name
  int frame = 0;
  bool oneFrame = false;
};

bool parse(const std::string& name, Request& request, std::string& error) {
  std::map<std::string, std::string> arguments;
  if (!OIIO::Strutil::get_rest_arguments(name, request.path, arguments)) {
    error = name + ": what follows the ? are pairs NAME=VALUE with & between them";
    return false;
  }
  if (request.path.empty()) request.path = name;
  for (const auto& [key, value] : arguments) {
    if (key == "grid") {
      request.grid = value;
    } else if (key == "frame") {
      request.oneFrame = true;
      const char* end = value.data() + value.size();
      if (const auto read = std::from_chars(value.data(), end, request.frame);
          read.ec != std::errc() || read.ptr != end) {
        error = name + ": frame=" + value + ": is no number of a frame";
        return false;
      }
    } else if (key.find('.') != std::string::npos) {
      request.sets.push_back(key + "=" + value);
    } else {
      error = name + ": " + key + ": is neither grid, frame nor a place in the scene, as photons.grid";
      return false;
    }
  }
  return true;
}

struct CloseSession {
  const Host* host;
  void operator()(volcaustic_session* session) const { host->close(session); }
};

} // namespace

class VolcausticInput final : public OIIO::ImageInput {
public:
  [[nodiscard]] const char* format_name() const override { return "volcaustic"; }
  [[nodiscard]] int supports(OIIO::string_view feature) const override { return feature == "multiimage"; }
  [[nodiscard]] bool valid_file(const std::string& name) const override {
    return OIIO::Filesystem::extension(name) == ".volcaustic" && OIIO::Filesystem::is_regular(name);
  }

  bool open(const std::string& name, OIIO::ImageSpec& spec) override {
    close();
    std::string error;
    mHost = host(error);
    if (!mHost) return refuse(name + ": needs volcaustic itself: " + error);
    if (!parse(name, mRequest, error)) return refuse(error);
    return openScene() && seek_subimage(0, 0) && (spec = m_spec, true);
  }

  [[nodiscard]] int current_subimage() const override { return mSubimage; }

  bool seek_subimage(int subimage, int miplevel) override {
    const lock_guard lock(*this);
    if (!mSession || miplevel != 0 || subimage < 0 || subimage >= mCount) return false;
    if (subimage == mSubimage) return true;
    const int frame = mFirst + subimage;
    if (frame != mFrame && !setFrame(frame)) return false;
    if (!(mRequest.grid.empty() ? describePicture() : describeGrid())) return false;
    m_spec.attribute("oiio:subimagename", "frame " + std::to_string(frame));
    m_spec.attribute("Frame", frame);
    m_spec.attribute("FramesPerSecond", static_cast<float>(mRate));
    mSubimage = subimage;
    mPixels.clear();
    return true;
  }

  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override {
    const lock_guard lock(*this);
    if (!seek_subimage(subimage, miplevel) || (mPixels.empty() && !compute())) return false;
    if (y < 0 || y >= m_spec.height || z < 0 || z >= m_spec.depth) return false;
    const std::size_t row = static_cast<std::size_t>(m_spec.width) * static_cast<std::size_t>(m_spec.nchannels);
    const float* from =
        mPixels.data() + (static_cast<std::size_t>(z) * static_cast<std::size_t>(m_spec.height) + y) * row;
    std::copy(from, from + row, static_cast<float*>(data));
    return true;
  }

  bool close() override {
    mSession.reset();
    mPixels = {};
    mSubimage = -1;
    mRequest = {};
    return true;
  }

private:
  bool refuse(const std::string& message) {
    errorfmt("{}", message);
    return false;
  }
  bool refuseByHost() { return refuse(mHost->message()); }

  volcaustic_scene scene(double frame) {
    mSets.clear();
    for (const std::string& set : mRequest.sets) mSets.push_back(set.c_str());
    volcaustic_scene scene{};
    scene.size = sizeof scene;
    scene.path = mRequest.path.c_str();
    scene.sets = mSets.data();
    scene.set_count = mSets.size();
    scene.frame = frame;
    scene.box_of_all = !mRequest.oneFrame;
    return scene;
  }

  bool openScene() {
    // One number is not known before the scene is read: its first frame.
    volcaustic_scene at = scene(mRequest.oneFrame ? mRequest.frame : 1);
    at.box_of_all = 0;
    mSession = {mHost->open(&at, nullptr, nullptr), CloseSession{mHost}};
    if (!mSession || mHost->frames(mSession.get(), &mFirst, &mLast, &mRate) != VOLCAUSTIC_OK) return refuseByHost();
    mFrame = mFirst - 1; // set anew, with the box of all frames
    if (mRequest.oneFrame) mFirst = mLast = mFrame = mRequest.frame;
    if (mFirst == mLast && mFirst == 1) mFrame = 1;
    mCount = mLast - mFirst + 1;
    return true;
  }

  bool setFrame(int frame) {
    const volcaustic_scene at = scene(frame);
    if (mHost->setScene(mSession.get(), &at) != VOLCAUSTIC_OK) return refuseByHost();
    mFrame = frame;
    return true;
  }

  bool describePicture() {
    volcaustic_picture picture{};
    if (mHost->pictureOf(mSession.get(), &picture) != VOLCAUSTIC_OK) return refuseByHost();
    m_spec = OIIO::ImageSpec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::FLOAT);
    m_spec.channelnames.clear();
    for (int c = 0; c < picture.channels; ++c) m_spec.channelnames.emplace_back(mHost->channel(mSession.get(), c));
    for (int c = 0; c < picture.channels; ++c) {
      if (m_spec.channelnames[c] == "A") m_spec.alpha_channel = c;
      if (m_spec.channelnames[c] == "depth.Z") m_spec.z_channel = c;
    }
    m_spec.attribute("oiio:ColorSpace", "Linear");
    return true;
  }

  bool describeGrid() {
    for (const volcaustic_stage stage : {VOLCAUSTIC_MEDIUM, VOLCAUSTIC_PHOTONS}) {
      const std::size_t count = mHost->gridCount(mSession.get(), stage);
      if (count == 0) return refuseByHost();
      for (std::size_t i = 0; i < count; ++i) {
        volcaustic_grid grid{};
        if (mHost->gridAt(mSession.get(), stage, i, &grid) != VOLCAUSTIC_OK) return refuseByHost();
        if (mRequest.grid == grid.name) {
          mStage = stage;
          describe(grid);
          return true;
        }
      }
    }
    return refuse(mRequest.path + ": grid=" + mRequest.grid + ": there is no such grid; try radiance or index");
  }

  void describe(const volcaustic_grid& grid) {
    m_spec = OIIO::ImageSpec(grid.dims[0], grid.dims[1], grid.components, OIIO::TypeDesc::FLOAT);
    m_spec.depth = m_spec.full_depth = grid.dims[2];
    if (grid.components == 1) m_spec.channelnames = {grid.name};
    m_spec.attribute("oiio:ColorSpace", "Linear");
    m_spec.attribute("unit", grid.unit);
    m_spec.attribute("voxelSize", static_cast<float>(grid.voxel_size));
    const float corner[] = {static_cast<float>(grid.min_corner[0]), static_cast<float>(grid.min_corner[1]),
                            static_cast<float>(grid.min_corner[2])};
    m_spec.attribute("minCorner", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC3, OIIO::TypeDesc::POINT),
                     corner);
  }

  bool compute() {
    std::vector<float> pixels(m_spec.image_pixels() * static_cast<std::size_t>(m_spec.nchannels));
    const std::int32_t first[] = {0, 0, 0}, size[] = {m_spec.width, m_spec.height, m_spec.depth};
    const volcaustic_status status =
        mRequest.grid.empty()
            ? mHost->readPicture(mSession.get(), pixels.data(), pixels.size())
            : mHost->readGrid(mSession.get(), mStage, mRequest.grid.c_str(), first, size, pixels.data(), pixels.size());
    if (status != VOLCAUSTIC_OK) return refuseByHost();
    mPixels = std::move(pixels);
    return true;
  }

  const Host* mHost = nullptr;
  Request mRequest;
  std::vector<const char*> mSets;
  std::unique_ptr<volcaustic_session, CloseSession> mSession{nullptr, CloseSession{nullptr}};
  volcaustic_stage mStage = VOLCAUSTIC_PHOTONS;
  std::int32_t mFirst = 1, mLast = 1;
  double mRate = 24;
  int mFrame = 1, mCount = 1, mSubimage = -1;
  std::vector<float> mPixels; ///< of the current sub-image, once they are asked for
};

} // namespace volcaustic::plugin

OIIO_PLUGIN_EXPORTS_BEGIN

OIIO_EXPORT int volcaustic_imageio_version = OIIO_PLUGIN_VERSION;
OIIO_EXPORT const char* volcaustic_imageio_library_version() { return "volcaustic " VOLCAUSTIC_VERSION; }
OIIO_EXPORT OIIO::ImageInput* volcaustic_input_imageio_create() { return new volcaustic::plugin::VolcausticInput; }
OIIO_EXPORT const char* volcaustic_input_extensions[] = {"volcaustic", nullptr};

OIIO_PLUGIN_EXPORTS_END
