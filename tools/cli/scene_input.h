// Scenes from files or standard input, and checks that need the file system.
#pragma once

#include "common.h"

#include <volcaustic/scene.h>
#include <volcaustic/session.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace volcaustic::cli {

/// How a scene is read, but for the frame.
struct SceneFlags {
  std::vector<std::string> sets;
  std::string camera{};
  std::optional<double> framesPerSecond{};

  [[nodiscard]] SceneReadOptions at(double frame) const { return {sets, frame, camera, framesPerSecond}; }
};

/// --set, and --fps for commands that take frames.
void addSceneFlags(CLI::App& command, SceneFlags& flags, bool hasFrames);

/// readScene, where "-" is standard input and holds JSON.
Scene readSceneArgument(const std::string& path, const SceneReadOptions& options, const RunContext& ctx);

/// For the frames after the first: the same without its words, which were said before.
RunContext withoutWords(RunContext ctx);

/// `scene mesh`, under the command `scene`.
void addSceneMeshCommand(CLI::App& scene, Action& action);

/// A warning for each visible object whose deformation makes it run through itself, where nothing is done about it.
void warnOfSelfIntersections(Job& job, Session& session);

} // namespace volcaustic::cli
