#include "mesh2vdb.h"

#include "frames.h"
#include "group_material.h"
#include "mesh_files.h"
#include "mesh_report.h"
#include "occupied_voxels.h"
#include "scene_input.h"

#include <volcaustic/mesh.h>
#include <volcaustic/session.h>
#include <volcaustic/shape_file.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>

namespace volcaustic::cli {

namespace {

/// One volume to make.
struct Conversion {
  std::string input, output;
  std::optional<int> frame;
};

/// An input and the volumes that it becomes: one, or one for each frame.
struct Sequence {
  std::string input;
  bool isShape = false, isScene = false;
  std::vector<Conversion> conversions;
};

bool isScene(const std::string& input) {
  const std::string extension = std::filesystem::path(input).extension().string();
  return input != "-" && !isShapeFile(input) &&
         (extension == ".json" || extension == ".volcaustic" || extension == ".gltf" || extension == ".glb");
}

Sequence sequenceOf(const MeshToVdb& o, const std::string& input, const std::string& output) {
  Sequence sequence{input, isShapeFile(input), isScene(input), {}};
  if (o.frames.empty()) {
    std::error_code ignored;
    if (hasFramePlace(output) || (hasFramePlace(input) && !std::filesystem::exists(input, ignored)))
      throw Error(ErrorKind::Usage,
                  (hasFramePlace(output) ? output : input) + ": has a place for a frame number; give --frames");
    sequence.conversions.push_back({input, output, {}});
    return sequence;
  }
  if (output == "-") throw Error(ErrorKind::Usage, "--frames: each frame needs a file; -o - is standard output");
  const bool isAnimated = sequence.isShape || sequence.isScene; // frames are in the file
  if (!isAnimated && !hasFramePlace(input))
    throw Error(ErrorKind::Usage,
                "--frames: " + input + " has no place for the frame's number; write it as name.####.obj");
  for (const int frame : parseFrames(o.frames))
    sequence.conversions.push_back(
        {isAnimated ? input : withFrame(input, frame), withFrame(framePattern(output), frame), frame});
  return sequence;
}

/// Everything that is wrong before a file is read.
std::vector<Sequence> plan(const MeshToVdb& o, bool json) {
  const std::vector<std::string> outputs = outputsFor(o.inputs, o.outputs, ".vdb", FileKind::Volume);
  if (json && outputs.front() == "-")
    throw Error(ErrorKind::Usage, "--json: standard output is taken by -o -; write to a file");
  std::vector<Sequence> sequences;
  for (std::size_t i = 0; i < o.inputs.size(); ++i) sequences.push_back(sequenceOf(o, o.inputs[i], outputs[i]));
  const auto shape = std::find_if(sequences.begin(), sequences.end(), [](const Sequence& s) { return s.isShape; });
  const auto scene = std::find_if(sequences.begin(), sequences.end(), [](const Sequence& s) { return s.isScene; });
  if (scene == sequences.end() && shape == sequences.end() && !o.scene.sets.empty())
    throw Error(ErrorKind::Usage, "--set: is for scenes and shapes, and there is none among the inputs");
  if (scene == sequences.end() && o.scene.framesPerSecond)
    throw Error(ErrorKind::Usage, "--fps: is for scenes, and there is none among the inputs");
  if (shape != sequences.end() && !o.groups.empty())
    throw Error(ErrorKind::Usage, "--group: is for meshes; make an object of a scene of each part of " + shape->input);
  if (scene != sequences.end())
    for (const CLI::Option* option : o.meshOptions)
      if (option->count() > 0)
        throw Error(ErrorKind::Usage, fmt::format("{}: {} says this itself; change it there, or with --set",
                                                  option->get_name(false, true), scene->input));
  return sequences;
}

Box united(const Box& a, const Box& b) {
  Box box = a;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::min(a.min[axis], b.min[axis]);
    box.max[axis] = std::max(a.max[axis], b.max[axis]);
  }
  return box;
}

bool holds(const Box& outer, const Box& inner) {
  const Box both = united(outer, inner);
  return both.min == outer.min && both.max == outer.max;
}

std::optional<Box> givenBounds(const LatticeOptions& o) {
  if (o.bounds.empty()) return std::nullopt;
  const Box box{{o.bounds[0], o.bounds[1], o.bounds[2]}, {o.bounds[3], o.bounds[4], o.bounds[5]}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(box.min[axis] < box.max[axis]))
      throw Error(ErrorKind::Usage, "--bounds: the first corner must be below the second one along every axis");
  return box;
}

class Converter {
public:
  Converter(Job& job, const MeshToVdb& options) : mJob(job), mOptions(options), mBounds(givenBounds(options.lattice)) {
    requirePhysical(options.material, "--scattering");
    for (const std::string& text : options.groups) mGroups.push_back(parseGroup(text, options.material));
  }

