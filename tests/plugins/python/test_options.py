"""Described structs in Python: names, ranges, types, copies."""

import copy
import pickle

import numpy as np
import pytest

import volcaustic
from volcaustic import _core

CLASSES = [name for name in _core._fields if isinstance(getattr(_core, name, None), type)]
REQUIRED = {
    "SceneGroup": {"name": "wine", "material": "wine"},
    "PropertyGrid": {"name": "density", "property": "attenuation"},
    "GridMapping": {"grid": "density"},
    "Deformer": {"type": "push"},
}


def made(cls, /, **fields):
    return getattr(volcaustic, cls)(**{**REQUIRED.get(cls, {}), **fields})


def another(thing, field, annotation):
    """A value that the field does not have, for the kinds of fields that are easy to change; else None."""
    value = getattr(thing, field)
    if annotation == "bool":
        return not value
    if annotation == "float":
        return value / 2 if value else 0.5
    if annotation.startswith("tuple[float, "):
        return tuple(v / 2 if v else 0.5 for v in value)
    if annotation == "str":
        return value + "other"
    return None


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_is_keyword_attribute_and_documented(name):
    thing, cls = made(name), getattr(volcaustic, name)
    for field, annotation, default, text, required in _core._fields[name]:
        assert field == field.lower() and text and annotation
        assert getattr(cls, field).__doc__ == text
        value = getattr(thing, field)
        if not required:
            assert value == default
        assert getattr(made(name, **{field: value}), field) == value
    assert set(thing.to_dict()) == {field for field, *_ in _core._fields[name]}


@pytest.mark.parametrize("name", CLASSES)
def test_copies_are_equal_and_apart(name):
    thing = made(name)
    field, value = next((f, another(thing, f, a)) for f, a, *_ in _core._fields[name]
                        if another(thing, f, a) is not None) if name != "VoxeliseOptions" else ("fill", "winding")
    for other in (copy.copy(thing), copy.deepcopy(thing), pickle.loads(pickle.dumps(thing)), thing.replace()):
        assert other == thing and repr(other) == repr(thing)
        setattr(other, field, value)
        assert other != thing and getattr(other, field) == value
        assert getattr(thing.replace(**{field: value}), field) == value


def test_repr_makes_the_object_again():
    light = volcaustic.Light(direction=(0.5, 0, -1), type="spot", name="lamp")
    assert repr(light) == "Light(name='lamp', type='spot', direction=(0.5, 0.0, -1.0))"
    assert eval(repr(light), vars(volcaustic)) == light
    assert repr(volcaustic.PhotonOptions()) == "PhotonOptions()"


def test_unknown_names_name_the_nearest():
    with pytest.raises(TypeError, match=r"PhotonOptions\(\) got an unexpected keyword argument 'max_step_';"):
        volcaustic.PhotonOptions(max_step_=3)
    with pytest.raises(TypeError, match="'fov'.*nearest known one is 'field_of_view'|'fov'"):
        volcaustic.Camera(fov=30)
    with pytest.raises(TypeError, match="'thread'; the nearest known one is 'threads'"):
        volcaustic.Session(volcaustic.Scene(), thread=2)
    with pytest.raises(volcaustic.UsageError, match="type is 'directionl'.*nearest known word is 'directional'"):
        volcaustic.Light(type="directionl")
    with pytest.raises(AttributeError):
        volcaustic.Camera().fov = 30


@pytest.mark.parametrize(
    "cls, field, value, words",
    [
        ("Camera", "field_of_view", 171, "field_of_view is 171, which is out of range; give a value from 0.01 to 170 degrees"),
        ("Camera", "position", (0, 0, float("nan")), "position is nan"),
        ("Camera", "resolution", (0, 5), "resolution is 0"),
        ("Camera", "resolution", (2**70, 5), "resolution is 1180591620717411303424"),
        ("VoxeliseOptions", "supersample", 3, "supersample is 3.*give a value of 1, 2, 4, 8"),
        ("Light", "irradiance", (-1, 0, 0), "irradiance is -1"),
        ("PhotonOptions", "max_steps", 2**31, "max_steps is 2147483648"),
    ],
)
def test_out_of_range(cls, field, value, words):
    thing = getattr(volcaustic, cls)()
    before = getattr(thing, field)
    for attempt in (lambda: setattr(thing, field, value), lambda: getattr(volcaustic, cls)(**{field: value})):
        with pytest.raises(volcaustic.UsageError, match=words) as caught:
            attempt()
        assert isinstance(caught.value, ValueError) and isinstance(caught.value, volcaustic.Error)
    assert getattr(thing, field) == before


@pytest.mark.parametrize(
    "cls, field, value",
    [
        ("Camera", "position", (0, 0)), ("Camera", "position", "abc"), ("Camera", "position", None),
        ("Camera", "position", 3), ("Camera", "field_of_view", "wide"), ("Camera", "field_of_view", True),
        ("Camera", "resolution", (4.0, 4)), ("Camera", "resolution", (True, 4)), ("PhotonOptions", "smooth", 1),
        ("PhotonOptions", "scheme", 0), ("Light", "name", 5), ("Background", "file", 5), ("Background", "image", "x.exr"),
        ("SceneVolume", "bounds", "big"), ("SceneObject", "mesh", 4), ("SceneObject", "shape", "ball.json"),
        ("SceneObject", "groups", [volcaustic.Light()]), ("SceneObject", "deform", 3),
    ],
)
def test_wrong_types(cls, field, value):
    thing = getattr(volcaustic, cls)()
    with pytest.raises(TypeError, match=f"{field} must be "):
        setattr(thing, field, value)


def test_numpy_scalars_and_arrays_do_as_numbers():
    camera = volcaustic.Camera(position=np.array([1, 2, 3], np.float32), resolution=np.array([8, 9]),
                               field_of_view=np.float32(30))
    assert camera.position == (1, 2, 3) and camera.resolution == (8, 9) and camera.field_of_view == 30
    assert volcaustic.PhotonOptions(jitter=np.bool_(True)).jitter is True
    assert volcaustic.PhotonOptions(max_steps=np.int64(7)).max_steps == 7


def test_what_must_be_given():
    with pytest.raises(TypeError, match="the keyword 'material' is missing"):
        volcaustic.SceneGroup(name="wine")
    with pytest.raises(TypeError, match="the keyword 'type' is missing"):
        volcaustic.Deformer()


def test_values_are_immutable_lists_are_live():
    thing = volcaustic.SceneObject(mesh="ball.ply")
    with pytest.raises(TypeError):
        thing.translate[0] = 3
    thing.deform.append(volcaustic.Deformer(type="push", strength=1))
    thing.deform[0].strength = 2
    assert thing.deform[0].strength == 2 and len(thing.deform) == 1
    assert thing.mesh == "ball.ply"


def test_paths(tmp_path):
    assert volcaustic.Background(file=tmp_path / "sky.hdr").file == str(tmp_path / "sky.hdr")
    assert volcaustic.Background(file=None).file == ""


def test_exceptions_are_a_family():
    kinds = {"UsageError": ValueError, "FileError": OSError, "InputError": Exception, "DeviceError": Exception,
             "Cancelled": Exception, "InternalError": Exception}
    for name, also in kinds.items():
        kind = getattr(volcaustic, name)
        assert issubclass(kind, volcaustic.Error) and issubclass(kind, also) and kind.__doc__
    assert not issubclass(volcaustic.InputError, volcaustic.UsageError)
