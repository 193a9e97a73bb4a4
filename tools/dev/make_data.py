#!/usr/bin/python3
"""Generates every mesh of data/meshes and every volume of data/volumes. Needs numpy, and python3-openvdb for the bunny
and volumes.

    tools/dev/make_data.py [--into FOLDER] [NAME...]      writes all, or the named files, into data or another FOLDER

Lengths are metres in the glass's own size of about one; z is up; triangles are counter-clockwise seen from outside.
"""

import argparse
import pathlib
import sys

import numpy as np


def write_ply(path, positions, triangles, comment):
    """Binary little-endian PLY of float positions and triangles, checked to be closed and to enclose a positive volume."""
    positions = np.asarray(positions, dtype="<f4")
    triangles = np.asarray(triangles, dtype="<i4")
    require_closed(path.name, triangles)
    corner = positions.astype(np.float64)[triangles]
    volume = np.einsum("ij,ij->", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]) / 6
    if volume <= 0:
        raise ValueError(f"{path.name}: faces point inwards (volume {volume})")

    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = triangles
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"comment {comment}\ncomment made by tools/dev/make_data.py of volcaustic\n"
        f"element vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode("ascii") + positions.tobytes() + faces.tobytes())
    print(f"{path.name}: {len(positions)} vertices, {len(triangles)} triangles, volume {volume:.6f}")


