// trace and render: photons to a radiance volume, and the picture of it.
#include "common.h"
#include "file_kind.h"
#include "frames.h"
#include "option_flags.h"
#include "scene_input.h"

#include <volcaustic/image.h>
#include <volcaustic/scene.h>
#include <volcaustic/session.h>
#include <volcaustic/usd.h>
#include <volcaustic/vdb.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <span>
#include <utility>

namespace volcaustic::cli {

namespace {

/// What trace and render share: a scene, changes to it, and the frames of it.
struct SceneRun {
  std::string scene;
  std::vector<std::string> outputs;
  SceneFlags flags;
  std::string frames;
  bool resume = false;
  std::string cache;
  std::string lightMaps;
};

void declareSceneRun(CLI::App& command, SceneRun& o, const char* outputText) {
  command.add_option("SCENE", o.scene, "scene file (.json, .gltf, .glb), or - for JSON on standard input")->required();
  command.add_option("-o,--output", o.outputs, outputText)->required()->allow_extra_args(false);
  addSceneFlags(command, o.flags, true);
  command.add_option("--frames", o.frames, "A-B[xS]: one file a frame, its number in the place of #### or %04d in OUT");
  command.add_flag("--resume", o.resume, "skip frames whose files are there");
  command.add_option("--cache", o.cache,
                     "folder to keep the light and the pictures of scenes in, and to take them from; may be deleted at "
                     "any time");
  command.add_option(
      "--light-maps", o.lightMaps,
      "folder for the irradiance on each receiver as RECEIVER.exr (RECEIVER.0001.exr with --frames); of a "
      "mesh with an .obj that has the texture coordinates");
}

std::vector<int> framesOf(const SceneRun& o) { return o.frames.empty() ? std::vector<int>{1} : parseFrames(o.frames); }

/// The files of a frame.
std::vector<std::string> outputsAt(const SceneRun& o, int frame) {
  std::vector<std::string> outputs;
  for (const std::string& output : o.outputs)
    outputs.push_back(o.frames.empty() ? output : withFrame(framePattern(output), frame));
  return outputs;
}

/// Calls body(frame, outputs of it) for each frame that is wanted. Without --frames the one frame is the first.
template <class Body>
void forEachFrame(Job& job, const SceneRun& o, FileKind kind, Body&& body) {
  const bool many = !o.frames.empty();
  for (const std::string& output : o.outputs) checkOutput(output, kind);
  for (const std::string& output : o.outputs)
    if (!many && hasFramePlace(output))
      throw Error(ErrorKind::Usage, "--output " + output + ": has a place for a frame number; give --frames");
  const std::vector<int> frames = framesOf(o);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int frame = frames[i];
    job.console().startFile(i, frames.size());
    const std::vector<std::string> outputs = outputsAt(o, frame);
    const bool whole =
        std::all_of(outputs.begin(), outputs.end(), [](const auto& f) { return std::filesystem::exists(f); });
    for (const std::string& output : outputs) job.addOutput(output);
    Json result = {{"frame", frame}, {"outputs", outputs}, {"skipped", o.resume && whole}};
    if (o.resume && whole)
      job.console().say(fmt::format("frame {}: is there, skipped", frame));
    else
      body(frame, outputs, result);
    if (many)
      job.report()["frames"].push_back(std::move(result));
    else
      job.report().update(result);
  }
}

/// A session that takes one scene after the other, so that only what differs runs again.
class FrameSession {
public:
  FrameSession(Job& job, const SceneRun& options) : mJob(job), mOptions(options) { mJob.addInput(options.scene); }

  Session& at(int frame, Json& result) {
    Scene scene = mJob.timed("read", [&] { return read(frame); });
    result["sceneHash"] = sceneHash(scene);
    if (scene.volume.automatic && scene.volume.file.empty() && !mOptions.frames.empty()) {
      if (!mSession) take(scene);
      const auto at = [&](int wanted) { return read(wanted); };
      if (!mBox) mBox = mJob.timed("box of all frames", [&] { return boxOfFrames(*mSession, at, framesOf(mOptions)); });
      scene.volume.automatic = false;
      scene.volume.bounds = *mBox;
    }
    take(std::move(scene));
    const std::vector<StagePlan> plan = mSession->plan();
    if (std::any_of(plan.begin(), plan.end(), [](const StagePlan& s) { return s.stage == "medium" && s.runs; }))
      warnOfSelfIntersections(mJob, *mSession);
    return *mSession;
  }

