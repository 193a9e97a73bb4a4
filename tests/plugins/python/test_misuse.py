"""What nobody should do ends in an exception, or in something harmless; never in a crash or a wrong picture."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import ball_scene

import volcaustic


def attempt(call):
    """The result, or the exception, which is one of ours or of Python's own for wrong arguments."""
    try:
        return call()
    except (volcaustic.Error, TypeError, ValueError, MemoryError, KeyError) as refused:
        assert str(refused) and not isinstance(refused, volcaustic.InternalError)
        return refused


@pytest.fixture(scope="module")
def other():
    scene = ball_scene(resolution=24)
    scene.volume.bounds = (-3, -2, -2), (3, 2, 2)
    session = volcaustic.Session(scene)
    session.photons()
    return session


def test_light_of_another_domain(finished, other, tmp_path):
    with pytest.raises(volcaustic.UsageError, match="another domain"):
        volcaustic.render_view(finished.medium(), other.photons(), volcaustic.Camera(resolution=(8, 8)))
    with pytest.raises(volcaustic.UsageError, match="different domains"):
        volcaustic.write_vdb(tmp_path / "a.vdb", finished.photons(), other.medium())
    session = volcaustic.Session(ball_scene())
    session.set_radiance(other.photons().radiance)
    for use in (session.view, session.slice, lambda: session.slice("energy")):
        with pytest.raises(volcaustic.UsageError, match="another domain"):
            use()
    session.set_radiance(finished.photons().radiance)
    assert session.view().image["R"].max() > 0
    session.scene.volume.resolution = 20
    with pytest.raises(volcaustic.UsageError, match="another domain"):
        session.view()


@pytest.mark.parametrize("position", [(1e30, 0, 0), (np.nan, 0, 0), (5, 5, 5), (0, 0, 0)])
@pytest.mark.parametrize("direction", [(0, 0, 0), (np.nan, 0, 1), (1e300, 0, 0), (0, 0, 1)])
@pytest.mark.parametrize("length", [0, -1, np.nan, np.inf])
def test_rays_from_nowhere(finished, position, direction, length):
    attempt(lambda: volcaustic.trace_rays(finished.medium(), [position], [direction], length=length, max_steps=1000))


def test_no_rays(finished):
    rays = volcaustic.trace_rays(finished.medium(), np.empty((0, 3)), np.empty((0, 3)))
    assert rays["position"].shape == (0, 3) and rays["left"].shape == (0,)


USES_OF_MESHES = [
    volcaustic.check_mesh,
    volcaustic.find_self_intersections,
    volcaustic.MeshDeformer,
    lambda mesh: mesh.bounds,
    lambda mesh: mesh.split_by_group(),
    lambda mesh: mesh.transformed(volcaustic.Placement(scale=(0, 1, 1))),
    lambda mesh: volcaustic.deform(mesh, []),
    lambda mesh: volcaustic.control_topology(mesh, topology="merge"),
    lambda mesh: volcaustic.build_medium([volcaustic.Body(mesh)], volcaustic.Domain((0, 0, 0), 1, (4, 4, 4))),
    lambda mesh: volcaustic.Session(volcaustic.Scene(objects=[volcaustic.SceneObject(mesh=mesh)])).medium(),
]


@pytest.mark.parametrize("use", range(len(USES_OF_MESHES)))
@pytest.mark.parametrize(
    "positions, triangles",
    [
        (np.empty((0, 3)), np.empty((0, 3), int)),
        (np.zeros((3, 3)), np.empty((0, 3), int)),
        (np.full((3, 3), np.nan), [(0, 1, 2)]),
        (np.full((3, 3), 1e308), [(0, 1, 2)]),
        (np.zeros((1, 3)), [(0, 0, 0)] * 5),
    ],
)
def test_meshes_of_nothing(positions, triangles, use):
    mesh = volcaustic.Mesh(positions, triangles)
    attempt(lambda: USES_OF_MESHES[use](mesh))


def test_pictures_without_planes(finished, tmp_path):
    image, medium = volcaustic.Image(4, 4), finished.medium()
    sky = volcaustic.Background(image=image)
    for use in (lambda: volcaustic.write_image(tmp_path / "a.exr", image), lambda: volcaustic.flip_difference(image, image),
                lambda: image.stack(), image._repr_png_,
                lambda: volcaustic.render_view(medium, finished.photons(), volcaustic.Camera(resolution=(8, 8)), background=sky),
                lambda: volcaustic.trace_photons(medium, [volcaustic.Light(type="environment")], background=sky, grid=(8, 8))):
        attempt(use)


def test_results_cannot_be_pickled_or_copied_into_hollow_ones(finished):
    light = finished.photons()
    for thing in (finished, finished.medium(), light, light.radiance, light.balance, finished.view()):
        for use in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match="cannot pickle"):
                use(thing)


@pytest.mark.parametrize("name", ["PhotonResult", "ReceiverMap", "ViewResult", "Scene", "Camera", "Mesh", "Image"])
def test_properties_of_none(name):
    for member in vars(getattr(volcaustic, name)).values():
        if isinstance(member, property):
            with pytest.raises(TypeError):
                member.fget(None)


def test_nothing_to_see():
    attempt(lambda: volcaustic.Session(volcaustic.Scene()).view())
    medium = volcaustic.build_medium([], volcaustic.Domain((0, 0, 0), 1, (1, 1, 1)))
    assert medium.index().tolist() == [[[1.0]]]
    dark = volcaustic.trace_photons(medium, [], grid=(4, 4))
    assert dark.radiance.fluence().max() == 0


def test_shapes_of_many_nodes():
    shape = volcaustic.Shape.sphere(1)
    with pytest.raises(volcaustic.InputError, match="nested more than"):
        for _ in range(5000):
            shape = shape.offset(0.001)
    attempt(lambda: shape.bounds)
    attempt(shape.to_json)
    crowd = volcaustic.Shape.sphere(1).array(10**6, volcaustic.Placement(translate=(1, 0, 0))).array(10**6, volcaustic.Placement())
    with pytest.raises(volcaustic.InputError, match="more than a million"):
        crowd.bounds


@pytest.mark.parametrize("work", ["volcaustic.Session(scene, progress=lambda *_: None).view()",
                                  "medium.index()",
                                  "volcaustic.check_mesh(volcaustic.Shape.sphere(1).triangulate())"])
def test_a_thread_that_works_while_the_interpreter_ends(work):
    """A daemon thread that was in C++ then must not come back for a lock that is no more."""
    program = f"""
import threading, time
import volcaustic
scene = volcaustic.Scene.parse('{{"volcaustic": 1, "objects": [{{"shape": {{"type": "sphere", "radius": 1}}}}], "lights": [{{}}]}}')
medium = volcaustic.Session(scene).medium()
def forever():
    while True:
        {work}
threading.Thread(target=forever, daemon=True).start()
time.sleep(0.5)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "terminate" not in done.stderr and "FATAL" not in done.stderr, done
