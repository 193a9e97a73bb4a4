// The C interface on top of Session. Nothing that is thrown gets past a function of it.
#include "volcaustic_c.h"

#include <volcaustic/dense.h>
#include <volcaustic/error.h>
#include <volcaustic/image.h>
#include <volcaustic/session.h>
#include <volcaustic/vdb.h>
#include <volcaustic/view.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>
#include <set>
#include <string>
#include <utility>

using namespace volcaustic;

namespace {

thread_local std::string gMessage; // NOLINT: of the latest failure, by contract

volcaustic_status statusOf(ErrorKind kind) {
  switch (kind) {
  case ErrorKind::Usage:
    return VOLCAUSTIC_WRONG_USAGE;
  case ErrorKind::Input:
    return VOLCAUSTIC_BAD_INPUT;
  case ErrorKind::File:
    return VOLCAUSTIC_BAD_FILE;
  case ErrorKind::Device:
    return VOLCAUSTIC_NO_DEVICE;
  case ErrorKind::Cancelled:
    return VOLCAUSTIC_CANCELLED;
  case ErrorKind::Internal:
    break;
  }
  return VOLCAUSTIC_OUR_FAULT;
}

volcaustic_status fail(volcaustic_status status, const char* message) {
  try {
    gMessage = message;
    std::replace(gMessage.begin(), gMessage.end(), '\n', ' ');
  } catch (const std::bad_alloc&) {
    gMessage.clear();
  }
  return status;
}

template <class Body>
volcaustic_status guarded(Body&& body) {
  try {
    body();
    return VOLCAUSTIC_OK;
  } catch (const Error& error) {
    return fail(statusOf(error.kind()), error.what());
  } catch (const std::bad_alloc&) {
    return fail(VOLCAUSTIC_BAD_INPUT, "out of memory; lower the resolution or the number of photons");
  } catch (const std::exception& error) {
    return fail(VOLCAUSTIC_OUR_FAULT, error.what());
  } catch (...) {
    return fail(VOLCAUSTIC_OUR_FAULT, "unknown failure");
  }
}

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorKind::Usage, message); }

/// The struct as this library knows it: what an older host does not have is 0.
template <class Struct>
Struct whole(const Struct* given, const char* name) {
  Struct result{};
  if (!given) return result;
  if (given->size < sizeof given->size) refuse(std::string(name) + ".size: is not set; give sizeof of the struct");
  std::memcpy(&result, given, std::min(given->size, sizeof result));
  return result;
}

volcaustic_options checked(const volcaustic_options* given) {
  const volcaustic_options options = whole(given, "volcaustic_options");
  if (options.threads < 0 || options.threads > 4096)
    refuse("volcaustic_options.threads: is " + std::to_string(options.threads) + "; give 0 to 4096");
  return options;
}

std::string textOf(const char* text) { return text ? text : ""; }

Scene sceneAt(const volcaustic_scene& scene, double frame, const RunContext& ctx) {
  SceneReadOptions options;
  options.frame = frame;
  options.camera = textOf(scene.camera);
  for (std::size_t i = 0; i < scene.set_count; ++i) {
    if (!scene.sets || !scene.sets[i]) refuse("volcaustic_scene.sets: holds a null; give texts");
    options.sets.emplace_back(scene.sets[i]);
  }
  if (!scene.json) return readScene(scene.path, options, ctx);
  return parseScene(scene.json, scene.path ? scene.path : "scene", options);
}

Scene sceneOf(const volcaustic_scene* given, const RunContext& ctx) {
  const volcaustic_scene scene = whole(given, "volcaustic_scene");
  if (!scene.json && !scene.path) refuse("volcaustic_scene: has neither json nor path; give one");
  if (!(std::abs(scene.frame) <= 1e9)) refuse("volcaustic_scene.frame: is no frame; give a number up to 1e9");
  Scene at = sceneAt(scene, scene.frame, ctx);
  if (!scene.box_of_all || !at.volume.automatic || !at.volume.file.empty()) return at;
  Session session(at, ctx);
  at.volume.bounds =
      boxOfFrames(session, [&](int frame) { return sceneAt(scene, frame, ctx); }, {static_cast<int>(scene.frame)});
  at.volume.automatic = false;
  return at;
}

} // namespace

struct volcaustic_session {
  volcaustic_session(const volcaustic_scene* scene, const volcaustic_options& options)
      : host(options), session(sceneOf(scene, context()), context(), {.cache = textOf(options.cache)}) {
    host.device = host.cache = nullptr; // the host's to free
  }