  void run(const std::vector<Sequence>& sequences) {
    for (const Sequence& sequence : sequences) mCount += sequence.conversions.size();
    for (const Sequence& sequence : sequences) {
      const bool oneLattice = !sequence.isScene && !mOptions.frames.empty() && !mBounds;
      const std::optional<Box> box = oneLattice ? boundsOfAll(sequence) : mBounds;
      std::optional<Session> session;
      for (const Conversion& conversion : sequence.conversions)
        convert(conversion, [&](Json& entry) {
          if (sequence.isScene) return sceneMedium(conversion, session, entry);
          return sequence.isShape ? shapeMedium(conversion, box, entry) : meshMedium(conversion, box, entry);
        });
    }
  }

private:
  /// The box of every frame, so that the voxels of all are the same; without one of them it would be another box, so an
  /// error of one ends the command.
  Box boundsOfAll(const Sequence& sequence) {
    return mJob.timed("bounds", [&] {
      std::optional<Box> all;
      for (const Conversion& conversion : sequence.conversions) {
        const auto index = static_cast<double>(&conversion - sequence.conversions.data());
        mJob.context().progress("bounds", index / static_cast<double>(sequence.conversions.size()));
        const Box box = sequence.isShape ? boundsOf(shapeOf(conversion), conversion.input)
                                         : bounds(readMesh(conversion.input, mJob.context()));
        all = all ? united(*all, box) : box;
      }
      return *all;
    });
  }

  template <class BuildMedium>
  void convert(const Conversion& conversion, BuildMedium&& build) {
    mJob.console().startFile(mStarted++, mCount);
    mJob.addInput(conversion.input);
    mJob.addOutput(conversion.output);
    Json entry = {{"input", conversion.input}, {"output", conversion.output}};
    if (conversion.frame) entry["frame"] = *conversion.frame;
    const std::size_t stagesBefore = mJob.report()["stages"].size();
    const bool skipped = mJob.skips(mOptions.resume, conversion.output);
    entry["skipped"] = skipped;
    if (!skipped) mJob.attempt(entry, [&] { write(conversion, build(entry), entry); });
    const Json& stages = mJob.report()["stages"];
    for (std::size_t i = stagesBefore; i < stages.size(); ++i)
      entry["ms"][stages[i]["stage"].get<std::string>()] = stages[i]["ms"];
    mJob.report()["counts"].push_back(std::move(entry));
  }

  Medium meshMedium(const Conversion& conversion, const std::optional<Box>& box, Json& entry) {
    const RunContext& ctx = mJob.context();
    const auto mesh = std::make_shared<const Mesh>(mJob.timed("read", [&] { return readMesh(conversion.input, ctx); }));
    entry["vertices"] = mesh->positions.size();
    entry["triangles"] = mesh->triangles.size();
    const std::vector<Body> bodies = bodiesOf(mesh, conversion.input);
    reportBodies(bodies, entry);
    if (mBounds && !holds(*mBounds, bounds(*mesh)))
      ctx.warn(conversion.input + ": sticks out of --bounds; what is outside is cut off");
    const Domain domain = latticeOver(box ? *box : bounds(*mesh), conversion.input);
    return mJob.timed("medium", [&] { return buildMedium(bodies, Ambient{}, domain, mOptions.voxelise, ctx); });
  }

  [[nodiscard]] Shape shapeOf(const Conversion& conversion) const {
    return readShape(conversion.input, {mOptions.scene.sets, static_cast<double>(conversion.frame.value_or(1))});
  }

  static Box boundsOf(const Shape& shape, const std::string& input) {
    Box box;
    try {
      box = ShapeField(shape).bounds();
    } catch (const Error& error) { // which knows no file
      throw Error(error.kind(), input + ": " + error.what());
    }
    if (box.min == box.max)
      throw Error(ErrorKind::Input, input + ": the shape has no inside; look at what is cut out of it");
    return box;
  }

  Medium shapeMedium(const Conversion& conversion, const std::optional<Box>& box, Json& entry) {
    const Shape shape = mJob.timed("read", [&] { return shapeOf(conversion); });
    entry["shapeHash"] = fmt::format("{:016x}", shapeHash(shape));
    const Box own = boundsOf(shape, conversion.input);
    if (mBounds && !holds(*mBounds, own))
      mJob.context().warn(conversion.input + ": sticks out of --bounds; what is outside is cut off");
    const Domain domain = latticeOver(box ? *box : own, conversion.input);
    const Body body{nullptr, mOptions.material, 0, conversion.input, shape};
    return mJob.timed("medium", [&] {
      return buildMedium(std::span(&body, 1), Ambient{}, domain, mOptions.voxelise, mJob.context());
    });
  }

