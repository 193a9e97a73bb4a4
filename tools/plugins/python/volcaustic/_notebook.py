"""How results show themselves in a notebook."""

from __future__ import annotations

import os
import tempfile

from volcaustic import _core


def _png(image: _core.Image) -> bytes | None:
    """The picture as a .png, where it is one; notebooks call this."""
    if not {"R", "G", "B"} <= set(image.channels) and len(image) != 1:
        return None
    with tempfile.TemporaryDirectory(prefix="volcaustic-") as folder:
        path = os.path.join(folder, "picture.png")
        _core.write_image(path, image)
        with open(path, "rb") as file:
            return file.read()


def install() -> None:
    _core.Image._repr_png_ = _png  # type: ignore[attr-defined]
    _core.ViewResult._repr_png_ = lambda view: _png(view.image)  # type: ignore[attr-defined]
