// simulate: motion that is computed here, as keys of a scene or as a sequence of volumes.
#include "common.h"
#include "file_kind.h"
#include "frames.h"
#include "option_flags.h"
#include "scene_bodies.h"
#include "scene_input.h"
#include "simulated_scene.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace volcaustic::cli {

namespace {

constexpr const char* kFramesText = "A-B[xS]: the frames; default 1-48";

struct SimulateMixing {
  CommonOptions common;
  std::string output;
  std::string frames = "1-48";
  bool resume = false;
  MixingOptions options;
};

void declareMixing(CLI::App& command, SimulateMixing& o) {
  command.add_option("-o,--output", o.output, "OUT.####.vdb, the frame's number in the place of #### or %04d")
      ->required();
  command.add_option("--frames", o.frames, kFramesText);
  command.add_flag("--resume", o.resume,
                   "keep the frames that are there; the flow is computed again up to the first that is not");
  addFlags(command, o.options);
}

int runMixing(const SimulateMixing& o) {
  Job job("simulate mixing", o.common);
  if (o.output == "-")
    throw Error(ErrorKind::Usage, "--output -: a sequence is no single file; give a name with #### for the frame");
  checkOutput(o.output, FileKind::Volume);
  struct Wanted {
    int frame;
    std::string file;
  };
  std::vector<Wanted> missing;
  for (const int frame : parseFrames(o.frames)) {
    const std::string file = withFrame(framePattern(o.output), frame);
    const bool there = job.skips(o.resume, file);
    job.addOutput(file);
    job.report()["frames"].push_back({{"frame", frame}, {"outputs", {file}}, {"skipped", there}});
    if (!there) missing.push_back({frame, file});
  }
  if (!missing.empty()) {
    MixingSimulation flow(o.options, job.context());
    for (const Wanted& wanted : missing) {
      while (flow.frame() < wanted.frame) job.timed("flow", [&] { flow.advance(); });
      job.timed("write", [&] { flow.write(wanted.file); });
      job.console().say(fmt::format("{}: written; divergence {:.1e}", wanted.file, flow.divergence()));
    }
  }
  job.finish();
  return 0;
}

struct SimulateBodies {
  CommonOptions common;
  std::string scene, output;
  std::string frames = "1-48";
  const CLI::Option* rate = nullptr; ///< whose default is the scene's
  std::vector<std::string> fixed, velocity, spin, density, friction, restitution;
  RigidBodyOptions options;
};

void declareBodies(CLI::App& command, SimulateBodies& o) {
  command.add_option("SCENE", o.scene, "scene file (.json, .gltf, .glb)")->required();
  command.add_option("-o,--output", o.output, "the scene with keys for what moves, .json")->required();
  command.add_option("--frames", o.frames, "A-B: the frames; default 1-48");
  const auto named = [&](const char* flag, std::vector<std::string>& values, const char* form, const char* text) {
    command.add_option(flag, values, text)->allow_extra_args(false)->option_text(form);
  };
  named("--fixed", o.fixed, "NAME", "an object that stays where it is; receivers do. Again for more, as all of these");
  named("--velocity", o.velocity, "NAME=X,Y,Z", "at the first frame [world/s]; default 0");
  named("--spin", o.spin, "NAME=X,Y,Z", "angular velocity at the first frame, about world axes [degrees/s]; default 0");
  named("--density", o.density, "NAME=NUMBER", "mass per volume, of which ratios matter; default 1");
  named("--friction", o.friction, "NAME=NUMBER", "of a pair of bodies the product counts; default 0.7");
  named("--restitution", o.restitution, "NAME=NUMBER",
        "part of the speed that is left after a collision, 0 to 1; of a pair the product; default 0.5");
  addFlags(command, o.options);
  o.rate = command.get_option("--rate");
}

void applySettings(const SimulateBodies& o, std::span<SceneBody> bodies) {
  for (const std::string& name : o.fixed) bodies[bodyNamed("--fixed", name, bodies)].body.fixed = true;
  const auto requireMoving = [&](const char* flag, const std::string& text, const SceneBody& body) {
    if (body.body.fixed)
      throw Error(ErrorKind::Usage, fmt::format("{} {}: is fixed; leave that out, or let it move", flag, text));
  };
  const auto numbers = [&](const char* flag, const std::vector<std::string>& values, double RigidBody::*member) {
    for (const std::string& text : values) {
      const NamedNumbers given = namedNumbers(flag, text, 1, bodies);
      if (member == &RigidBody::density) requireMoving(flag, text, bodies[given.body]);
      bodies[given.body].body.*member = given.numbers.front();
    }
  };
  const auto vectors = [&](const char* flag, const std::vector<std::string>& values, Vec3d RigidBody::*member) {
    for (const std::string& text : values) {
      const NamedNumbers given = namedNumbers(flag, text, 3, bodies);
      requireMoving(flag, text, bodies[given.body]);
      bodies[given.body].body.*member = {given.numbers[0], given.numbers[1], given.numbers[2]};
    }
  };
  vectors("--velocity", o.velocity, &RigidBody::velocity);
  vectors("--spin", o.spin, &RigidBody::spin);
  numbers("--density", o.density, &RigidBody::density);
  numbers("--friction", o.friction, &RigidBody::friction);
  numbers("--restitution", o.restitution, &RigidBody::restitution);
}

/// What moved, as keys.
std::vector<ObjectKeys> keysOf(std::span<const SceneBody> bodies,
                               const std::vector<std::vector<Placement>>& placements) {
  std::vector<ObjectKeys> keys;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].body.fixed) continue;
    keys.push_back({bodies[i].object, {}});
    for (const std::vector<Placement>& frame : placements) keys.back().placements.push_back(frame[i]);
  }
  return keys;
}