  /// Adds the stages that ran since the last call to the report, and says why when there is time for words.
  void reportStages() {
    const std::span<const StageRun> runs = std::span(mSession->runs()).subspan(mReported);
    mJob.addStages(runs);
    for (const StageRun& run : runs)
      mJob.context().log(LogLevel::Detail,
                         fmt::format("{}: {:.1f} ms{}{}{}", run.stage, run.milliseconds,
                                     run.fromDisk ? ", from the cache" : "",
                                     run.because.empty() ? "" : "; changed: ", fmt::join(run.because, ", ")));
    mReported = mSession->runs().size();
  }

private:
  Scene read(int frame) {
    return readSceneArgument(mOptions.scene, mOptions.flags.at(frame),
                             std::exchange(mHasRead, true) ? withoutWords(mJob.context()) : mJob.context());
  }

  void take(Scene scene) {
    if (mSession)
      mSession->setScene(std::move(scene));
    else
      mSession.emplace(std::move(scene), mJob.context(), SessionOptions{.cache = mOptions.cache});
  }

  Job& mJob;
  const SceneRun& mOptions;
  bool mHasRead = false;
  std::optional<Session> mSession;
  std::optional<Box> mBox; ///< of all frames, where it is automatic
  std::size_t mReported = 0;
};

/// The table of the energy balance, and warnings about photons that did not end as they should.
void sayBalance(Job& job, const EnergyBalance& b, int maxSteps) {
  const auto row = [&](const char* name, const Rgb& watts) {
    job.console().say(fmt::format("  {:<20} {:>14.7g} {:>14.7g} {:>14.7g}", name, watts[0], watts[1], watts[2]));
  };
  job.console().say(fmt::format("energy balance [W] {:>17} {:>14} {:>14}", "R", "G", "B"));
  row("emitted", b.emitted);
  row("absorbed", b.absorbed);
  row("scattered out", b.scattered);
  row("left the box", b.escaped);
  row("landed on receivers", b.received);
  row("cut off", b.cutOff);
  job.console().say(fmt::format("  relative imbalance {:>16.2e}", b.relativeImbalance()));
  job.console().say(
      fmt::format("photons: {} emitted, {} traced in {} steps", b.photonsEmitted, b.photonsTraced, b.steps));
  if (b.photonsAtStepLimit > 0)
    job.context().warn(
        fmt::format("{} photons were cut off after {} steps; raise photons.maxSteps", b.photonsAtStepLimit, maxSteps));
  if (b.photonsNotFinite > 0)
    job.context().warn(fmt::format("{} photons left the finite numbers and were dropped", b.photonsNotFinite));
}

void addPhotons(Job& job, const Session& session, const PhotonResult& photons, Json& result) {
  const EnergyBalance& balance = photons.balance;
  sayBalance(job, balance, session.scene().photons.maxSteps);
  result["sumsBytes"] = photons.sumsBytes;
  for (const PassPart& part : photons.parts) result["photonParts"][part.name] = part.ms;
  result["counts"] = photonCounts(balance);
  result["energyBalance"] = energyReport(balance);
  for (const PhotonResult& light : photons.lights) result["lights"][light.light] = energyReport(light.balance);
}

/// Makes the folder, before the photons are sent.
void prepareLightMaps(const SceneRun& o, const Session& session) {
  if (o.lightMaps.empty()) return;
  if (session.scene().receivers.empty())
    throw Error(ErrorKind::Usage, "--light-maps: the scene has no receivers; add one to /receivers");
  std::error_code failed;
  std::filesystem::create_directories(o.lightMaps, failed);
  if (failed)
    throw Error(ErrorKind::File, o.lightMaps + ": cannot be made: " + failed.message() + "; choose another folder");
}

void writeLightMaps(Job& job, const SceneRun& o, int frame, const PhotonResult& photons,
                    const std::map<std::string, std::string>& metadata) {
  if (o.lightMaps.empty()) return;
  for (ReceiverMap& map : photons.receivers.maps()) {
    const std::string file = (std::filesystem::path(o.lightMaps) / (map.name + ".exr")).string();
    const std::string output = o.frames.empty() ? file : withFrame(framePattern(file), frame);
    map.image.metadata.insert(metadata.begin(), metadata.end());
    ImageWriteOptions write;
    write.half = false;
    job.timed("write", [&] { writeReceiverMap(output, map, write, job.context()); });
    job.console().say(output + ": written");
  }
}

std::map<std::string, std::string> fileMetadata(const Job& job, const Json& result, int frame) {
  return {{"scene_hash", result.at("sceneHash").get<std::string>()},
          {"frame", std::to_string(frame)},
          {"seed", std::to_string(job.context().seed)}};
}

struct Trace {
  CommonOptions common;
  SceneRun run;
  VdbWriteOptions write;
  std::string usd;
  UsdWriteOptions stage;
  bool givenUpAxis = false; ///< else the camera's
};

void declareTrace(CLI::App& command, Trace& o) {
  declareSceneRun(command, o.run, "the radiance volume, .vdb or .nvdb, or - for standard output");
  command.get_option("--output")->expected(1);
  addFlags(command, o.write);
  command.add_option("--usd", o.usd, "also a stage for OpenUSD (.usda) that names the volumes of all frames");
  addFlags(command, o.stage, {{"metersPerUnit", "upAxis"}, {}});
  command.get_option("--up-axis")
      ->description("of the world, in stages; y, z; default: as the camera's `up`")
      ->each([&o](const std::string&) { o.givenUpAxis = true; });
}

/// What would only be seen after the photons.
void checkStage(const Trace& o) {
  if (o.usd.empty()) return;
  if (std::filesystem::path(o.usd).extension() != ".usda")
    throw Error(ErrorKind::Usage, "--usd " + o.usd + ": is a stage in text; name it by .usda");
  if (std::filesystem::path(o.run.outputs.front()).extension() != ".vdb")
    throw Error(ErrorKind::Usage, "--usd: OpenUSD reads volumes from .vdb files; write -o NAME.vdb");
  checkFolderOf(o.usd);
}

void writeStage(Job& job, const Trace& o, const Scene& scene) {
  std::vector<UsdFrame> frames;
  for (const int frame : framesOf(o.run)) frames.push_back({frame, outputsAt(o.run, frame).front()});
  UsdWriteOptions options = o.stage;
  const Vec3d& up = scene.camera.up;
  if (!o.givenUpAxis) options.upAxis = std::abs(up[1]) > std::abs(up[2]) ? UpAxis::Y : UpAxis::Z;
  options.rate = scene.frames.rate;
  job.timed("stage", [&] { writeUsd(o.usd, frames, options, job.context()); });
  job.addOutput(o.usd);
  job.console().say(o.usd + ": written");
}

int runTrace(const Trace& o) {
  Job job("trace", o.common);
  job.tracesPhotons();
  checkStage(o);
  if (job.json() && o.run.outputs.front() == "-")
    throw Error(ErrorKind::Usage, "--json: standard output is taken by -o -; write to a file");
  FrameSession frames(job, o.run);
  forEachFrame(job, o.run, FileKind::Volume, [&](int frame, const std::vector<std::string>& outputs, Json& result) {
    Session& session = frames.at(frame, result);
    prepareLightMaps(o.run, session);
    const PhotonResult& photons = session.photons();
    frames.reportStages();
    addPhotons(job, session, photons, result);
    VdbWriteOptions write = o.write;
    write.metadata = fileMetadata(job, result, frame);
    job.timed("write", [&] { writeVdb(outputs.front(), photons, session.medium(), write, job.context()); });
    if (outputs.front() != "-") job.console().say(outputs.front() + ": written");
    writeLightMaps(job, o.run, frame, photons, write.metadata);
  });
  if (!o.usd.empty())
    writeStage(job, o,
               readSceneArgument(o.run.scene, o.run.flags.at(framesOf(o.run).front()), withoutWords(job.context())));
  job.finish();
  return 0;
}

struct Render {
  CommonOptions common;
  SceneRun run;
  std::string radiance;
  bool fullFloat = false;
  std::optional<double> exposure; ///< the scene's when not given
  ImageWriteOptions write;
};

void declareRender(CLI::App& command, Render& o) {
  declareSceneRun(command, o.run,
                  "picture: .exr with every layer, or .png and other formats, tone-mapped; again for more");
  command.add_option("--camera", o.run.flags.camera, "camera of a glTF file, by name; the first if not given");
  command.add_option("--radiance", o.radiance,
                     "radiance volume of an earlier trace, instead of sending photons; with ####, one for each frame");
  command.add_flag("--float", o.fullFloat, "32-bit floats in .exr files");
  addFlags(command, o.write, {{"layers", "compression", "tiles", "tone", "bits", "alpha"}, {}});
  command
      .add_option("--exposure", o.exposure,
                  "brightness of 8- and 16-bit files [stops]; default: view.exposure of the scene")
      ->check(CLI::Range(-40.0, 40.0));
}

void writePictures(Job& job, const Render& o, const ViewResult& view, const Session& session,
                   const std::vector<std::string>& outputs, const std::map<std::string, std::string>& metadata) {
  Image image = view.image;
  image.metadata.insert(metadata.begin(), metadata.end());
  image.metadata.merge(cameraMetadata(session.scene().camera));
  image.metadata["device"] = job.device();
  for (const StageRun& run : session.runs())
    image.metadata["ms_" + run.stage] = fmt::format("{:.3f}", run.milliseconds);
  ImageWriteOptions write = o.write;
  write.half = !o.fullFloat;
  write.exposure = o.exposure.value_or(session.scene().view.exposure);
  for (const std::string& output : outputs) {
    job.timed("write", [&] { writeImage(output, image, write, job.context()); });
    job.console().say(output + ": written");
  }
}

int runRender(const Render& o) {
  Job job("render", o.common);
  if (o.radiance.empty()) job.tracesPhotons();
  if (!o.radiance.empty() && !o.run.lightMaps.empty())
    throw Error(ErrorKind::Usage, "--light-maps: nothing lands on receivers with --radiance; leave one of them out");
  FrameSession frames(job, o.run);
  if (!o.radiance.empty()) job.addInput(o.radiance);
  forEachFrame(job, o.run, FileKind::Image, [&](int frame, const std::vector<std::string>& outputs, Json& result) {
    Session& session = frames.at(frame, result);
    if (!o.radiance.empty())
      session.setRadiance(job.timed("read", [&] {
        const std::string file = o.run.frames.empty() ? o.radiance : withFrame(o.radiance, frame);
        return readRadiance(file, session.medium().domain(), job.context());
      }));
    // What cannot be written or read is known before the photons are sent.
    prepareLightMaps(o.run, session);
    for (const std::string& output : outputs) checkLayers(output, session.viewChannels(), o.write.layers);
    session.background();
    if (o.radiance.empty()) addPhotons(job, session, session.photons(), result);
    const ViewResult& view = session.view();
    frames.reportStages();
    result["counts"].update(
        {{"viewSteps", view.steps}, {"raysAtStepLimit", view.raysAtStepLimit}, {"raysNotFinite", view.raysNotFinite}});
    if (view.raysAtStepLimit > 0)
      job.context().warn(fmt::format("{} rays were cut off after {} steps; raise view.maxSteps", view.raysAtStepLimit,
                                     session.scene().view.maxSteps));
    writePictures(job, o, view, session, outputs, fileMetadata(job, result, frame));
    if (o.radiance.empty()) writeLightMaps(job, o.run, frame, session.photons(), fileMetadata(job, result, frame));
  });
  job.finish();
  return 0;
}

} // namespace

void addRenderCommands(CLI::App& app, Action& action) {
  addCommand<Trace>(app, action, "trace", "photons: a scene's light as a radiance volume", declareTrace, runTrace);
  addCommand<Render>(app, action, "render", "photons and camera: a scene as a picture", declareRender, runRender);
}

} // namespace volcaustic::cli