  RunContext context() {
    RunContext ctx;
    ctx.threads = host.threads;
    ctx.seed = host.seed;
    ctx.memoryLimit = host.memory_limit;
    if (host.device) ctx.device = host.device;
    ctx.cancel = &cancel;
    if (host.progress)
      ctx.onProgress = [this](std::string_view stage, double fraction) {
        if (host.progress(host.user, std::string(stage).c_str(), fraction) != 0) cancel = stoppedByCall = true;
      };
    if (host.log)
      ctx.onLog = [this](LogLevel level, std::string_view line) {
        host.log(host.user, static_cast<std::int32_t>(level), std::string(line).c_str());
      };
    return ctx;
  }

  /// The same text for as long as the session lives.
  const char* kept(const std::string& name) { return names.insert(name).first->c_str(); }

  std::vector<GridSummary> grids(volcaustic_stage stage) {
    if (stage == VOLCAUSTIC_MEDIUM) return gridsOf(session.medium());
    if (stage == VOLCAUSTIC_PHOTONS) return gridsOf(lightsToCome());
    refuse("volcaustic_stage: has no grids; give VOLCAUSTIC_MEDIUM or VOLCAUSTIC_PHOTONS");
  }

  /// What the photons' result will say of its lights, before they are sent.
  PhotonResult lightsToCome() {
    PhotonResult result;
    if (session.scene().photons.separate)
      for (const std::string& name : lightLayers(session.scene().lights)) result.lights.emplace_back().light = name;
    return result;
  }

  volcaustic_options host;
  std::atomic<bool> cancel{false};
  std::atomic<bool> stoppedByCall{false}; ///< by the progress of the call that runs: not meant for the next
  std::atomic<bool> busy{false};
  std::set<std::string> names;
  Session session;
};

namespace {

template <class Body>
volcaustic_status call(volcaustic_session* session, Body&& body) {
  if (!session) return fail(VOLCAUSTIC_WRONG_USAGE, "session: is null; volcaustic_open() gives one");
  if (session->busy.exchange(true))
    return fail(VOLCAUSTIC_WRONG_USAGE, "session: is in a call; wait for its end, in callbacks too");
  const volcaustic_status status = guarded([&] {
    session->session.context().throwIfCancelled();
    body(session->session);
    if (session->stoppedByCall) session->session.context().throwIfCancelled();
  });
  if (status == VOLCAUSTIC_CANCELLED) session->cancel = session->stoppedByCall = false;
  session->busy = false;
  return status;
}

void writePicture(Session& session, const char* path, bool half) {
  checkLayers(path, session.viewChannels(), {});
  Image image = session.view().image;
  image.metadata.merge(cameraMetadata(session.scene().camera));
  ImageWriteOptions options;
  options.half = half;
  options.exposure = session.scene().view.exposure;
  writeImage(path, image, options, session.context());
}

} // namespace

std::uint32_t volcaustic_interface() { return VOLCAUSTIC_C_INTERFACE; }
const char* volcaustic_version() { return VOLCAUSTIC_VERSION; }
const char* volcaustic_message() { return gMessage.c_str(); }

volcaustic_session* volcaustic_open(const volcaustic_scene* scene, const volcaustic_options* options,
                                    volcaustic_status* status) {
  volcaustic_session* session = nullptr;
  const volcaustic_status result = guarded([&] { session = new volcaustic_session(scene, checked(options)); });
  if (status) *status = result;
  return session;
}

void volcaustic_close(volcaustic_session* session) { delete session; }

volcaustic_status volcaustic_set_scene(volcaustic_session* session, const volcaustic_scene* scene) {
  return call(session, [&](Session& s) { s.setScene(sceneOf(scene, s.context())); });
}

volcaustic_status volcaustic_frames(volcaustic_session* session, std::int32_t* first, std::int32_t* last,
                                    double* rate) {
  return call(session, [&](Session& s) {
    const SceneFrames& frames = s.scene().frames;
    if (first) *first = frames.first;
    if (last) *last = frames.last;
    if (rate) *rate = frames.rate;
  });
}

void volcaustic_cancel(volcaustic_session* session) {
  if (session) session->cancel = true;
}

volcaustic_status volcaustic_run(volcaustic_session* session, volcaustic_stage stage) {
  return call(session, [&](Session& s) {
    switch (stage) {
    case VOLCAUSTIC_MEDIUM:
      return void(s.medium());
    case VOLCAUSTIC_PHOTONS:
      return void(s.photons());
    case VOLCAUSTIC_VIEW:
      return void(s.view());
    }
    refuse("volcaustic_stage: there is no such stage; give one of the enumeration");
  });
}

