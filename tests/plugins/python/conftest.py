"""What the cases in this folder share. PYTHONPATH leads to the built package; VOLCAUSTIC_PROGRAM names the program."""

import os
import pathlib

import numpy as np
import pytest

import volcaustic

DATA = pathlib.Path(os.environ.get("VOLCAUSTIC_DATA", pathlib.Path(__file__).parents[3] / "data"))


def octahedron(radius=0.5):
    """Corners and outward triangles of a regular octahedron: closed, volume 4/3 r^3."""
    corners = radius * np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    return corners, np.array(faces, np.uint32)


def ball_scene(resolution=32, photons=64):
    """A glass ball in grey fog under slanted light: runs in a fraction of a second."""
    scene = volcaustic.Scene(
        objects=[volcaustic.SceneObject(name="ball", shape=volcaustic.Shape.sphere(0.4))],
        lights=[volcaustic.Light(name="sun", direction=(0.3, 0, -1), irradiance=(4, 3, 2))],
    )
    scene.volume.bounds = (-1, -1, -1), (1, 1, 1)
    scene.volume.resolution = resolution
    scene.volume.attenuation = 0.3, 0.3, 0.4
    scene.volume.scattering = 0.2, 0.3, 0.3
    scene.photons.grid = photons, photons
    scene.camera.resolution = 40, 30
    return scene


def slow_scene():
    """As above, but so fine that nobody waits for its end."""
    scene = ball_scene(resolution=256, photons=16384)
    scene.camera.resolution = 4096, 4096
    return scene


@pytest.fixture
def mesh():
    return volcaustic.Mesh(*octahedron())


@pytest.fixture
def scene():
    return ball_scene()


@pytest.fixture(scope="session")
def finished():
    """A session whose results are there; nobody changes its scene."""
    session = volcaustic.Session(ball_scene())
    session.view()
    return session


@pytest.fixture
def program():
    path = os.environ.get("VOLCAUSTIC_PROGRAM")
    if not path or not os.access(path, os.X_OK):
        pytest.skip("the program is not there (VOLCAUSTIC_PROGRAM)")
    return path
