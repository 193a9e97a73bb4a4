// Sessions: a scene and the stages that turn it into volumes and pictures.
#include "arrays.h"
#include "light_handle.h"
#include "scene_handle.h"
#include "view_result.h"

#include <volcaustic/error.h>
#include <volcaustic/session.h>
#include <volcaustic/slice.h>

namespace volcaustic::python {

namespace {

/// The scene is Python's: each call takes it as it is then. Calls from several threads take turns.
class SessionHandle {
public:
  SessionHandle(std::shared_ptr<SceneHandle> scene, const py::kwargs& given) : mScene(std::move(scene)) {
    Keywords keywords("Session()", given);
    SessionOptions options;
    keywords("results", options.results, FieldDoc{"of each stage that are kept", "", 1, 1e6});
    keywords("cache", options.cache, FieldDoc{"folder that outlives the session"});
    mCall = std::make_unique<Call>(keywords);
    keywords.finish();
    mSession = std::make_unique<Session>(plainScene(*mScene), mCall->context(), std::move(options));
  }

  [[nodiscard]] const std::shared_ptr<SceneHandle>& scene() const { return mScene; }
  void setScene(std::shared_ptr<SceneHandle> scene) {
    plainScene(*present(scene));
    mScene = std::move(scene);
  }
  [[nodiscard]] const RunContext& context() const { return mCall->context(); }
  [[nodiscard]] const std::vector<StageRun>& runs() const { return mRuns; }
  [[nodiscard]] Call& call() { return *mCall; }

  /// `work` on the session with the scene as it is now.
  template <class Work>
  auto run(const Work& work) {
    Scene scene = plainScene(*mScene);
    const Turn turn(*this);
    mSession->setScene(std::move(scene));
    return mCall->run([&] { return work(*mSession); });
  }

  /// Light from elsewhere is good for one domain, and the scene may be changed to another.
  void setRadiance(const RadianceVolume& light) {
    run([&](Session& session) {
      session.setRadiance(light);
      mForeignLight = light;
    });
  }

