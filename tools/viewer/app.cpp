#include "app.h"

#include <volcaustic/error.h>
#include <volcaustic/image.h>
#include <volcaustic/vdb.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace volcaustic::viewer {

namespace {

/// What has no name of its own is written by the name that a person gave it, as a whole or not at all.
void writeText(const std::filesystem::path& path, const std::string& text) {
  const std::filesystem::path beside = path.string() + ".part";
  std::error_code failed;
  {
    std::ofstream file(beside, std::ios::binary);
    file << text;
    if (!file.flush()) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) std::filesystem::rename(beside, path, failed);
  if (!failed) return;
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  throw Error(ErrorKind::File, path.string() + ": cannot be written; choose another name or folder");
}

/// With paths that lead to the same files from another folder.
Scene rebased(Scene scene, const std::filesystem::path& folder) {
  const std::filesystem::path to = std::filesystem::absolute(folder).lexically_normal();
  const auto rebase = [&](std::filesystem::path& path) {
    if (!path.empty()) path = std::filesystem::absolute(path).lexically_normal().lexically_proximate(to);
  };
  for (SceneObject& o : scene.objects) {
    rebase(o.meshFile);
    rebase(o.volumeFile);
  }
  for (SceneReceiver& r : scene.receivers) rebase(r.meshFile);
  rebase(scene.volume.file);
  rebase(scene.background.file);
  return scene;
}

} // namespace

App::App(ViewerOptions options)
    : mOptions(std::move(options))
    , mWindow(mOptions.width, mOptions.height, "volcaustic - " + mOptions.scene.filename().string())
    , mHistory(readScene(mOptions.scene, mOptions.read, mOptions.context))
    , mSurfaces(mHistory.current(), mOptions.context)
    , mDevice(mOptions.context.device)
    , mFrame(static_cast<int>(mOptions.read.frame)) {
  if (!mOptions.script.empty()) mScript = readScript(mOptions.script);
  mLive = std::make_unique<LiveSession>(mHistory.current(), LiveOptions{}, mOptions.context);
}

void App::run() {
  while (!mWindow.isClosed()) {
    const bool scripted = !mOptions.script.empty();
    if (scripted && !stepScript()) break;
    mWindow.beginFrame(scripted ? &mInput : nullptr);
    takeFrame();
    drawFrame();
    mWindow.endFrame();
    if (mPlaying && Clock::now() - mFrameTime > std::chrono::duration<double>(1 / mHistory.current().frames.rate))
      goToFrame(mFrame >= mHistory.current().frames.last ? mHistory.current().frames.first : mFrame + 1);
  }
}

/// What cannot be done ends a script, at its line; a person reads why and goes on.
void App::fail(const Error& error) {
  if (mOptions.script.empty()) return say(error.what());
  const std::size_t last = std::min(mCommand, mScript.size() - 1);
  throw Error(error.kind(), mOptions.script.string() + ":" + std::to_string(mScript[last].line) + ": " + error.what());
}

void App::say(std::string text) {
  mMessage = std::move(text);
  mMessageTime = Clock::now();
}

/// \param oneStep a step to undo of its own; else the scene takes the place of the latest one
void App::setScene(Scene scene, bool oneStep) {
  if (oneStep)
    mHistory.push(std::move(scene));
  else
    mHistory.replace(std::move(scene));
  showHistory(mHistory.current());
}

void App::showHistory(const Scene& scene) { mRevision = mLive->setScene(scene); }

void App::undo() {
  endDrag();
  showHistory(mHistory.undo());
}

void App::redo() {
  endDrag();
  showHistory(mHistory.redo());
}

void App::endDrag() {
  mDragStart.reset();
  mOrbiting = mPanning = mEdited = false;
}