  Domain latticeOver(const Box& box, const std::string& input) {
    const LatticeOptions& lattice = mOptions.lattice;
    try {
      return domainAround(box, lattice.resolution, lattice.voxelSize, lattice.padding);
    } catch (const Error& error) { // which knows no file
      throw Error(error.kind(), input + ": " + error.what());
    }
  }

  /// An unknown group is a slip of the command line, not a fault of the mesh.
  std::vector<Body> bodiesOf(const std::shared_ptr<const Mesh>& mesh, const std::string& name) {
    try {
      return bodiesByGroup(mesh, mOptions.material, 0, mGroups, name, mJob.context());
    } catch (const Error& error) {
      if (mGroups.empty() || error.kind() != ErrorKind::Input) throw;
      throw Error(ErrorKind::Usage, std::string("--group: ") + error.what());
    }
  }

  /// Whether somebody reads more than what is written where: the checks take as long as a coarse volume.
  [[nodiscard]] bool isReported() { return mJob.json() || mJob.console().isVerbose(); }

  void reportBodies(const std::vector<Body>& bodies, Json& entry) {
    if (!isReported()) return;
    mJob.timed("check", [&] {
      for (const Body& body : bodies) {
        const MeshReport report = checkMesh(*body.mesh, mJob.context());
        entry["bodies"].push_back(bodyReport(body, report));
        if (mJob.console().isVerbose()) sayBody(mJob.console(), body, report);
      }
    });
  }

  Medium sceneMedium(const Conversion& conversion, std::optional<Session>& session, Json& entry) {
    Scene scene = mJob.timed("read", [&] {
      return readSceneArgument(conversion.input, mOptions.scene.at(conversion.frame.value_or(1)),
                               session ? withoutWords(mJob.context()) : mJob.context());
    });
    entry["sceneHash"] = sceneHash(scene);
    entry["objects"] = scene.objects.size();
    if (session)
      session->setScene(std::move(scene));
    else
      session.emplace(std::move(scene), mJob.context());
    const std::size_t runsBefore = session->runs().size();
    const Medium& medium = session->medium();
    mJob.addStages(std::span(session->runs()).subspan(runsBefore));
    return medium;
  }

  void write(const Conversion& conversion, const Medium& medium, Json& entry) {
    VdbWriteOptions options = mOptions.write;
    if (conversion.frame) options.metadata["frame"] = std::to_string(*conversion.frame);
    if (entry.contains("sceneHash")) options.metadata["scene_hash"] = entry["sceneHash"].get<std::string>();
    mJob.timed("write", [&] { writeVdb(conversion.output, medium, options, mJob.context()); });
    const Domain& domain = medium.domain();
    entry["dims"] = domain.dims;
    entry["voxelSize"] = domain.voxelSize;
    std::string line = fmt::format("{}: {} x {} x {} voxels of {:.6g}", conversion.output, domain.dims[0],
                                   domain.dims[1], domain.dims[2], domain.voxelSize);
    if (entry.contains("triangles")) line += fmt::format(", from {} triangles", entry["triangles"].get<std::size_t>());
    if (isReported()) line += addFilling(medium, entry);
    if (conversion.output != "-") mJob.console().say(line);
  }

  /// How much of the voxels is filled, into the report and in words; a single closed body is held against its
  /// surface.
  static std::string addFilling(const Medium& medium, Json& entry) {
    const std::int64_t occupied = occupiedVoxels(medium);
    const double volume = coveredVolume(medium);
    entry["occupiedVoxels"] = occupied;
    entry["coveredVolume"] = volume;
    const std::string text = fmt::format("; {} occupied, covered volume {:.6g}", occupied, volume);
    if (!entry.contains("bodies") || entry["bodies"].size() != 1) return text;
    const Json& body = entry["bodies"][0];
    const double enclosed = std::abs(body["signedVolume"].get<double>());
    if (!body["closed"].get<bool>() || enclosed <= 0) return text;
    entry["volumeDifference"] = volume / enclosed - 1;
    return text + fmt::format(" ({:+.4f} % of the surface's)", 100 * (volume / enclosed - 1));
  }

  Job& mJob;
  const MeshToVdb& mOptions;
  const std::optional<Box> mBounds;
  std::vector<GroupMaterial> mGroups;
  std::size_t mStarted = 0, mCount = 0;
};

} // namespace

int runMeshToVdb(const MeshToVdb& options) {
  Job job("mesh2vdb", options.common);
  job.report()["counts"] = Json::array();
  const std::vector<Sequence> sequences = plan(options, job.json());
  Converter(job, options).run(sequences);
  job.finish();
  return job.status();
}

} // namespace volcaustic::cli
