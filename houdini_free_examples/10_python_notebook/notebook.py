# %% [markdown]
# # A lens from a notebook
# Cells are marked with `# %%`: Jupyter (with jupytext), VS Code and Spyder open this file as a notebook; `python3 notebook.py`
# runs it from top to bottom without a screen. It writes `lens.vdb`, `lens.exr` and `lens.png` into the current folder.

# %%
import numpy as np

import volcaustic
from volcaustic import Camera, Light, Scene, SceneObject, Session, Shape

# %% [markdown]
# ## A scene in Python
# A lens is what two balls have in common; the light comes straight down.

# %%
RADIUS, THICKNESS, INDEX = 1.2, 0.5, 1.5
offset = RADIUS - THICKNESS / 2
upper = Shape.sphere(RADIUS).placed(translate=(0, 0, -offset))
lower = Shape.sphere(RADIUS).placed(translate=(0, 0, offset))

scene = Scene(
    objects=[SceneObject(name="lens", shape=upper & lower)],
    materials=[volcaustic.Material(name="glass", index=INDEX)],
    lights=[Light(name="sun", direction=(0, 0, -1), irradiance=(4, 3.8, 3.5))],
    camera=Camera(position=(0, -6, 0.4), target=(0, 0, -0.4), resolution=(240, 200)),
)
scene.volume.bounds = (-0.9, -0.9, -1.9), (0.9, 0.9, 0.6)
scene.volume.resolution = 96
scene.volume.attenuation = scene.volume.scattering = 0.15, 0.15, 0.15
scene.photons.grid = 384, 384
scene.voxelise.blur = 5

# %% [markdown]
# ## Light as an array
# `fluence()` fills one array with the light of all voxels, W/m². The column through the middle of the lens is brightest where
# it focuses.

# %%
session = Session(scene)
light = session.photons()
fluence = light.radiance.fluence()
x, y, z = light.radiance.domain.centers()
column = fluence[len(x) // 2 - 1 : len(x) // 2 + 1, len(y) // 2 - 1 : len(y) // 2 + 1, :, 1].mean(axis=(0, 1))
brightest = z[np.argmax(column)]
print(f"brightest on the axis: z = {brightest:.3f}, {column.max():.0f} W/m2 in light of 3.8 W/m2")
print(f"energy unaccounted for: {light.balance.relative_imbalance:.1e} of what the sun sent into the box")

# %% [markdown]
# ## Rays, and the lensmaker's equation
# Rays near the axis cross it at the focus. A voxel surface is flat within a few voxels of the axis, so take rays from farther
# out, where they cross sooner (spherical aberration), and go to height zero along a parabola.

# %%
heights = np.linspace(0.12, 0.35, 24)
starts = np.stack([heights, np.zeros_like(heights), np.full_like(heights, 0.55)], axis=1)
rays = volcaustic.trace_rays(session.medium(), starts, np.tile((0.0, 0.0, -1.0), (len(heights), 1)))
position, direction = rays["position"], rays["direction"]
crossing = position[:, 2] - position[:, 0] * direction[:, 2] / direction[:, 0]
focus = np.polyfit(heights**2, crossing, 1)[1]

power = (INDEX - 1) * (2 / RADIUS - (INDEX - 1) * THICKNESS / (INDEX * RADIUS**2))
back_focal_length = (1 - (INDEX - 1) * THICKNESS / (INDEX * RADIUS)) / power
expected = -THICKNESS / 2 - back_focal_length
print(f"focus of rays near the axis: z = {focus:.4f}; lensmaker's equation: {expected:.4f}")

# %% [markdown]
# ## What moves
# Scenes are changed in place. A moved camera runs the view alone, and the session says why.

# %%
picture = session.view()
scene.camera.position = 2, -6, 1
picture = session.view()
print([(run.stage, run.because) for run in session.runs])
red = picture.image["R"]  # a view of the picture's memory, not a copy
print(f"picture {red.shape}, mean radiance {red.mean():.4f} W/(m2 sr)")
picture  # a notebook shows it

# %% [markdown]
# ## Files, and OpenVDB's own bindings

# %%
volcaustic.write_vdb("lens.vdb", light, session.medium())
volcaustic.write_image("lens.exr", picture.image)
volcaustic.write_image("lens.png", picture.image)
try:
    grids = volcaustic.to_pyopenvdb(session.medium())
    print({name: grid.activeVoxelCount() for name, grid in grids.items()})
except ImportError as missing:
    print(missing)

# %% [markdown]
# ## The example checks itself

# %%
assert light.balance.relative_imbalance < 1e-6
assert [run.stage for run in session.runs] == ["medium", "stepField", "photons", "view", "view"]
assert session.runs[-1].because == ["camera/position"]
assert abs(focus - expected) < 0.03 * back_focal_length, (focus, expected)
assert expected - 0.05 < brightest < -THICKNESS / 2, "spherical aberration moves it towards the lens"