def require_closed(name, triangles):
    """Every directed edge occurs once, and so does its reverse."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    size = int(triangles.max()) + 1
    forward = edges[:, 0] * size + edges[:, 1]
    backward = edges[:, 1] * size + edges[:, 0]
    if len(np.unique(forward)) != len(forward) or not np.array_equal(np.sort(forward), np.sort(backward)):
        raise ValueError(f"{name}: not closed and consistently wound")


def icosphere(subdivisions):
    """Unit sphere: an icosahedron with every triangle split in four, `subdivisions` times."""
    golden = (1 + np.sqrt(5)) / 2
    positions = [np.array(p) / np.hypot(1, golden) for s in (-1, 1) for t in (-golden, golden)
                 for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    points = np.array(positions)
    # Faces of the icosahedron: triples of mutually nearest vertices, wound outwards.
    near = np.linalg.norm(points[:, None] - points[None], axis=2) < 2.1 / np.hypot(1, golden)
    triangles = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    outwards = np.dot(np.cross(points[a], points[b]), points[c]) > 0
                    triangles.append((a, b, c) if outwards else (a, c, b))
    for _ in range(subdivisions):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                point = positions[a] + positions[b]
                positions.append(point / np.linalg.norm(point))
                middles[key] = len(positions) - 1
            return middles[key]

        split = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = split
    return np.array(positions), np.array(triangles)


def revolve(profile, segments):
    """Closed surface of revolution about z. The profile is a list of (radius, z) from the lower pole (radius 0) around
    the outside to the upper pole (radius 0); both poles become single vertices."""
    profile = np.asarray(profile, dtype=np.float64)
    rings = profile[1:-1]
    angle = 2 * np.pi * np.arange(segments) / segments
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    positions = [[0, 0, profile[0, 1]], [0, 0, profile[-1, 1]]]
    for radius, z in rings:
        positions += [[radius * x, radius * y, z] for x, y in circle]
    index = 2 + np.arange(len(rings) * segments).reshape(len(rings), segments)
    triangles = []
    for s in range(segments):
        t = (s + 1) % segments
        triangles.append((0, index[0, t], index[0, s]))
        triangles.append((1, index[-1, s], index[-1, t]))
        for r in range(len(rings) - 1):
            a, b, c, d = index[r, s], index[r, t], index[r + 1, t], index[r + 1, s]
            triangles += [(a, b, c), (a, c, d)]
    return np.array(positions), np.array(triangles)


def smooth_curve(knots, per_span):
    """Points of a Catmull-Rom curve through the knots, ends included."""
    knots = np.asarray(knots, dtype=np.float64)
    padded = np.concatenate([[2 * knots[0] - knots[1]], knots, [2 * knots[-1] - knots[-2]]])
    t = (np.arange(per_span) / per_span)[:, None]
    points = []
    for i in range(len(knots) - 1):
        p0, p1, p2, p3 = padded[i:i + 4]
        points.append(p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0))))
    return np.concatenate(points + [knots[-1:]])


# The goblet's bowl: outside and inside radius against height. The wall is 0.03 thick at the rim and swells to a lens of
# 0.12 above the stem.
BOWL_OUTSIDE = [(0.055, 0.78), (0.18, 0.84), (0.36, 0.98), (0.44, 1.20), (0.43, 1.45), (0.37, 1.72)]
BOWL_INSIDE = [(0.34, 1.72), (0.40, 1.45), (0.41, 1.20), (0.32, 1.01), (0.16, 0.92), (0.05, 0.90)]


def goblet(segments=144):
    """Wine goblet 1.73 high: foot, stem, bowl with a wall, rounded rim."""
    foot_and_stem = [(0.40, 0.0), (0.41, 0.02), (0.39, 0.04), (0.24, 0.07), (0.08, 0.14), (0.045, 0.30), (0.04, 0.50)]
    outside = smooth_curve(foot_and_stem + BOWL_OUTSIDE, 5)
    rim_angle = np.linspace(0, np.pi, 6)[1:-1]
    rim = np.stack([0.355 + 0.015 * np.cos(rim_angle), 1.72 + 0.015 * np.sin(rim_angle)], axis=1)
    inside = smooth_curve(BOWL_INSIDE, 6)
    profile = np.concatenate([[(0, 0)], outside, rim, inside, [(0, 0.895)]])
    return revolve(profile, segments)


def wine(segments=144):
    """What is in the goblet, filled to 1.30. It reaches a little into the wall, so that no gap of air is left: give the
    glass the higher priority."""
    inside = smooth_curve(BOWL_INSIDE, 6)[::-1]
    into_wall = 0.012
    below = inside[inside[:, 1] < 1.29] + [into_wall, 0]
    below[:, 1] -= into_wall * (below[:, 1] < 1.0)
    edge = below[-1, 0]
    profile = np.concatenate([[(0, below[0, 1] - 0.005)], below, [(edge, 1.30), (0.6 * edge, 1.30), (0, 1.30)]])
    return revolve(profile, segments)


def torus_knot(along=820, around=32, p=2, q=3, tube=0.22):
    """(p, q) torus knot as a tube, framed by the torus it winds on, about 1 in radius."""
    t = 2 * np.pi * np.arange(along) / along

    def curve(t):
        radius = 0.75 + 0.3 * np.cos(q * t)
        return np.stack([radius * np.cos(p * t), radius * np.sin(p * t), -0.3 * np.sin(q * t)], axis=1)

    centre = curve(t)
    tangent = curve(t + 1e-4) - curve(t - 1e-4)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    core = np.stack([0.75 * np.cos(p * t), 0.75 * np.sin(p * t), 0 * t], axis=1)
    normal = centre - core
    normal -= tangent * np.einsum("ij,ij->i", normal, tangent)[:, None]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    binormal = np.cross(tangent, normal)
    u = 2 * np.pi * np.arange(around) / around
    positions = (centre[:, None] + tube * (np.cos(u)[None, :, None] * normal[:, None]
                                           + np.sin(u)[None, :, None] * binormal[:, None])).reshape(-1, 3)
    index = np.arange(along * around).reshape(along, around)
    a, b = index, np.roll(index, -1, axis=1)
    d, c = np.roll(index, -1, axis=0), np.roll(np.roll(index, -1, axis=0), -1, axis=1)
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return positions, triangles


def gem_planes():
    """Outward normals and distances of a round brilliant of radius 1: Tolkowsky's angles, girdle about z = 0."""
    planes = []

    def ring(count, first, elevation, radius, z):
        """`count` facets, tilted `elevation` degrees from level, that pass through (radius, z) in their own azimuth."""
        slope = np.radians(abs(elevation))
        side = np.sign(elevation)
        for k in range(count):
            azimuth = 2 * np.pi * (k + first) / count
            normal = np.array([np.sin(slope) * np.cos(azimuth), np.sin(slope) * np.sin(azimuth), side * np.cos(slope)])
            planes.append((normal, np.sin(slope) * radius + side * np.cos(slope) * z))

    half_girdle = 0.02
    table_radius = 0.53
    table = half_girdle + (1 - table_radius) * np.tan(np.radians(34.5))
    planes.append((np.array([0.0, 0, 1]), table))
    ring(8, 0, 34.5, 1, half_girdle)                                # crown mains
    ring(8, 0.5, 21, table_radius * np.cos(np.pi / 8), table)       # stars
    ring(16, 0.5, 41, np.cos(np.pi / 16), half_girdle + 0.012)      # upper girdle facets
    ring(32, 0.5, 90, np.cos(np.pi / 32), 0)                        # girdle
    ring(16, 0.5, -42.2, np.cos(np.pi / 16), -half_girdle - 0.006)  # lower girdle facets
    ring(8, 0, -40.75, 1, -half_girdle)                             # pavilion mains, down to the culet
    return planes