int runBodies(const SimulateBodies& o) {
  Job job("simulate bodies", o.common);
  if (std::filesystem::path(o.output).extension() != ".json")
    throw Error(ErrorKind::Usage, "--output " + o.output + ": is a scene; end its name in .json");
  checkOutput(o.output, FileKind::Scene);
  RigidBodyOptions options = o.options;
  const std::vector<int> frames = parseFrames(o.frames);
  if (frames.back() - frames.front() + 1 != static_cast<int>(frames.size()))
    throw Error(ErrorKind::Usage, "--frames " + o.frames + ": leaves frames out; give A-B without a step");
  job.addInput(o.scene);
  SceneReadOptions read;
  read.frame = frames.front();
  if (isGltfName(o.scene)) {
    read.framesPerSecond = options.framesPerSecond;
    job.context().warn(o.scene + ": what its animation moves stands as in the first frame; bodies alone get keys");
  }
  const Scene scene = job.timed("read", [&] { return readScene(o.scene, read, job.context()); });
  if (o.rate->count() == 0) options.framesPerSecond = scene.frames.rate;
  std::vector<SceneBody> bodies = job.timed("surfaces", [&] { return sceneBodies(scene, job.context()); });
  applySettings(o, bodies);
  std::vector<RigidBody> rigid;
  for (const SceneBody& body : bodies) rigid.push_back(body.body);
  const auto placements = job.timed(
      "bodies", [&] { return simulateRigidBodies(rigid, static_cast<int>(frames.size()), options, job.context()); });
  const std::vector<ObjectKeys> keys = keysOf(bodies, placements);
  if (keys.empty()) job.context().warn("nothing moves: every object is fixed, a volume or not visible");
  writeJson(o.output, withKeys(o.scene, scene, o.output, frames, options.framesPerSecond, keys));
  job.addOutput(o.output);
  job.report()["moving"] = keys.size();
  job.report()["fixed"] = bodies.size() - keys.size();
  job.console().say(fmt::format("{}: written; {} bodies move, {} are fixed, {} frames", o.output, keys.size(),
                                bodies.size() - keys.size(), frames.size()));
  job.finish();
  return 0;
}

} // namespace

void addSimulateCommands(CLI::App& app, Action& action) {
  CLI::App* simulate =
      app.add_subcommand("simulate", "motion: rigid bodies as keys of a scene, the mixing of two fluids as volumes");
  simulate->require_subcommand(1);
  addCommand<SimulateMixing>(*simulate, action, "mixing",
                             "a jet of one fluid into another: concentration and velocity, a .vdb for each frame",
                             declareMixing, runMixing);
  addCommand<SimulateBodies>(*simulate, action, "bodies", "objects of a scene that fall, roll and collide",
                             declareBodies, runBodies);
}

} // namespace volcaustic::cli
