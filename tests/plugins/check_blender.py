"""blender --background --python check_blender.py -- FOLDER: imports the volumes and loads every grid."""
import os
import sys

import bpy

folder = sys.argv[sys.argv.index("--") + 1]
EXPECTED = {
    "medium.vdb": {"index": "FLOAT", "attenuation": "VECTOR_FLOAT", "scattering": "VECTOR_FLOAT", "coverage": "FLOAT"},
    "light.vdb": {
        "radiance": "VECTOR_FLOAT", "direction": "VECTOR_FLOAT", "emission": "VECTOR_FLOAT", "density": "FLOAT",
        "caustic": "VECTOR_FLOAT", "direct": "VECTOR_FLOAT",
    },
}
for name, expected in EXPECTED.items():
    path = os.path.join(folder, name)
    bpy.ops.object.volume_import(filepath=path, files=[{"name": name}], directory=folder, align="WORLD")
    grids = bpy.context.object.data.grids
    assert grids.load(), f"{path}: {grids.error_message}"
    assert not grids.error_message, grids.error_message
    found = {grid.name: grid for grid in grids}
    assert {n: g.data_type for n, g in found.items()} == expected, {n: g.data_type for n, g in found.items()}
    for grid in found.values():
        assert grid.load(), f"{path}: {grid.name} does not load"
        scale = [grid.matrix_object[i][i] for i in range(3)]
        assert scale[0] > 0 and max(scale) - min(scale) < 1e-6 * scale[0], (grid.name, scale)
print("Blender", bpy.app.version_string, "loads all grids")
