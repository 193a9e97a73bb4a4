// The viewer: a scene, its pictures as they come, and a person or a script who changes it.
#pragma once

#include "option_widgets.h"
#include "script.h"
#include "window.h"

#include <volcaustic/error.h>
#include <volcaustic/live.h>
#include <volcaustic/scene.h>

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic::viewer {

struct ViewerOptions {
  std::filesystem::path scene;
  SceneReadOptions read;
  std::filesystem::path script; ///< empty for a person
  int width = 1360, height = 820;
  RunContext context;
};

/// What a hand can take hold of.
struct Grip {
  enum class Kind { None, Object, Light, Handle } kind = Kind::None;
  std::size_t object = 0; ///< or light
  std::size_t handle = 0; ///< a deformer of the object
  [[nodiscard]] bool operator==(const Grip&) const = default;
};

class App {
public:
  explicit App(ViewerOptions options);
  /// Until the window is closed or the script ends. \throws Error for what a script asks for and cannot be.
  void run();

private:
  using Clock = std::chrono::steady_clock;

  // app.cpp: scenes, pictures, files
  void setScene(Scene scene, bool oneStep);
  void showHistory(const Scene& scene);
  void undo();
  void redo();
  void goToFrame(int frame);
  void takeFrame();
  void uploadPicture();
  void uploadSlice();
  void say(std::string text);
  void fail(const Error& error);
  void endDrag();
  void saveScene(const std::filesystem::path& path);
  void exportTo(const std::filesystem::path& path);
  void saveScreenshot(const std::filesystem::path& path) const;

  // app_hand.cpp: mouse and keyboard
  void handleMouse();
  void handleKeys();
  [[nodiscard]] Grip gripAt(const Point& p);
  [[nodiscard]] std::optional<Vec3d> placeOf(const Grip& grip) const;
  static void move(Scene& scene, const Grip& grip, const Vec3d& shift);
  [[nodiscard]] const Mesh* surfaceOf(std::size_t object);
  [[nodiscard]] std::optional<Box> selectedBox();
  void drawOverlay();

  // app_panels.cpp
  void drawFrame();
  void drawPicture(const PictureArea& room);
  void drawPanel(float x, float width, float height);
  void drawToolbar();
  void drawLayers();
  void drawHistogram();
  void drawStages();
  void drawStatus(float y, float width, float height);

  // app_script.cpp
  /// The input of this frame; true while there are commands left.
  bool stepScript();
  bool runCommand(const ScriptCommand& command);
  void queueDrag(const ScriptCommand& command);

  ViewerOptions mOptions;
  Window mWindow;
  SceneHistory mHistory;
  std::unique_ptr<LiveSession> mLive;
  Session mSurfaces; ///< for triangles to pick
  std::shared_ptr<const LiveFrame> mShown;
  Texture mPicture, mSlicePicture;
  PictureArea mRoom, mArea; ///< for the picture, and of the picture in it
  std::uint64_t mRevision = 1;
  std::string mMessage, mDevice = "auto";
  Clock::time_point mMessageTime;
  std::deque<Clock::time_point> mPictureTimes; ///< of the last second

  std::string mLayer = "picture";
  bool mSliceShown = false, mOverlayShown = true, mPlaying = false;
  SliceOptions mSlice;
  VolumeSlice mSliceValues;
  SliceLook mSliceLook;
  double mIsovalue = -1; ///< below 0: none
  Mesh mIso;
  Histogram mHistogram;
  int mFrame = 1;
  Clock::time_point mFrameTime;

  Grip mSelected, mDragged;
  bool mOrbiting = false, mPanning = false, mEdited = false;
  std::optional<Scene> mDragStart; ///< the scene before a drag
  Point mDragFrom{}, mDragLast{};
  double mDragDepth = 1;
  std::vector<std::pair<std::string, std::shared_ptr<const Mesh>>> mPickable; ///< by what it was made from

  std::vector<ScriptCommand> mScript;
  std::size_t mCommand = 0;
  std::deque<ScriptedInput> mInputs; ///< of frames to come
  ScriptedInput mInput;
  int mIdleFrames = 0; ///< that the picture waited for has been shown
  int mFramesLeft = 0; ///< to pass before the next command
};

} // namespace volcaustic::viewer
