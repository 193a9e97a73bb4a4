/// \file live.h
/// A session on a thread of its own, for windows: rough pictures at once while something moves, finer ones at rest.
#pragma once

#include "volcaustic/error.h"
#include "volcaustic/export.h"
#include "volcaustic/scene.h"
#include "volcaustic/session.h"
#include "volcaustic/slice.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace volcaustic {

struct LiveOptions {
  double frameMs = 60;       ///< a rough picture may take so long; its reduction is chosen by what the ones before took
  int greatestReduction = 8; ///< along each axis; a power of two
};

/// A picture of a scene at a reduction, and all that it was made from. Immutable.
struct LiveFrame {
  std::uint64_t revision = 0; ///< of the scene, as setScene() returned it
  Scene scene;                ///< as it was set
  /// Pixels along each axis were divided by it, and photons and voxels (these by 4 at most) where the change asks for
  /// new light; 1 is the scene as it is.
  int reduction = 1;
  std::shared_ptr<const Medium> medium;
  std::shared_ptr<const FlatMediumStorage> flat; ///< the medium as the kernels read it (sliceVolume)
  std::shared_ptr<const PhotonResult> photons;
  std::shared_ptr<const ViewResult> view;
  std::vector<StageRun> runs; ///< that made it
  double milliseconds = 0;    ///< from the start of its first stage
  std::string error;          ///< one line, when a stage failed: then the results are those of the picture before
  ErrorKind errorKind = ErrorKind::Internal; ///< of `error`
};

/// The latest scene wins: setScene() returns at once, a refinement that runs is cancelled, a rough picture is finished
/// so that there is always something to see. At rest the reduction is halved until it is 1. All functions may be called
/// from any thread.
class VOLCAUSTIC_API LiveSession {
public:
  /// `ctx.cancel` ends wait() only. \throws Error(Usage) for options out of range.
  explicit LiveSession(Scene scene, LiveOptions options = {}, RunContext ctx = {});
  /// Cancels what runs and waits for its end.
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// The revision of this scene: 1 for the constructor's, then 2, 3, ...
  std::uint64_t setScene(Scene scene);
  /// Where photons and pixels are computed from now on, as RunContext::device. Counts as a new revision.
  std::uint64_t setDevice(std::string device);

  /// The latest picture; null before the first.
  [[nodiscard]] std::shared_ptr<const LiveFrame> latest() const;
  /// Waits for a picture of at least `revision` and at most `reduction`, or an error of that revision.
  /// \throws Error(Cancelled)
  [[nodiscard]] std::shared_ptr<const LiveFrame> wait(std::uint64_t revision, int reduction = 1) const;
  /// False when the latest picture is the latest scene at reduction 1.
  [[nodiscard]] bool busy() const;
  /// The stage that runs and the part of it that is done, for a progress bar; empty and 0 at rest.
  [[nodiscard]] std::pair<std::string, double> progress() const;

private:
  struct State;
  std::unique_ptr<State> mState;
};

} // namespace volcaustic