  /// As run(), for what looks at light in the medium.
  template <class Work>
  auto runLit(const Work& work) {
    return run([&](Session& session) {
      if (mForeignLight) requireSameDomain(mForeignLight, session.medium());
      return work(session);
    });
  }

private:
  /// One call at a time. Whoever waits holds no lock of the interpreter and listens to Ctrl-C.
  class Turn {
  public:
    explicit Turn(SessionHandle& owner) : mOwner(owner) {
      if (owner.mCall->insideCallback())
        throw Error(ErrorKind::Usage, "Session: a callback cannot run stages of the session that called it; do so "
                                      "after the call");
      while (!waitShortly())
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    ~Turn() {
      mOwner.mRuns = mOwner.mSession->runs();
      mOwner.mBusy.unlock();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

  private:
    bool waitShortly() {
      const WithoutLock release;
      return mOwner.mBusy.try_lock_for(std::chrono::milliseconds(20));
    }
    SessionHandle& mOwner;
  };

  std::shared_ptr<SceneHandle> mScene;
  std::unique_ptr<Call> mCall;
  std::unique_ptr<Session> mSession;
  RadianceVolume mForeignLight; ///< of setRadiance
  std::vector<StageRun> mRuns;  ///< as of the end of the latest call, so that asking never waits
  std::timed_mutex mBusy;
};

template <class T>
std::shared_ptr<T> mutableOf(const std::shared_ptr<const T>& shared) {
  return std::const_pointer_cast<T>(shared); // Python's class has no way to change it
}

constexpr std::array<const char*, 8> kLayers{"radiance", "caustic",     "direct", "direction",
                                             "index",    "attenuation", "step",   "energy"};

struct SliceHandle {
  py::array values;
  float least, greatest;
  std::array<Vec3d, 4> corners;
};

SliceHandle sliceOf(SessionHandle& handle, py::handle layer, int axis, double position) {
  const FieldDoc doc{""};
  const std::string place = "Session.slice()", name = "layer";
  SliceOptions options;
  options.layer = static_cast<VolumeLayer>(indexOfWord(layer, {kLayers.begin(), kLayers.end()}, {place, name, doc}));
  options.axis = axis;
  options.position = position;
  VolumeSlice slice = handle.runLit([&](Session& session) {
    const auto photons = session.sharedPhotons();
    return sliceVolume(*session.sharedFlat(), *photons, options);
  });
  return {adopt<float>(std::move(slice.values), {slice.rows, slice.columns, 3}), slice.least, slice.greatest,
          slice.corners};
}

void addRuns(py::module_& m) {
  py::class_<StageRun>(m, "StageRun", "One run of one stage.")
      .def_readonly("stage", &StageRun::stage, "surface, medium, stepField, photons or view.")
      .def_readonly("key", &StageRun::key, "Hash of all that it depends on.")
      .def_readonly("milliseconds", &StageRun::milliseconds)
      .def_readonly("because", &StageRun::because, "Places of the scene that differ from the run before.")
      .def_readonly("from_disk", &StageRun::fromDisk, "Read from the cache instead of computed.")
      .def("__repr__", [](const StageRun& r) {
        return "<volcaustic.StageRun: " + r.stage + ", " + std::to_string(r.milliseconds) + " ms>";
      });
  py::class_<StagePlan>(m, "StagePlan", "Whether a stage would run, were view() called now.")
      .def_readonly("stage", &StagePlan::stage)
      .def_readonly("runs", &StagePlan::runs)
      .def_readonly("because", &StagePlan::because)
      .def("__repr__",
           [](const StagePlan& p) { return "<volcaustic.StagePlan: " + p.stage + (p.runs ? " runs>" : " is there>"); });
  py::class_<SliceHandle>(m, "VolumeSlice", "One layer of voxels.")
      .def_readonly("values", &SliceHandle::values,
                    "(rows, columns, 3) float32, rows from the greatest coordinate; numbers are in all three channels.")
      .def_readonly("least", &SliceHandle::least)
      .def_readonly("greatest", &SliceHandle::greatest)
      .def_property_readonly(
          "corners", [](const SliceHandle& s) { return getField(s.corners); },
          "World: top left, top right, bottom right, bottom left.");
}

/// Lets the collector see the callbacks, which may be methods of what owns the session.
void collectCallbacks(PyHeapTypeObject* heap) {
  static constexpr auto callOf = [](PyObject* self) -> Call* {
    auto place = reinterpret_cast<py::detail::instance*>(self)->get_value_and_holder();
    return place.holder_constructed() ? &static_cast<SessionHandle*>(place.value_ptr())->call() : nullptr;
  };
  PyTypeObject& type = heap->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (Call* call = callOf(self)) {
      Py_VISIT(call->progress.ptr());
      Py_VISIT(call->log.ptr());
    }
    return 0;
  };
  type.tp_clear = [](PyObject* self) {
    if (Call* call = callOf(self)) {
      const py::object progress = std::exchange(call->progress, py::none()), log = std::exchange(call->log, py::none());
    }
    return 0;
  };
}

void addResults(py::class_<SessionHandle>& type) {
  type.def(
          "medium", [](SessionHandle& s) { return s.run([](Session& session) { return Medium(session.medium()); }); },
          "The Medium of the scene as it is now.")
      .def(
          "photons",
          [](SessionHandle& s) { return mutableOf(s.run([](Session& session) { return session.sharedPhotons(); })); },
          "The PhotonResult of the scene as it is now.")
      .def(
          "view",
          [](SessionHandle& s, const py::object& onPass) {
            const ViewObserver observer = observerOf(s.call(), onPass);
            return mutableOf(s.runLit([&](Session& session) { return session.sharedView(observer); }));
          },
          py::kw_only(), py::arg("on_pass") = py::none(),
          "The ViewResult of the scene as it is now. on_pass is called with a copy of it after each pass.")
      .def(
          "surface",
          [](SessionHandle& s, std::size_t i) {
            return MeshHandle{s.run([i](Session& session) { return session.surface(i); }), false};
          },
          py::arg("index"), "The triangles of an object as they stand in the world: a read-only Mesh.")
      .def(
          "content_box",
          [](SessionHandle& s) -> py::object {
            const auto box = s.run([](Session& session) { return session.contentBox(); });
            if (!box) return py::none();
            return toTuple(*box);
          },
          "Two corners around everything visible; None where there is nothing.")
      .def("slice", &sliceOf, py::arg("layer") = "radiance", py::kw_only(), py::arg("axis") = 1,
           py::arg("position") = .5,
           "A VolumeSlice across an axis (0, 1, 2), at a part of the domain along it: radiance, caustic, direct "
           "(W/(m2 sr)), direction, index, attenuation (1/world), step (voxels) or energy (W/m3).")
      .def(
          "view_channels",
          [](SessionHandle& s) { return s.run([](Session& session) { return session.viewChannels(); }); },
          "Channels of view()'s picture, known before anything has run.")
      .def("set_radiance", &SessionHandle::setRadiance, py::arg("radiance"),
           "Takes light from elsewhere in place of the photon stage.");
}

} // namespace

void addSessions(py::module_& m) {
  addRuns(m);
  py::class_<SessionHandle> type(
      m, "Session", py::custom_type_setup(&collectCallbacks),
      "A scene and the latest results of each stage; only stages that a change touches run again. Change the scene in "
      "place, or assign another. Calls from several threads take turns; results outlive the session.");
  type.def(py::init([](std::shared_ptr<SceneHandle> scene, const py::kwargs& given) {
             return std::make_unique<SessionHandle>(std::move(scene), given);
           }),
           py::arg("scene").none(false),
           "Keywords: results (of each stage that are kept; with more than one, going back costs nothing), cache (a "
           "folder that outlives the session), and those of every long call.");
  addResults(type);
  type.def_property("scene", &SessionHandle::scene, &SessionHandle::setScene,
                    "The Scene, which can be changed in place.")
      .def(
          "plan", [](SessionHandle& s) { return s.run([](Session& session) { return session.plan(); }); },
          "What view() would run, stage by stage, and why.")
      .def_property_readonly("runs", &SessionHandle::runs, "Every StageRun up to the end of the latest call.")
      .def(
          "cancel", [](SessionHandle& s) { s.call().stop(); },
          "Ends the call that another thread is in: it raises Cancelled. Results stay as they were.")
      .def_property_readonly("seed", [](const SessionHandle& s) { return s.context().seed; })
      .def_property_readonly("device", [](const SessionHandle& s) { return s.context().device; })
      .def_property_readonly("threads", [](const SessionHandle& s) { return s.context().threads; });
}

} // namespace volcaustic::python
