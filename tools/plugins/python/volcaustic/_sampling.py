"""Media of functions."""

from __future__ import annotations

from typing import Any, Callable

import numpy as np

from volcaustic import _core

_SLAB_BYTES = 64 << 20  # of coordinates handed to the function at once


def sample_medium(domain: _core.Domain, index: Callable[[Any, Any, Any], Any], **keywords: Any) -> _core.Medium:
    """A medium whose refractive index is a function of world coordinates, sampled at voxel centres.

    index(x, y, z) is called with float64 arrays that broadcast to (n, ny, nz), slab after slab along x, and returns the
    index there: an array that broadcasts to that shape, or a number. Keywords as of medium_from_arrays: ambient,
    attenuation, scattering, coverage, asymmetry, and those of every long call.
    """
    x, y, z = domain.centers()
    numbers = np.empty(domain.dims, np.float32)
    thickness = max(1, _SLAB_BYTES // (8 * len(y) * len(z)))
    for first in range(0, len(x), thickness):
        slab = slice(first, first + thickness)
        numbers[slab] = index(x[slab, None, None], y[None, :, None], z[None, None, :])
    return _core.medium_from_arrays(domain, numbers, **keywords)
