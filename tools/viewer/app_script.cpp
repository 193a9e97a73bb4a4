// Commands of a script: each goes through the same mouse, keys and functions as a person's hand.
#include "app.h"

#include <volcaustic/error.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <GLFW/glfw3.h>
#include <map>

namespace volcaustic::viewer {

namespace {

constexpr int kDragSteps = 12;

int buttonOf(const std::vector<std::string>& words, std::size_t i) {
  static const std::map<std::string, int> kButtons{{"left", 0}, {"right", 1}, {"middle", 2}};
  if (words.size() <= i) return 0;
  const auto found = kButtons.find(words[i]);
  if (found == kButtons.end())
    throw Error(ErrorKind::Usage, "'" + words[i] + "' is no button; there are left, right, middle");
  return found->second;
}

VolumeLayer volumeLayer(const std::string& word) {
  static const std::map<std::string, VolumeLayer> kLayers{
      {"radiance", VolumeLayer::Radiance}, {"caustic", VolumeLayer::Caustic},
      {"direct", VolumeLayer::Direct},     {"direction", VolumeLayer::Direction},
      {"index", VolumeLayer::Index},       {"attenuation", VolumeLayer::Attenuation},
      {"step", VolumeLayer::Step},         {"energy", VolumeLayer::Energy}};
  const auto found = kLayers.find(word);
  if (found != kLayers.end()) return found->second;
  throw Error(ErrorKind::Usage, "'" + word +
                                    "' is no layer of the volume; there are radiance, caustic, direct, direction, "
                                    "index, attenuation, step, energy");
}

} // namespace

/// Takes commands until one has made input for frames to come, or has to wait.
bool App::stepScript() {
  if (mInputs.empty()) {
    mInput.wheel = 0;
    mInput.keys.clear();
  }
  if (mFramesLeft > 0) {
    --mFramesLeft;
    return true;
  }
  while (mInputs.empty() && mFramesLeft == 0 && mCommand < mScript.size()) {
    const ScriptCommand& command = mScript[mCommand];
    bool done = false;
    try {
      done = runCommand(command);
    } catch (const Error& error) {
      fail(error);
    }
    if (!done) return true; // again in the next frame
    ++mCommand;
    if (mWindow.isClosed()) return false;
  }
  if (!mInputs.empty()) {
    mInput = mInputs.front();
    mInputs.pop_front();
    return true;
  }
  return mFramesLeft > 0 || mCommand < mScript.size();
}

void App::queueDrag(const ScriptCommand& c) {
  const auto& a = c.arguments;
  const Point from{numberOf(a[0]), numberOf(a[1])}, to{numberOf(a[2]), numberOf(a[3])};
  const int button = buttonOf(a, 4);
  ScriptedInput input;
  for (int i = -1; i <= kDragSteps; ++i) {
    const double t = std::max(i, 0) / double(kDragSteps);
    input.mouse = Point{from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t};
    input.buttons[static_cast<std::size_t>(button)] = i >= 0;
    mInputs.push_back(input);
  }
  input.buttons = {};
  mInputs.push_back(input);
  mInputs.push_back(input);
}

/// False when it has to wait.
bool App::runCommand(const ScriptCommand& c) {
  const auto& a = c.arguments;
  const auto queue = [&](auto&& change) {
    ScriptedInput input = mInput;
    change(input);
    mInputs.push_back(input);
  };
  const bool failed = mShown && mShown->revision >= mRevision && !mShown->error.empty();
  if (failed && (c.name == "wait" || c.name == "layer")) throw Error(mShown->errorKind, mShown->error);
  if (c.name == "wait") {
    if (!a.empty()) return mShown && mShown->revision >= mRevision && ++mIdleFrames > 2 && !(mIdleFrames = 0);
    // One frame more, so that what has come is on the screen.
    if (mLive->busy() || mShown != mLive->latest() || ++mIdleFrames < 3) return false;
    mIdleFrames = 0;
  } else if (c.name == "frames") {
    mFramesLeft = static_cast<int>(numberOf(a[0]));
  } else if (c.name == "move") {
    queue([&](ScriptedInput& input) { input.mouse = Point{numberOf(a[0]), numberOf(a[1])}; });
  } else if (c.name == "press") {
    queue([&](ScriptedInput& input) { input.buttons[static_cast<std::size_t>(buttonOf(a, 0))] = true; });
  } else if (c.name == "release") {
    queue([](ScriptedInput& input) { input.buttons = {}; });
  } else if (c.name == "drag") {
    queueDrag(c);
  } else if (c.name == "click") {
    queueDrag({c.line, "drag", {a[0], a[1], a[0], a[1]}});
  } else if (c.name == "scroll") {
    queue([&](ScriptedInput& input) { input.wheel = numberOf(a[0]); });
    queue([](ScriptedInput& input) { input.wheel = 0; });
  } else if (c.name == "key") {
    const bool control = a[0].starts_with("ctrl+");
    const std::string letter = control ? a[0].substr(5) : a[0];
    if (letter.size() != 1 && letter != "space")
      throw Error(ErrorKind::Usage, "'" + a[0] + "' is no key; write a letter, ctrl+letter or space");
    const int key = letter == "space" ? GLFW_KEY_SPACE : std::toupper(static_cast<unsigned char>(letter[0]));
    queue([&](ScriptedInput& input) { input.keys = {{key, control}}; });
    queue([](ScriptedInput& input) { input.keys.clear(); });
  } else if (c.name == "set") {
    SceneReadOptions read;
    read.sets = {a[0]};
    setScene(parseScene(sceneToJson(mHistory.current()), "", read), true);
  } else if (c.name == "select") {
    const auto& objects = mHistory.current().objects;
    const auto found =
        std::find_if(objects.begin(), objects.end(), [&](const SceneObject& o) { return o.name == a[0]; });
    if (found == objects.end()) throw Error(ErrorKind::Usage, "no object is called '" + a[0] + "'");
    mSelected = {Grip::Kind::Object, static_cast<std::size_t>(found - objects.begin())};
  } else if (c.name == "layer") {
    if (!mShown || !mShown->view) return false;
    const auto layers = layersOf(mShown->view->image);
    if (std::find(layers.begin(), layers.end(), a[0]) == layers.end())
      throw Error(ErrorKind::Usage, "the picture has no layer '" + a[0] + "'");
    mLayer = a[0];
    uploadPicture();
  } else if (c.name == "slice") {
    mSliceShown = a[0] != "off";
    if (mSliceShown) {
      mSlice.layer = volumeLayer(a[0]);
      if (a.size() > 1) {
        if (a[1].size() != 1 || a[1][0] < 'x' || a[1][0] > 'z')
          throw Error(ErrorKind::Usage, "'" + a[1] + "' is no axis; there are x, y, z");
        mSlice.axis = a[1][0] - 'x';
      }
      if (a.size() > 2) mSlice.position = numberOf(a[2]);
    }
    mSliceShown ? uploadSlice() : uploadPicture();
  } else if (c.name == "iso") {
    mIsovalue = a[0] == "off" ? -1 : numberOf(a[0]);
    mShown.reset();
  } else if (c.name == "frame") {
    goToFrame(static_cast<int>(numberOf(a[0])));
  } else if (c.name == "device") {
    mRevision = mLive->setDevice(mDevice = a[0]);
  } else if (c.name == "screenshot") {
    saveScreenshot(a[0]);
  } else if (c.name == "save") {
    saveScene(a[0]);
  } else if (c.name == "export") {
    exportTo(a[0]);
  } else if (c.name == "undo") {
    undo();
  } else if (c.name == "redo") {
    redo();
  } else if (c.name == "quit") {
    mWindow.close();
  }
  return true;
}

} // namespace volcaustic::viewer
