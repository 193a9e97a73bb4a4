"""Sessions: what runs again, callbacks, threads, Ctrl-C."""

import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import weakref

import numpy as np
import pytest
from conftest import ball_scene, octahedron, slow_scene

import volcaustic


def stages(session):
    return [run.stage for run in session.runs]


def test_a_moved_camera_runs_the_view_alone(scene):
    session = volcaustic.Session(scene)
    session.view()
    assert stages(session) == ["medium", "stepField", "photons", "view"]
    scene.camera.position = 0, -5, 1
    assert [plan.stage for plan in session.plan() if plan.runs] == ["view"]
    session.view()
    assert stages(session)[4:] == ["view"] and session.runs[-1].because == ["camera/position"]
    session.view()
    assert len(session.runs) == 5
    session.scene.lights[0].irradiance = 1, 1, 1
    session.view()
    assert stages(session)[5:] == ["photons", "view"]


def test_results_kept_make_going_back_free(scene):
    session = volcaustic.Session(scene, results=2)
    first = session.view().image["R"]
    scene.camera.field_of_view = 30
    session.view()
    session.scene = ball_scene()
    assert np.array_equal(session.view().image["R"], first) and len(session.runs) == 5


def test_energy_is_conserved(finished):
    balance = finished.photons().balance
    assert balance.relative_imbalance < 1e-6
    for channel in range(3):
        parts = [getattr(balance, name)[channel] for name in ("absorbed", "scattered", "escaped", "received", "cut_off")]
        assert sum(parts) == pytest.approx(balance.emitted[channel], rel=1e-6)
    assert balance.photons_traced > 0 and balance.photons_not_finite == 0


def test_threads_and_seed(scene):
    light = volcaustic.Session(scene).photons().radiance.fluence()
    assert np.array_equal(volcaustic.Session(scene, threads=1).photons().radiance.fluence(), light)
    scene.photons.jitter = True
    jittered = [volcaustic.Session(scene, seed=seed).photons().radiance.fluence() for seed in (1, 1, 2)]
    assert np.array_equal(jittered[0], jittered[1]) and not np.array_equal(jittered[0], jittered[2])
    assert volcaustic.Session(scene, seed=2**64 - 1, threads=1, device="cpu").seed == 2**64 - 1
    with pytest.raises(volcaustic.UsageError, match="seed is -1"):
        volcaustic.Session(scene, seed=-1)


def test_the_cache_outlives_the_session(scene, tmp_path):
    light = volcaustic.Session(scene, cache=tmp_path).photons().radiance.fluence()
    session = volcaustic.Session(scene, cache=tmp_path)
    assert np.array_equal(session.photons().radiance.fluence(), light)
    assert [run.from_disk for run in session.runs] == [True]


def test_light_from_elsewhere(scene, finished):
    session = volcaustic.Session(scene)
    session.set_radiance(finished.photons().radiance)
    session.view()
    assert "photons" not in stages(session)


def test_slices_and_boxes(finished):
    index = finished.slice("index", axis=2, position=0.5)
    assert index.values.shape == (32, 32, 3) and index.values.max() == pytest.approx(1.5, rel=1e-3)
    assert index.greatest == index.values.max() and len(index.corners) == 4
    with pytest.raises(volcaustic.UsageError, match="nearest known word is 'index'"):
        finished.slice("indx")
    with pytest.raises(volcaustic.UsageError):
        finished.slice(axis=3)
    assert np.allclose(finished.content_box(), ((-0.4,) * 3, (0.4,) * 3), atol=0.05)
    assert finished.view_channels() == list(finished.view().image.channels)


def test_objects_that_are_not_there(finished):
    for index in (1, 10**18):
        with pytest.raises(volcaustic.UsageError, match="there is no such object"):
            finished.surface(index)
    with pytest.raises(TypeError):
        finished.surface(-1)
    with pytest.raises(TypeError):
        volcaustic.Session(None)
    with pytest.raises(TypeError):
        finished.scene = None


def test_progress_counts_up_and_names_stages(scene):
    seen = []
    volcaustic.Session(scene, progress=lambda stage, fraction: seen.append((stage, fraction))).view()
    names = list(dict.fromkeys(stage for stage, _ in seen))
    assert len(names) >= 2 and all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in seen)
    for name in names:
        fractions = [fraction for stage, fraction in seen if stage == name]
        assert fractions[-1] > 0


def test_an_exception_of_a_callback_stops_the_run_and_arrives(scene):
    def refuse(stage, fraction):
        raise LookupError(stage)

    session = volcaustic.Session(slow_scene(), progress=refuse)
    start = time.monotonic()
    with pytest.raises(LookupError):
        session.photons()
    assert time.monotonic() - start < 60
    with pytest.raises(TypeError, match="progress must be a callable"):
        volcaustic.Session(scene, progress=3)


def test_after_a_stopped_run_the_session_goes_on(scene):
    calls = []

    def once(stage, fraction):
        calls.append(stage)
        if len(calls) == 1:
            raise LookupError(stage)

    session = volcaustic.Session(scene, progress=once)
    with pytest.raises(LookupError):
        session.view()
    assert np.array_equal(session.view().image["R"], volcaustic.Session(scene).view().image["R"])


