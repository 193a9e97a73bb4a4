"""Scenes: files, sections that can be changed in place, copies."""

import json
import subprocess

import numpy as np
import pytest
from conftest import DATA, ball_scene, octahedron

import volcaustic

TEXT = """{ "volcaustic": 1, // comments are fine
  "objects": [{ "shape": { "type": "sphere", "radius": 0.5 } }],
  "lights": [{ "direction": [0, 0, -1] }], "photons": { "grid": [8, 8] } }"""


def test_text_and_back():
    scene = volcaustic.Scene.parse(TEXT)
    assert scene.photons.grid == (8, 8) and scene.objects[0].shape == volcaustic.Shape.sphere(0.5)
    again = volcaustic.Scene.parse(scene.to_json())
    assert again.to_json() == scene.to_json() and again.hash == scene.hash and len(scene.hash) == 16
    assert json.loads(scene.to_json())["photons"]["grid"] == [8, 8]


@pytest.mark.parametrize("name", ["glass_ball.json", "wine_glass.json", "fibre.json", "quickstart.json"])
def test_files_have_the_hash_that_the_program_says(name, program):
    scene = volcaustic.Scene.read(DATA / "scenes" / name, sets={"photons.grid": (16, 16)})
    assert scene.photons.grid == (16, 16)
    plain = volcaustic.Scene.read(DATA / "scenes" / name)
    done = subprocess.run([program, "info", str(DATA / "scenes" / name), "--json"], capture_output=True, text=True, check=True)
    assert plain.hash in done.stdout and scene.hash != plain.hash


def test_errors_name_the_place(tmp_path):
    with pytest.raises(volcaustic.InputError, match=r"a.json:/lights/0/directoin: unknown key.*\"direction\""):
        volcaustic.Scene.parse(TEXT.replace("direction", "directoin"), "a.json")
    with pytest.raises(volcaustic.InputError, match="a.json:1:"):
        volcaustic.Scene.parse("{", name="a.json")
    with pytest.raises(volcaustic.FileError, match="none.json"):
        volcaustic.Scene.read(tmp_path / "none.json")
    with pytest.raises(TypeError, match="'frames'; the nearest known one is 'frame'"):
        volcaustic.Scene.read(tmp_path / "none.json", frames=3)


def test_frames_of_an_animation():
    text = TEXT.rstrip(" }") + '}, "animation": {"/lights/0/direction": [[1, [0, 0, -1]], [3, [1, 0, -1]]]}}'
    assert volcaustic.Scene.parse(text, frame=2).lights[0].direction == pytest.approx((0.5, 0, -1))


def test_sections_are_live():
    scene = volcaustic.Scene.parse(TEXT)
    before = scene.hash
    scene.lights[0].direction = (1, 0, -1)
    assert scene.lights[0].direction == (1, 0, -1) and scene.hash != before
    scene.lights.append(volcaustic.Light(type="point"))
    light = scene.lights.pop(0)
    del scene
    assert light.direction == (1, 0, -1), "items live on by themselves"


def test_copies_share_nothing():
    scene = ball_scene()
    scene.objects[0].deform.append(volcaustic.Deformer(type="push", strength=1))
    other = scene.copy()
    assert other.to_json() == scene.to_json()
    other.lights[0].direction, other.camera.field_of_view = (0, 1, 0), 11
    other.objects[0].deform[0].strength = 2
    other.objects.append(volcaustic.SceneObject())
    assert scene.lights[0].direction == (0.3, 0, -1) and scene.camera.field_of_view == 40
    assert scene.objects[0].deform[0].strength == 1 and len(scene.objects) == 1


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda s: s.lights.append("sun"), r"lights\[1\] must be a Light, not str"),
        (lambda s: s.objects.append(None), r"objects\[1\] must be a SceneObject, not NoneType"),
        (lambda s: s.objects[0].groups.append(3), r"objects\[0\].groups\[0\] must be a SceneGroup, not int"),
        (lambda s: setattr(s, "camera", None), "camera must be a Camera, not NoneType"),
        (lambda s: setattr(s, "lights", 5), "lights must be a list, not int"),
    ],
)
def test_things_in_the_wrong_place(change, words):
    scene = ball_scene()
    with pytest.raises(TypeError, match=words):
        change(scene)
        volcaustic.Session(scene)


def test_keywords_are_the_sections():
    camera = volcaustic.Camera(field_of_view=20)
    scene = volcaustic.Scene(camera=camera, lights=(volcaustic.Light(),))
    camera.field_of_view = 21
    assert scene.camera.field_of_view == 21 and scene.lights == [volcaustic.Light()]
    with pytest.raises(TypeError, match="'light'; the nearest known one is 'lights'"):
        volcaustic.Scene(light=[])


def test_template_and_schema():
    volcaustic.Scene.parse(volcaustic.Scene.template())
    assert json.loads(volcaustic.Scene.schema())["$schema"] and json.loads(volcaustic.shape_schema())["$schema"]


def test_meshes_in_memory(mesh):
    scene = volcaustic.Scene(objects=[volcaustic.SceneObject(mesh=mesh)], lights=[volcaustic.Light()])
    inside = scene.objects[0].mesh
    assert np.shares_memory(inside.positions, mesh.positions) and not inside.writable
    scene.volume.resolution = 16
    scene.photons.grid = 8, 8
    session = volcaustic.Session(scene)
    first = session.medium().coverage().sum()
    mesh.positions *= 0.5
    scene.volume.bounds = (-1, -1, -1), (1, 1, 1)
    fixed = session.medium().coverage().sum() * session.medium().domain.voxel_size**3
    assert first > 0 and fixed == pytest.approx(4 / 3 * 0.25**3, rel=0.02), "what was written to the array was seen"
    assert np.array_equal(session.surface(0).triangles, octahedron()[1])


def test_objects_with_meshes_and_images_are_equal_by_value(mesh):
    ball = volcaustic.SceneObject(mesh=mesh)
    assert ball == ball and ball == volcaustic.SceneObject(mesh=volcaustic.Mesh(mesh.positions, mesh.triangles))
    assert ball != volcaustic.SceneObject(mesh=volcaustic.Mesh(2 * mesh.positions, mesh.triangles))
    assert mesh != None and mesh != 3  # noqa: E711
    image = volcaustic.Image(2, 2, {channel: np.ones((2, 2)) for channel in "RGB"})
    sky = volcaustic.Background(image=image)
    assert sky == sky and sky == volcaustic.Background(image=image.copy())
    other = image.copy()
    other["G"][0, 1] = 2
    assert sky != volcaustic.Background(image=other)