def convex_solid(planes):
    """Vertices and outward triangles of the intersection of half-spaces normal.x <= distance."""
    normals = np.array([n for n, _ in planes])
    distances = np.array([d for _, d in planes])
    triple = np.array([(a, b, c) for a in range(len(planes)) for b in range(a) for c in range(b)])
    matrix = normals[triple]
    solvable = np.abs(np.linalg.det(matrix)) > 1e-9
    points = np.linalg.solve(matrix[solvable], distances[triple[solvable]][..., None])[..., 0]
    points = points[np.all(points @ normals.T <= distances + 1e-9, axis=1)]
    vertices = np.unique(np.round(points, 7), axis=0)

    triangles = []
    for normal, distance in planes:
        on = np.flatnonzero(np.abs(vertices @ normal - distance) < 1e-6)
        if len(on) < 3:
            continue
        centre = vertices[on].mean(axis=0)
        x = np.cross(normal, [0.0, 0, 1] if abs(normal[2]) < 0.9 else [1.0, 0, 0])
        y = np.cross(normal, x)
        angle = np.arctan2((vertices[on] - centre) @ y, (vertices[on] - centre) @ x)
        corners = on[np.argsort(angle)]
        triangles += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return vertices, np.array(triangles)


def lens(curvature=1.5, radius=0.6, edge=0.05, segments=160, rings=32):
    """Biconvex lens about z: two spherical faces of the given radius of curvature, `edge` apart where they end."""
    angle = np.linspace(0, np.arcsin(radius / curvature), rings + 1)
    across = curvature * np.sin(angle)
    sag = curvature * (1 - np.cos(angle))
    half = edge / 2 + sag[-1]
    lower = np.stack([across, sag - half], axis=1)
    upper = np.stack([across[::-1], half - sag[::-1]], axis=1)
    return revolve(np.concatenate([lower, upper]), segments)


def turned_to(axis):
    """Columns x, y, z of a frame whose z is along `axis` and whose y is across it and across the world's x."""
    z = np.asarray(axis) / np.linalg.norm(axis)
    y = np.cross(z, [1.0, 0, 0])
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


def ellipsoid(points, centre, radii, axis=(0, 0, 1)):
    """Distance from an ellipsoid whose third radius is along `axis`, exact at its surface to first order."""
    local = (points - np.asarray(centre)) @ turned_to(axis) / np.asarray(radii)
    from_centre = np.linalg.norm(local, axis=-1)
    slope = np.linalg.norm(local / np.asarray(radii), axis=-1)
    return from_centre * (from_centre - 1) / np.maximum(slope, 1e-9)


def tapered_capsule(points, start, end, start_radius, end_radius):
    """Distance from a stick with round ends whose radius changes along it."""
    start, along = np.asarray(start), np.asarray(end) - np.asarray(start)
    t = np.clip((points - start) @ along / (along @ along), 0, 1)
    radius = start_radius + t * (end_radius - start_radius)
    return np.linalg.norm(points - start - t[..., None] * along, axis=-1) - radius


def blend(a, b, width):
    """Union of two distance fields that runs together within `width` (polynomial smooth minimum)."""
    overlap = np.maximum(width - np.abs(a - b), 0) / width
    return np.minimum(a, b) - overlap * overlap * width / 4


def carve(a, b, width):
    """What of a is outside b, its edge rounded within `width`."""
    return -blend(-a, b, width)


