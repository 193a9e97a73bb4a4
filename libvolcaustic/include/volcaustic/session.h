/// \file session.h
/// A scene and the stages that turn it into volumes and pictures; only stages that a change touches run again.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/run_context.h"
#include "volcaustic/scene.h"
#include "volcaustic/view.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic {

struct FlatMediumStorage; // the medium as the kernels read it

/// One run of one stage. Stages, in order: "surface" of each object that is deformed or triangulated, "medium",
/// "stepField", "photons", "view".
struct StageRun {
  std::string stage;
  std::string key; ///< hash of the stage's inputs and described options
  double milliseconds = 0;
  /// What differs from the inputs of the latest result before: places of the scene as "lights/0/direction", files that
  /// changed, stages that ran. Empty for the first run. Beyond 16 places the last line says how many more.
  std::vector<std::string> because;
  bool fromDisk = false; ///< read from SessionOptions::cache instead of computed
};

/// Whether a stage would run, were its result asked for now.
struct StagePlan {
  std::string stage;
  bool runs = false;                ///< false: its result is there
  std::vector<std::string> because; ///< as of StageRun; also of a result that is there from an earlier scene
};

struct SessionOptions {
  /// Results that each stage keeps, the ones asked for last: with more than one, going back to an earlier scene (undo)
  /// costs nothing. With one, the old result is freed before the next is made.
  int results = 1;
  /// A folder for results of photons and views, by their keys, which outlives the session; empty for none. Its
  /// files are whole or not there, may be deleted at any time, and are read only by the version that wrote them.
  std::filesystem::path cache{};
};

/// Holds a scene and the latest results of each stage, keyed by a hash of everything the stage depends on. A moved
/// camera re-runs only the view, a light photons and view, a mesh everything. A stage that throws (Error(Cancelled),
/// say) leaves all results as they were before it, but for the
/// one that SessionOptions::results gives up.
class VOLCAUSTIC_API Session {
public:
  explicit Session(Scene scene, RunContext ctx = {}, SessionOptions options = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  [[nodiscard]] const Scene& scene() const;
  void setScene(Scene scene);
  [[nodiscard]] const RunContext& context() const;
  /// Another seed or device makes photons and view anew; the rest of a context changes nothing that is there.
  void setContext(RunContext ctx);

  /// Each runs what is missing, in order, and returns the result, which lives until the stage runs again.
  const Medium& medium();
  const PhotonResult& photons();
  /// The observer sees the passes of a view that runs, and is not called for one that is there.
  const ViewResult& view(const ViewObserver& observer = {});
  /// The same results, for whoever keeps them longer.
  std::shared_ptr<const Medium> sharedMedium();
  std::shared_ptr<const FlatMediumStorage> sharedFlat();
  std::shared_ptr<const PhotonResult> sharedPhotons();
  std::shared_ptr<const ViewResult> sharedView(const ViewObserver& observer = {});

  /// The triangles of object `i` as they stand in the world: deformed, its topology controlled, placed; of a shape its
  /// triangulation, whether or not the medium is made of it. \throws Error(Usage) for an object that is a volume.
  std::shared_ptr<const Mesh> surface(std::size_t i);
  /// Around everything visible, without the margin; nothing where there is nothing, as before the smoke begins.
  std::optional<Box> contentBox();
  /// The scene's background with its map, which is read again when the file has changed.
  const Background& background();
  /// The channels of view()'s picture, known before anything has run. \throws Error(Usage) as lightLayers does.
  [[nodiscard]] std::vector<std::string> viewChannels() const;
  /// Takes a radiance volume from elsewhere (readRadiance) in place of the photon stage.
  void setRadiance(RadianceVolume radiance);

  /// What view() would run, stage by stage, and why. Reads files whose contents are part of a key; runs nothing.
  [[nodiscard]] std::vector<StagePlan> plan();
  /// Every stage run so far, in order.
  [[nodiscard]] const std::vector<StageRun>& runs() const;

private:
  struct State;
  std::unique_ptr<State> mState;
};

/// Gives an animation's scenes, which differ from frame to frame.
using SceneAtFrame = std::function<Scene(int frame)>;

/// The automatic box of a whole animation. One that followed what is in it would take the voxels along, and what stands
/// still would flicker. Frames: those of the first scene's `frames` section, where it has more than one, else those
/// that are wanted. Scenes that are equal are looked at once; `session` holds one of them afterwards.
/// \throws Error(Input) where there is nothing in any frame.
VOLCAUSTIC_API Box boxOfFrames(Session& session, const SceneAtFrame& sceneAt, std::vector<int> wanted);

/// Scenes in the order in which a person made them.
class VOLCAUSTIC_API SceneHistory {
public:
  /// Keeps at most `depth` scenes to go back to.
  explicit SceneHistory(Scene first, std::size_t depth = 200) : mScenes{std::move(first)}, mDepth(depth) {}

  [[nodiscard]] const Scene& current() const { return mScenes[mCurrent]; }
  /// Puts a scene behind the current one; what was undone is forgotten.
  void push(Scene scene);
  /// Takes the place of the current one: the steps of one drag are one change.
  void replace(Scene scene) { mScenes[mCurrent] = std::move(scene); }
  [[nodiscard]] bool canUndo() const { return mCurrent > 0; }
  [[nodiscard]] bool canRedo() const { return mCurrent + 1 < mScenes.size(); }
  /// The scene before or after, which becomes the current one; the same where there is none.
  const Scene& undo();
  const Scene& redo();

private:
  std::vector<Scene> mScenes;
  std::size_t mCurrent = 0, mDepth;
};

} // namespace volcaustic
