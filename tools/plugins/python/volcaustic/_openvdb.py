"""Grids exchanged with OpenVDB's own Python bindings.

A pyopenvdb grid is a Boost.Python object around a pointer of that build of OpenVDB; there is no stable way for a module of
another toolkit to take the pointer out. So grids pass through a file, in memory where the machine has such a folder. Every
value and transform survives to the bit.
"""

from __future__ import annotations

import importlib
import os
import tempfile
from typing import Any, Iterable, Mapping

from volcaustic import _core

_MEMORY_FOLDER = "/dev/shm"


class Grids(dict[str, Any]):
    """pyopenvdb grids by name, and the metadata of the file that they would be: the box of a medium is in it."""

    def __init__(self, grids: Iterable[Any] = (), metadata: Mapping[str, Any] | None = None) -> None:
        super().__init__((grid.name, grid) for grid in grids)
        self.metadata: dict[str, Any] = dict(metadata or {})


def _pyopenvdb() -> Any:
    try:
        return importlib.import_module("pyopenvdb")
    except ImportError as missing:
        raise ImportError(
            "pyopenvdb cannot be imported; install python3-openvdb, which belongs to the system's own Python"
        ) from missing


def _folder() -> tempfile.TemporaryDirectory[str]:
    memory = _MEMORY_FOLDER if os.access(_MEMORY_FOLDER, os.W_OK) else None
    return tempfile.TemporaryDirectory(prefix="volcaustic-", dir=memory)


def to_pyopenvdb(
    what: _core.Medium | _core.PhotonResult | _core.RadianceVolume, medium: _core.Medium | None = None, **keywords: Any
) -> Grids:
    """The grids of a Medium, or of light and its medium, as pyopenvdb objects by name.

    Keywords as of write_vdb, but for `half`: parts, exposure, metadata, and those of every long call. Raises ImportError
    where pyopenvdb is missing.
    """
    vdb = _pyopenvdb()
    if "half" in keywords:
        raise TypeError("to_pyopenvdb() takes no keyword 'half': values are exact")
    with _folder() as folder:
        path = os.path.join(folder, "grids.vdb")
        _core.write_vdb(path, what, medium, **keywords)
        grids, metadata = vdb.readAll(path)
        return Grids(grids, metadata)


def medium_from_pyopenvdb(grids: Any, **keywords: Any) -> _core.Medium:
    """A medium from pyopenvdb grids: one, several, or a mapping of them by name.

    Without keywords that map grids they are taken as of read_medium (index, attenuation, scattering, asymmetry, coverage
    by name); what to_pyopenvdb returned becomes the medium that it was. With the keywords of import_medium any grids
    become one. Raises ImportError where pyopenvdb is missing, InputError naming the grids that there are.
    """
    vdb = _pyopenvdb()
    metadata = dict(getattr(grids, "metadata", None) or {})
    named = dict(grids) if isinstance(grids, Mapping) else None
    several = list(named.values()) if named is not None else list(grids) if isinstance(grids, (list, tuple)) else [grids]
    for grid in several:
        if not hasattr(grid, "evalActiveVoxelBoundingBox"):
            raise TypeError(f"grids must be pyopenvdb grids, not {type(grid).__name__}")
    if named is not None:
        several = [_named(grid, name) for name, grid in named.items()]
    mapped = set(keywords) - {"threads", "seed", "device", "memory_limit", "progress", "log"}
    with _folder() as folder:
        path = os.path.join(folder, "grids.vdb")
        vdb.write(path, grids=several, metadata=metadata)
        return _core.import_medium(path, **keywords) if mapped else _core.read_medium(path, **keywords)


def _named(grid: Any, name: str) -> Any:
    """The grid under the name that it has in the mapping; another name goes to a copy, not to the caller's grid."""
    if grid.name == name:
        return grid
    copy = grid.copy()  # shares the voxels
    copy.name = name
    return copy