def bunny_head(points):
    head = ellipsoid(points, (0.34, 0, 0.96), (0.275, 0.235, 0.235))
    cheek = ellipsoid(points, (0.42, 0.12, 0.89), (0.16, 0.13, 0.13))
    muzzle = ellipsoid(points, (0.555, 0, 0.895), (0.115, 0.12, 0.105))
    nose = ellipsoid(points, (0.655, 0, 0.935), (0.03, 0.045, 0.03))
    head = blend(blend(blend(head, cheek, 0.12), muzzle, 0.10), nose, 0.03)
    ear_axis = (-0.30, 0.20, 1)
    ear = ellipsoid(points, (0.13, 0.155, 1.46), (0.085, 0.125, 0.40), ear_axis)
    shell = ellipsoid(points, (0.235, 0.165, 1.49), (0.060, 0.078, 0.30), ear_axis)
    head = blend(head, carve(ear, shell, 0.03), 0.09)
    socket = ellipsoid(points, (0.515, 0.215, 1.005), (0.055, 0.05, 0.06))
    eye = ellipsoid(points, (0.478, 0.178, 1.0), (0.046, 0.046, 0.05))
    return blend(carve(head, socket, 0.03), eye, 0.008)


def bunny_field(points):
    """Distance, nearly, from a sitting bunny that looks along x, stands on z = 0 and is 1.85 high."""
    half = points * [1, 0, 1] + np.abs(points) * [0, 1, 0]  # left is as right
    body = ellipsoid(half, (-0.16, 0, 0.40), (0.46, 0.37, 0.40))
    parts = [
        (ellipsoid(half, (0.20, 0, 0.50), (0.24, 0.25, 0.36), (-0.15, 0, 1)), 0.22),       # chest
        (ellipsoid(half, (-0.14, 0.27, 0.29), (0.32, 0.14, 0.27), (-0.25, 0, 1)), 0.08),   # thighs
        (ellipsoid(half, (0.08, 0.30, 0.085), (0.33, 0.115, 0.085)), 0.07),                # hind feet
        (tapered_capsule(half, (0.30, 0.12, 0.42), (0.40, 0.125, 0.10), 0.10, 0.085), 0.08),  # fore legs
        (ellipsoid(half, (0.46, 0.125, 0.07), (0.13, 0.085, 0.07)), 0.06),                 # fore paws
        (ellipsoid(half, (-0.64, 0, 0.26), (0.14, 0.15, 0.15)), 0.05),                     # tail
        (bunny_head(half), 0.14),
    ]
    for part, width in parts:
        body = blend(body, part, width)
    return carve(body, points[..., 2], 0.03)  # flat below


def polygonise(field, low, high, cell):
    """Vertices and outward triangles of field(points) = 0 between two corners, vertices drawn onto the surface."""
    import pyopenvdb

    axes = [np.arange(l, h, cell) for l, h in zip(low, high)]
    values = field(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    grid = pyopenvdb.FloatGrid(4 * cell)
    grid.copyFromArray(np.clip(values, -4 * cell, 4 * cell).astype(np.float32))
    points, quads = grid.convertToQuads(0.0)
    points = points * cell + np.asarray(low)
    nudge = 1e-4
    for _ in range(3):
        rises = [field(points + nudge * e) - field(points - nudge * e) for e in np.eye(3)]
        slope = np.stack(rises, axis=-1) / (2 * nudge)
        pull = field(points)[:, None] * slope / np.maximum(np.einsum("ij,ij->i", slope, slope), 0.25)[:, None]
        points = points - np.clip(pull, -0.3 * cell, 0.3 * cell)
    a, b, c, d = quads.T
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int64)
    corner = points[triangles]
    if np.einsum("ij,ij->", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]) < 0:
        triangles = triangles[:, ::-1]
    return points, triangles


def bunny(cell=0.026):
    return polygonise(bunny_field, (-0.9, -0.6, -0.1), (0.85, 0.6, 2.0), cell)


def write_volume(path, name, values, first, voxel, background):
    """A .vdb with one grid of floats: `values` at the voxels from index `first` on, whose edges are `voxel`; voxels of
    the background are left out."""
    import pyopenvdb

    grid = pyopenvdb.FloatGrid(background)
    grid.copyFromArray(np.ascontiguousarray(values, dtype=np.float32), ijk=first, tolerance=0)
    grid.name = name
    grid.transform = pyopenvdb.createLinearTransform(
        [[voxel[0], 0, 0, 0], [0, voxel[1], 0, 0], [0, 0, voxel[2], 0], [0, 0, 0, 1]])
    pyopenvdb.write(str(path), grids=[grid], metadata={"creator": "tools/dev/make_data.py of volcaustic"})
    print(f"{path.name}: {name} from {values.min():g} to {values.max():g}, {grid.activeVoxelCount()} voxels, "
          f"{path.stat().st_size} bytes")


