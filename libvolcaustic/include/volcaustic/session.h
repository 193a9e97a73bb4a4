/// \file session.h
/// A scene and the stages that turn it into volumes and pictures; only stages that a change touches run again.
#pragma once

#include "volcaustic/export.h"
#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/run_context.h"
#include "volcaustic/scene.h"
#include "volcaustic/view.h"

#include <memory>
#include <string>
#include <vector>

namespace volcaustic {

/// One run of one stage.
struct StageRun {
  std::string stage; ///< "medium", "photons" or "view"
  std::string key;   ///< hash of the stage's inputs and described options
  double milliseconds = 0;
};

/// Holds a scene and the latest result of each stage, keyed by a hash of everything the stage depends on. A moved
/// camera re-runs only the view, a light photons and view, a mesh everything; setting an earlier scene again costs
/// nothing when its results are still the latest.
class VOLCAUSTIC_API Session {
public:
  explicit Session(Scene scene, RunContext ctx = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  [[nodiscard]] const Scene& scene() const;
  void setScene(Scene scene);

  /// Each runs what is missing, in order, and returns the result, which lives until the stage runs again.
  const Medium& medium();
  const PhotonResult& photons();
  /// The observer sees the passes of a view that runs, and is not called for one that is there.
  const ViewResult& view(const ViewObserver& observer = {});
  /// The scene's background with its map, which is read again when the file has changed.
  const Background& background();
  /// The channels of view()'s picture, known before anything has run. \throws Error(Usage) as lightLayers does.
  [[nodiscard]] std::vector<std::string> viewChannels() const;
  /// Takes a radiance volume from elsewhere (readRadiance) in place of the photon stage.
  void setRadiance(RadianceVolume radiance);

  /// Every stage run so far, in order.
  [[nodiscard]] const std::vector<StageRun>& runs() const;

private:
  struct State;
  std::unique_ptr<State> mState;
};

} // namespace volcaustic