def test_the_log_takes_warnings(scene, caplog):
    corners, faces = octahedron()
    scene.objects[0] = volcaustic.SceneObject(mesh=volcaustic.Mesh(corners, faces[1:]))
    lines = []
    volcaustic.Session(scene, log=lambda level, line: lines.append((level, line))).medium()
    assert any(level == "warning" and "open edges" in line for level, line in lines), lines
    volcaustic.Session(scene).medium()
    assert any("open edges" in record.message and record.levelname == "WARNING" for record in caplog.records)


def test_passes_of_a_view(scene):
    scene.view.samples = 4
    pictures = []
    session = volcaustic.Session(scene)
    result = session.view(on_pass=lambda view: pictures.append(view))
    assert len(pictures) == result.passes > 1 and pictures[0].samples < pictures[-1].samples
    assert np.array_equal(pictures[-1].image["R"], result.image["R"])
    assert not np.shares_memory(pictures[-1].image["R"], result.image["R"])
    scene.camera.field_of_view = 20
    with pytest.raises(ZeroDivisionError):
        session.view(on_pass=lambda view: 1 / 0)
    with pytest.raises(TypeError, match="on_pass must be a callable"):
        session.view(on_pass=5)


def test_a_callback_that_calls_its_session_is_told(scene):
    def recurse(stage, fraction):
        session.view()

    session = volcaustic.Session(scene, progress=recurse)
    with pytest.raises(volcaustic.UsageError, match="a callback cannot run stages"):
        session.view()


def test_calls_from_several_threads_take_turns(scene):
    session = volcaustic.Session(scene, progress=lambda stage, fraction: time.sleep(0.001))
    results, failures = [], []

    def work(i):
        try:
            for _ in range(5):
                results.append(session.view().image["R"].copy())
                session.photons(), session.medium(), session.runs, session.plan()
        except BaseException as failure:  # noqa: B902 - whatever it is, the test reports it
            failures.append(failure)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
        assert not thread.is_alive(), "deadlock"
    assert not failures and len(results) == 20
    assert all(np.array_equal(result, results[0]) for result in results)
    assert stages(session).count("view") == 1


def test_the_interpreter_is_free_while_a_call_runs():
    session = volcaustic.Session(slow_scene())
    failures = []

    def run():
        try:
            session.photons()
        except volcaustic.Cancelled as stopped:
            failures.append(stopped)

    thread = threading.Thread(target=run)
    thread.start()
    counted, until = 0, time.monotonic() + 1
    while time.monotonic() < until:
        time.sleep(0.001)
        counted += 1
    assert counted > 100, "this thread would have stood still"
    while thread.is_alive():
        session.cancel()
        thread.join(0.05)
    assert len(failures) == 1


INTERRUPTED = """
    import os, signal, sys, threading, time
    sys.path.insert(0, {folder!r})
    from conftest import slow_scene
    import volcaustic

    started, stopped = [], []
    def progress(stage, fraction):
        if not started:
            started.append(stage)
            def interrupt():
                stopped.append(time.monotonic())
                os.kill(os.getpid(), signal.SIGINT)
            threading.Timer(0.2, interrupt).start()
    try:
        {call}
    except KeyboardInterrupt:
        print("late by", time.monotonic() - stopped[0])
        sys.exit(42)
"""


@pytest.mark.parametrize(
    "call",
    [
        "volcaustic.Session(slow_scene(), progress=progress).view()",
        "volcaustic.Shape.sphere(1).noise(0.1, octaves=8).triangulate(resolution=1000, progress=progress)",
        "volcaustic.trace_photons(volcaustic.sample_medium(volcaustic.Domain((0, 0, 0), 1, (128, 128, 128)), "
        "lambda x, y, z: 1 + x / 500), [volcaustic.Light()], grid=(65535, 65535), progress=progress)",
    ],
)
def test_ctrl_c_is_a_keyboard_interrupt(call):
    script = textwrap.dedent(INTERRUPTED).format(folder=os.path.dirname(__file__), call=call)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 42, done.stdout + done.stderr
    late = float(done.stdout.split()[-1])
    print(f"stopped {1000 * late:.0f} ms after the signal")
    assert late < 5


def test_other_signal_handlers_run_during_calls():
    session = volcaustic.Session(slow_scene())

    def handler(number, frame):
        raise InterruptedError(number)

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(InterruptedError):
            session.photons()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_devices():
    devices = volcaustic.list_devices()
    assert devices[0].id == "cpu" and devices[0].usable and devices[0].parallel_units > 0
    assert volcaustic.selected_device("cpu").startswith("cpu")
    with pytest.raises(volcaustic.UsageError):
        volcaustic.selected_device("gpu9")
    unusable = [device for device in devices if not device.usable]
    for device in unusable:
        with pytest.raises(volcaustic.DeviceError):
            volcaustic.Session(ball_scene(), device=device.id).photons()


def test_a_session_whose_callback_is_a_method_of_its_owner_goes_with_it():
    class Application:
        def __init__(self):
            self.session = volcaustic.Session(ball_scene(), progress=self.show)

        def show(self, stage, fraction):
            pass

    application = Application()
    application.session.medium()
    gone = weakref.ref(application)
    del application
    gc.collect()
    assert gone() is None
