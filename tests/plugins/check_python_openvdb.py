"""check_python_openvdb.py FOLDER: reads medium.vdb, light.vdb and half.vdb with OpenVDB's Python bindings."""
import math
import sys

import pyopenvdb as vdb

SCALAR, VECTOR = "FloatGrid", "Vec3SGrid"
INVARIANT, CONTRAVARIANT = "invariant", "contravariant relative"
MEDIUM = {
    "index": (SCALAR, "unknown", None),
    "attenuation": (VECTOR, "fog volume", INVARIANT),
    "scattering": (VECTOR, "fog volume", INVARIANT),
    "coverage": (SCALAR, "fog volume", None),
}
LIGHT = {
    "radiance": (VECTOR, "fog volume", INVARIANT),
    "direction": (VECTOR, "unknown", CONTRAVARIANT),
    "emission": (VECTOR, "fog volume", INVARIANT),
    "density": (SCALAR, "fog volume", None),
}
PARTS = {name: (VECTOR, "fog volume", INVARIANT) for name in ("caustic", "direct")}


def check(path, expected):
    grids, metadata = vdb.readAll(path)
    grids = {grid.name: grid for grid in grids}
    assert sorted(grids) == sorted(expected), f"{path}: grids {sorted(grids)}"
    assert metadata["software"] == "volcaustic", metadata
    dims = metadata["volcaustic_dims"]
    for name, (kind, grid_class, vector_type) in expected.items():
        grid = grids[name]
        assert type(grid).__name__ == kind, (name, type(grid))
        assert grid["class"] == grid_class, (name, grid["class"])
        if vector_type:
            assert grid["vector_type"] == vector_type, (name, grid["vector_type"])
        assert grid.creator.startswith("volcaustic "), grid.creator
        for key in ("unit", "symbol", "software", "version"):
            assert grid[key], (name, key)
        assert grid.transform.isLinear and len({round(h, 9) for h in grid.transform.voxelSize()}) == 1
        low, high = grid.evalActiveVoxelBoundingBox()
        if grid.activeVoxelCount():
            assert all(l >= 0 and h < d for l, h, d in zip(low, high, dims)), (name, low, high, dims)
    return grids


def at(grid, ijk):
    return grid.getConstAccessor().getValue(ijk)


folder = sys.argv[1]
medium = check(f"{folder}/medium.vdb", MEDIUM)
middle = tuple((a + b) // 2 for a, b in zip(*medium["coverage"].evalActiveVoxelBoundingBox()))
assert at(medium["coverage"], middle) == 1, "the middle of the ball is solid"
assert abs(at(medium["index"], middle) - 1.5) < 1e-4, at(medium["index"], middle)
assert all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(at(medium["attenuation"], middle), (0.2, 0.3, 0.4)))

light = check(f"{folder}/light.vdb", LIGHT | PARTS)
half = check(f"{folder}/half.vdb", LIGHT)
brightest = (0, None)
for item in light["radiance"].citerOnValues():
    radiance, ijk = item.value, item.min
    parts = [c + d for c, d in zip(at(light["caustic"], ijk), at(light["direct"], ijk))]
    assert all(math.isclose(r, p, rel_tol=1e-5, abs_tol=1e-9) for r, p in zip(radiance, parts)), (ijk, radiance, parts)
    brightest = max(brightest, (radiance[1], ijk))
assert brightest[0] > 0, "no light at all"
full, short = at(light["radiance"], brightest[1]), at(half["radiance"], brightest[1])
assert all(math.isclose(a, b, rel_tol=2**-11) for a, b in zip(full, short)), (full, short)
print("python3-openvdb reads all grids")