size_t volcaustic_grid_count(volcaustic_session* session, volcaustic_stage stage) {
  size_t count = 0;
  call(session, [&](Session&) { count = session->grids(stage).size(); });
  return count;
}

volcaustic_status volcaustic_grid_at(volcaustic_session* session, volcaustic_stage stage, size_t index,
                                     volcaustic_grid* grid) {
  return call(session, [&](Session& s) {
    const std::vector<GridSummary> all = session->grids(stage);
    if (!grid || index >= all.size())
      refuse("volcaustic_grid_at: index " + std::to_string(index) + " of " + std::to_string(all.size()) +
             " grids, or nowhere to put it");
    const Domain& domain = s.medium().domain();
    grid->name = session->kept(all[index].name);
    grid->unit = session->kept(all[index].unit);
    grid->components = all[index].components;
    for (int a = 0; a < 3; ++a) {
      grid->dims[a] = domain.dims[a];
      grid->min_corner[a] = domain.minCorner[a];
    }
    grid->voxel_size = domain.voxelSize;
  });
}

volcaustic_status volcaustic_read_grid(volcaustic_session* session, volcaustic_stage stage, const char* name,
                                       const std::int32_t first[3], const std::int32_t size[3], float* out,
                                       size_t out_count) {
  return call(session, [&](Session& s) {
    if (!name || !first || !size || !out) refuse("volcaustic_read_grid: a pointer is null");
    const VoxelBox box{{first[0], first[1], first[2]}, {size[0], size[1], size[2]}};
    const std::span<float> values(out, out_count);
    if (stage == VOLCAUSTIC_MEDIUM)
      readVoxels(s.medium(), name, box, values, s.context());
    else if (stage == VOLCAUSTIC_PHOTONS)
      readVoxels(s.photons(), s.medium(), name, box, values, s.context());
    else
      refuse("volcaustic_stage: has no grids; give VOLCAUSTIC_MEDIUM or VOLCAUSTIC_PHOTONS");
  });
}

volcaustic_status volcaustic_picture_of(volcaustic_session* session, volcaustic_picture* picture) {
  return call(session, [&](Session& s) {
    if (!picture) refuse("volcaustic_picture_of: nowhere to put it");
    const auto [width, height] = s.scene().camera.resolution;
    *picture = {width, height, static_cast<std::int32_t>(s.viewChannels().size())};
  });
}

const char* volcaustic_channel(volcaustic_session* session, std::int32_t channel) {
  const char* name = nullptr;
  call(session, [&](Session& s) {
    const std::vector<std::string> channels = s.viewChannels();
    if (channel >= 0 && static_cast<std::size_t>(channel) < channels.size())
      name = session->kept(channels[static_cast<std::size_t>(channel)]);
  });
  return name;
}

volcaustic_status volcaustic_read_picture(volcaustic_session* session, float* out, size_t out_count) {
  return call(session, [&](Session& s) {
    const auto [width, height] = s.scene().camera.resolution;
    const std::size_t channels = s.viewChannels().size();
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (!out || out_count != pixels * channels)
      refuse("volcaustic_read_picture: the picture has " + std::to_string(pixels * channels) + " numbers, the array " +
             std::to_string(out ? out_count : 0));
    const Image& image = s.view().image;
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t p = 0; p < pixels; ++p) out[p * channels + c] = image.planes[c][p];
  });
}

volcaustic_status volcaustic_write(volcaustic_session* session, volcaustic_stage stage, const char* path,
                                   std::uint32_t flags) {
  return call(session, [&](Session& s) {
    if (!path || !*path) refuse("volcaustic_write: needs a path");
    if (flags & ~(VOLCAUSTIC_HALF | VOLCAUSTIC_PARTS)) refuse("volcaustic_write: unknown flags");
    const bool half = flags & VOLCAUSTIC_HALF;
    VdbWriteOptions options;
    options.half = half;
    options.parts = flags & VOLCAUSTIC_PARTS;
    options.metadata["scene_hash"] = sceneHash(s.scene());
    if (stage == VOLCAUSTIC_MEDIUM)
      writeVdb(path, s.medium(), options, s.context());
    else if (stage == VOLCAUSTIC_PHOTONS)
      writeVdb(path, s.photons(), s.medium(), options, s.context());
    else if (stage == VOLCAUSTIC_VIEW)
      writePicture(s, path, half);
    else
      refuse("volcaustic_stage: there is no such stage; give one of the enumeration");
  });
}