void App::goToFrame(int frame) {
  mFrameTime = Clock::now();
  SceneReadOptions read = mOptions.read;
  read.frame = frame;
  try {
    Scene scene = readScene(mOptions.scene, read, mOptions.context);
    scene.camera = mHistory.current().camera; // a person looks from where she stands
    endDrag();
    setScene(std::move(scene), !mPlaying);
    mOptions.read = std::move(read);
    mFrame = frame;
  } catch (const Error& error) {
    mPlaying = false;
    fail(error);
  }
}

void App::takeFrame() {
  const auto now = Clock::now();
  while (!mPictureTimes.empty() && now - mPictureTimes.front() > std::chrono::seconds(1)) mPictureTimes.pop_front();
  const auto latest = mLive->latest();
  if (!latest || latest == mShown) return;
  mShown = latest;
  mPictureTimes.push_back(now);
  if (!mShown->error.empty()) say(mShown->error);
  if (!mShown->view) return;
  uploadPicture();
  if (mSliceShown) uploadSlice();
  if (mIsovalue >= 0) {
    SurfaceOptions surface;
    surface.automaticIsovalue = false;
    surface.isovalue = mIsovalue;
    surface.sharpen = false;
    try {
      mIso = surfaceFromMedium(*mShown->medium, surface, mOptions.context);
    } catch (const Error& error) {
      mIso = {};
      fail(error);
    }
  }
}

void App::uploadPicture() {
  if (!mShown || !mShown->view) return;
  const Image& image = mShown->view->image;
  mPicture.set(displayed(image, mLayer, mHistory.current().view.exposure), mShown->reduction == 1);
  if (mSliceShown) return;
  const std::string prefix = mLayer == "picture" ? "" : mLayer + ".";
  const int plane = std::max({image.find(prefix + "G"), image.find(prefix + "Z"), image.find(prefix + "Y")});
  if (plane >= 0) mHistogram = histogramOf(image.planes[plane], image.find(prefix + "G") >= 0);
}

void App::uploadSlice() {
  if (!mShown || !mShown->flat || !mShown->photons) return;
  mSliceValues = sliceVolume(*mShown->flat, *mShown->photons, mSlice);
  mSlicePicture.set(displayed(mSliceValues, mSlice.layer, mSliceLook), true);
  std::vector<float> values;
  values.reserve(mSliceValues.values.size());
  for (const Vec3f& v : mSliceValues.values) values.push_back(v[1]);
  mHistogram = histogramOf(values, isLight(mSlice.layer));
}

void App::saveScene(const std::filesystem::path& path) {
  writeText(path, sceneToJson(rebased(mHistory.current(), std::filesystem::absolute(path).parent_path())));
  say("saved " + path.string());
}

/// Of the scene as it is, not of a rough picture of it.
void App::exportTo(const std::filesystem::path& path) {
  const auto whole = mLive->wait(mRevision);
  if (!whole->error.empty()) throw Error(whole->errorKind, whole->error);
  const std::string extension = path.extension().string();
  if (extension == ".vdb" || extension == ".nvdb") {
    writeVdb(path, *whole->photons, *whole->medium, {}, mOptions.context);
  } else {
    ImageWriteOptions write;
    write.exposure = mHistory.current().view.exposure;
    writeImage(path, whole->view->image, write, mOptions.context);
  }
  say("exported " + path.string());
}

void App::saveScreenshot(const std::filesystem::path& path) const {
  const Pixels pixels = mWindow.pixels();
  if (pixels.width == 0) throw Error(ErrorKind::Usage, path.string() + ": nothing has been drawn yet; wait first");
  Image image;
  image.width = pixels.width;
  image.height = pixels.height;
  for (const char* channel : {"R", "G", "B"}) image.add(channel);
  for (std::size_t i = 0; i < image.planes[0].size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double v = pixels.rgba[4 * i + c] / 255.0; // back to linear, as writeImage takes it
      image.planes[c][i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
  writeImage(path, image, {}, mOptions.context);
}

} // namespace volcaustic::viewer
