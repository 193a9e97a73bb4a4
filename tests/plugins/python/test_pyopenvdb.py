"""Grids exchanged with python3-openvdb."""

import subprocess
import sys

import numpy as np
import pytest

import volcaustic

vdb = pytest.importorskip("pyopenvdb", reason="python3-openvdb is not installed")


def dense(grid, dims):
    vector = isinstance(grid, vdb.Vec3SGrid)
    array = np.empty((*dims, 3) if vector else dims, np.float32)
    grid.copyToArray(array)
    return array


def test_a_medium_there_and_back(finished):
    medium = finished.medium()
    grids = volcaustic.to_pyopenvdb(medium)
    dims = medium.domain.dims
    for name in ("index", "attenuation", "scattering", "coverage"):
        assert np.array_equal(dense(grids[name], dims), getattr(medium, name)()), name
    again = volcaustic.medium_from_pyopenvdb(grids)
    assert again.domain == medium.domain and again.ambient == medium.ambient
    for name in ("index", "attenuation", "scattering", "coverage"):
        assert np.array_equal(getattr(again, name)(), getattr(medium, name)()), name


def test_light_is_fluence_over_four_pi(finished):
    light = finished.photons()
    grids = volcaustic.to_pyopenvdb(light, finished.medium(), parts=True)
    assert set(grids) == {"radiance", "direction", "emission", "density", "caustic", "direct"}
    radiance = dense(grids["radiance"], finished.medium().domain.dims)
    assert np.allclose(radiance, light.radiance.fluence() / (4 * np.pi), rtol=1e-6, atol=1e-9)
    assert grids.metadata["software"] == "volcaustic"
    with pytest.raises(TypeError, match="'half'"):
        volcaustic.to_pyopenvdb(light, finished.medium(), half=True)


def test_a_grid_changed_there_is_changed_here(finished):
    grids = volcaustic.to_pyopenvdb(finished.medium())
    numbers = dense(grids["index"], finished.medium().domain.dims)
    numbers[4:8, 4:8, 4:8] = 1.75
    grids["index"].copyFromArray(numbers)
    assert np.array_equal(volcaustic.medium_from_pyopenvdb(grids).index(), numbers)


def test_grids_of_others():
    ball = vdb.createLevelSetSphere(radius=1.0, center=(0, 0, 0), voxelSize=0.1)
    ball.name = "surface"
    material = volcaustic.Material(index=1.4)
    medium = volcaustic.medium_from_pyopenvdb(ball, body="surface", material=material, blur=1)
    assert medium.index().max() == pytest.approx(1.4)
    volume = medium.coverage().sum() * medium.domain.voxel_size**3
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.02)
    named = volcaustic.medium_from_pyopenvdb({"other": ball}, body="other", material=material, blur=1)
    assert np.array_equal(named.index(), medium.index()) and ball.name == "surface"
    with pytest.raises(volcaustic.InputError, match="surface"):
        volcaustic.medium_from_pyopenvdb([ball], attenuation="density")
    with pytest.raises(TypeError, match="pyopenvdb grids, not str"):
        volcaustic.medium_from_pyopenvdb("ball.vdb")


@pytest.mark.parametrize("order", ["pyopenvdb, volcaustic", "volcaustic, pyopenvdb"])
def test_both_modules_in_one_process(order):
    script = f"""
import {order}
import numpy as np
medium = volcaustic.sample_medium(volcaustic.Domain((0, 0, 0), 1, (8, 8, 8)), lambda x, y, z: 1 + x / 100)
assert np.array_equal(volcaustic.medium_from_pyopenvdb(volcaustic.to_pyopenvdb(medium)).index(), medium.index())
pyopenvdb.createLevelSetSphere(radius=5.0)
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def test_its_absence_is_said_in_one_sentence(monkeypatch, finished):
    monkeypatch.setitem(sys.modules, "pyopenvdb", None)
    with pytest.raises(ImportError, match="install python3-openvdb"):
        volcaustic.to_pyopenvdb(finished.medium())
