"""Surfaces to sparse volumes of refractive index, photons along curved rays, caustics as OpenVDB volumes.

    import volcaustic

    scene = volcaustic.Scene.read("scene.json")
    session = volcaustic.Session(scene)
    light = session.photons()
    volcaustic.write_vdb("caustic.vdb", light, session.medium())
    picture = session.view().image["R"]        # (height, width) float32, a view

Every long call takes the keywords threads, seed, device, memory_limit, progress and log; it runs without the
interpreter's lock, and Ctrl-C stops it. docs/python.md has the rest.
"""

import numpy as _numpy

from volcaustic import _core, _notebook
from volcaustic._core import *  # noqa: F403
from volcaustic._core import __version__
from volcaustic._openvdb import Grids, medium_from_pyopenvdb, to_pyopenvdb
from volcaustic._sampling import sample_medium

if int(_numpy.__version__.split(".", 1)[0]) > 1 and not _core._knows_numpy_2:
    raise ImportError(f"volcaustic was built with pybind11 before 2.12, which misreads arrays of NumPy {_numpy.__version__}; "
                      "install numpy<2, or build with a newer pybind11")

_notebook.install()

__all__ = sorted(
    [name for name in vars(_core) if not name.startswith("_")]
    + ["Grids", "__version__", "medium_from_pyopenvdb", "sample_medium", "to_pyopenvdb"]
)