def fibre(path, core=1.55, cladding=1.4, radius=0.4, half_length=5.0):
    """Graded-index fibre along x: n^2 = core^2 (1 - (g rho)^2) that falls to the cladding's at `radius`. Light comes
    back to the axis every pi/g. It does not change along x, so its voxels are long."""
    g = np.sqrt(1 - (cladding / core) ** 2) / radius
    voxel = (0.5, 0.0125, 0.0125)
    across = int(radius / voxel[1]) + 2
    along = int(half_length / voxel[0]) + 1
    y, z = np.meshgrid(*2 * [np.arange(-across, across + 1) * voxel[1]], indexing="ij")
    inside = core * np.sqrt(np.clip(1 - (g * g) * (y * y + z * z), 0, 1))
    section = np.maximum(inside, cladding)
    values = np.broadcast_to(section, (2 * along + 1, *section.shape))
    write_volume(path, "index", values, (-along, -across, -across), voxel, cladding)


def hot_ground(path, air=293.15, ground=343.15, height=0.15):
    """Temperature in kelvin over a road of 20 by 20 in the sun: hot at z = 0, of the air above it, with warmer and
    cooler places and a layer that is thicker here and thinner there."""
    voxel = (0.3125, 0.3125, 0.05)
    side, up = 33, 28
    x, y, z = np.meshgrid(np.arange(-side, side + 1) * voxel[0], np.arange(-side, side + 1) * voxel[1],
                          np.arange(0, up) * voxel[2], indexing="ij")
    random = np.random.default_rng(1)
    waves = np.zeros_like(x)
    for _ in range(12):
        direction, phase = random.uniform(0, np.pi), random.uniform(0, 2 * np.pi)
        wavelength = random.uniform(2, 7)
        waves += np.sin(2 * np.pi * (x * np.cos(direction) + y * np.sin(direction)) / wavelength + phase)
    waves /= np.sqrt(12 / 2)
    warmth = (ground - air) * (1 + 0.1 * waves) * np.exp(-z / (height * (1 + 0.2 * waves)))
    top = np.clip((up * voxel[2] - z) / (4 * voxel[2]), 0, 1)  # fades out where the grid ends
    write_volume(path, "temperature", air + warmth * top, (-side, -side, 0), voxel, air)


MESHES = {
    "glass_ball.ply": lambda path: write_ply(path, *icosphere(5), "unit sphere, icosphere of five subdivisions"),
    "goblet.ply": lambda path: write_ply(path, *goblet(), "wine goblet with wall, stem and foot"),
    "wine.ply": lambda path: write_ply(path, *wine(), "wine for goblet.ply, reaching a little into its wall"),
    "torus_knot.ply": lambda path: write_ply(path, *torus_knot(), "(2,3) torus knot, tube radius 0.22"),
    "gem.ply": lambda path: write_ply(path, *convex_solid(gem_planes()), "round brilliant, radius 1"),
    "lens.ply": lambda path: write_ply(path, *lens(), "biconvex lens, faces of radius 1.5, aperture 0.6"),
    "bunny.ply": lambda path: write_ply(path, *bunny(), "sitting bunny, ellipsoids and sticks that run together"),
}
VOLUMES = {"fibre.vdb": fibre, "hot_ground.vdb": hot_ground}


def main():
    data = pathlib.Path(__file__).resolve().parents[2] / "data"
    parser = argparse.ArgumentParser(description="writes the meshes and volumes of data/")
    parser.add_argument("--into", metavar="FOLDER", type=pathlib.Path, default=data)
    parser.add_argument("names", metavar="NAME", nargs="*", help=", ".join([*MESHES, *VOLUMES]))
    options = parser.parse_args()
    if unknown := set(options.names) - {*MESHES, *VOLUMES}:
        parser.error(f"{unknown.pop()} is not among {', '.join([*MESHES, *VOLUMES])}")
    for folder, makers in (("meshes", MESHES), ("volumes", VOLUMES)):
        for name, make in makers.items():
            if not options.names or name in options.names:
                (options.into / folder).mkdir(parents=True, exist_ok=True)
                make(options.into / folder / name)


if __name__ == "__main__":
    main()
