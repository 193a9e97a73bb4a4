"""The shapes of data/shapes: each is closed, of its own topology and of the sizes that it says, and has its picture."""

import json
import math
import re
import subprocess
import sys
import unittest

from program import DATA, ProgramCase

SHAPES = DATA / "shapes"
DOCS = DATA.parent / "docs"

# Euler's characteristic of the surface, by shape: 2 for each body and each closed hollow, less 2 for each handle.
BUBBLES, FROZEN, FLOWER = 5, 36 + 4, 10 + 6 + 1
EULER = {
    "apple": 2, "bottle": 2, "bubbles": 2 + 2 * BUBBLES, "droplet": 2, "fibre": 2, "gem": 2, "goblet": 2,
    "ice": 2 + 2 * FROZEN, "lens_aspheric": 2, "lens_ball": 2, "lens_biconcave": 2, "lens_biconvex": 2,
    "lens_cylindrical": 2, "lens_meniscus": 2, "lens_plano_convex": 2, "paperweight": 2 + 2 * FLOWER, "prism": 2,
    "ripple_plate": 2, "torus_knot": 0, "vase": 2, "wine": 2, "wobble": 2,
}
# Cells along the longest side where 64 are too coarse for a thin wall or crack.
FINER = {"bottle": 128, "ice": 112, "bubbles": 80}

INDEX = 1.5
APERTURE = 0.3  # radius


def shape_of(name):
    text = (SHAPES / f"{name}.json").read_text()
    return json.loads(re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m.group(1) or "", text))["shape"]


def nodes(node):
    yield node
    for part in node.get("parts", []) + ([node["part"]] if "part" in node else []):
        yield from nodes(part)


def of_type(name, kind):
    return [node for node in nodes(shape_of(name)) if node.get("type") == kind]


def sagitta(radius, at=APERTURE):
    return radius - math.sqrt(radius * radius - at * at)


def cap(radius, at=APERTURE):
    """Volume of the cap of a ball that is as wide as the aperture."""
    s = sagitta(radius, at)
    return math.pi * s * (3 * at * at + s * s) / 6


def power(front, back, thickness):
    """The lensmaker's equation; radii are positive where the centre lies behind the face, None is flat."""
    a, b = (0 if r is None else 1 / r for r in (front, back))
    return (INDEX - 1) * (a - b + (INDEX - 1) * thickness * a * b / INDEX)


class Shop(ProgramCase):
    def mesh(self, name, resolution):
        out = self.path(f"{name}.ply")
        self.succeed("shape2mesh", SHAPES / f"{name}.json", "-o", out, "--resolution", resolution, "--quiet")
        return self.report("info", out)["files"][0]

    def check_mesh(self, name, mesh):
        self.assertTrue(mesh["closed"])
        for defect in ("openEdges", "inconsistentEdges", "nonManifoldEdges", "flippedFaces", "duplicateFaces",
                       "degenerateFaces", "inwardBodies"):
            self.assertEqual(mesh[defect], 0, defect)
        self.assertGreater(mesh["signedVolume"], 0)
        # Three edges for two triangles: V - E + F = V - F/2.
        self.assertEqual(mesh["vertices"] - mesh["triangles"] / 2, EULER[name])

    def test_every_shape_is_known_here(self):
        self.assertEqual(sorted(EULER), sorted(path.stem for path in SHAPES.glob("*.json")))

    def test_closed_manifold_and_of_its_topology(self):
        for name in EULER:
            with self.subTest(shape=name):
                self.check_mesh(name, self.mesh(name, FINER.get(name, 64)))

    def test_computed_shapes_are_what_the_script_writes(self):
        script = DATA.parent / "tools" / "dev" / "make_shapes.py"
        subprocess.run([sys.executable, "-B", script, "--into", self.folder], check=True, timeout=120)
        self.assertGreater(len(self.files()), 0)
        for name in self.files():
            with self.subTest(shape=name):
                self.assertEqual((self.folder / name).read_text(), (SHAPES / name).read_text())

    def test_every_shape_has_a_row_and_every_scene_a_picture(self):
        page = (DOCS / "shapes.md").read_text()
        for name in EULER:
            self.assertIn(f"[`{name}.json`](../data/shapes/{name}.json)", page)
        scenes = sorted(path.stem for path in (DATA / "scenes" / "shapes").glob("*.json"))
        self.assertEqual(scenes, sorted(set(EULER) - {"wine"}))  # which is in the goblet's
        for name in scenes:
            with self.subTest(scene=name):
                self.succeed("scene", "check", DATA / "scenes" / "shapes" / f"{name}.json")
                self.assertIn(f"(gallery/shapes/{name}.jpg)", page)
                self.assertLessEqual((DOCS / "gallery" / "shapes" / f"{name}.jpg").stat().st_size, 40960)


class Lenses(ProgramCase):
    """Focal lengths by the numbers in the files, and that the triangles are of the lens of these numbers."""

    def check(self, name, volume, thickness, width=2 * APERTURE):
        out = self.path("lens.ply")
        self.succeed("shape2mesh", SHAPES / f"{name}.json", "-o", out, "--resolution", 96, "--quiet")
        mesh = self.report("info", out)["files"][0]
        size = [high - low for low, high in zip(mesh["bounds"]["min"], mesh["bounds"]["max"])]
        self.assertAlmostEqual(size[0], width, delta=0.002 * width)
        self.assertAlmostEqual(size[2], thickness, delta=0.001 * thickness)
        self.assertAlmostEqual(mesh["signedVolume"] / volume, 1, delta=0.004)
        return mesh["bounds"]

    def spheres(self, name):
        return [(s["radius"], s["translate"][2]) for s in of_type(name, "sphere")]

    def test_biconvex(self):
        (upper, low), (lower, high) = self.spheres("lens_biconvex")[::-1]
        thickness = (low + upper) - (high - lower)
        self.assertAlmostEqual(thickness, 0.1176)
        self.assertAlmostEqual(power(upper, -lower, thickness), 1)
        edge = thickness - 2 * sagitta(upper)
        self.check("lens_biconvex", math.pi * APERTURE**2 * edge + 2 * cap(upper), thickness)

    def test_plano_convex(self):
        radius, centre = self.spheres("lens_plano_convex")[0]
        thickness = centre + radius + of_type("lens_plano_convex", "plane")[0]["offset"]
        self.assertAlmostEqual(thickness, 0.07)
        self.assertAlmostEqual(power(radius, None, thickness), 1 / 2)
        edge = thickness - sagitta(radius)
        self.check("lens_plano_convex", math.pi * APERTURE**2 * edge + cap(radius), thickness)

    def test_biconcave(self):
        (upper, high), (lower, low) = self.spheres("lens_biconcave")
        rim = of_type("lens_biconcave", "cylinder")[0]["height"]
        thickness = (high - upper) - (low + lower)
        self.assertAlmostEqual(thickness, 0.0606)
        self.assertAlmostEqual(power(-upper, lower, thickness), -1)
        depth = (rim - thickness) / 2
        at = math.sqrt(depth * (2 * upper - depth))
        self.assertAlmostEqual(2 * at, 0.594, delta=0.0005)
        self.check("lens_biconcave", math.pi * APERTURE**2 * rim - 2 * cap(upper, at), rim)

    def test_meniscus(self):
        (front, upper), (back, lower) = self.spheres("lens_meniscus")
        thickness = (upper + front) - (lower + back)
        self.assertAlmostEqual(thickness, 0.09)
        self.assertAlmostEqual(power(front, back, thickness), 1 / 2)
        edge = thickness - sagitta(front) + sagitta(back)
        self.assertAlmostEqual(edge, 0.0392, delta=5e-5)
        # From the rim's underside to the top: the edge's height and the front's sagitta.
        volume = math.pi * APERTURE**2 * edge + cap(front) - cap(back)
        self.check("lens_meniscus", volume, edge + sagitta(front))

    def test_ball(self):
        radius = shape_of("lens_ball")["radius"]
        self.assertAlmostEqual(power(radius, -radius, 2 * radius), 1)
        self.check("lens_ball", 4 / 3 * math.pi * radius**3, 2 * radius, 2 * radius)

    def test_cylindrical(self):
        cylinder, block = (of_type("lens_cylindrical", kind)[0] for kind in ("cylinder", "cuboid"))
        radius = cylinder.get("radii", [1, 1])[0]
        (width, depth, thickness), top = block["size"], cylinder["translate"][2] + radius
        self.assertAlmostEqual(top, thickness / 2)
        self.assertAlmostEqual(power(radius, None, thickness), 1 / 2)
        half = math.asin(width / 2 / radius)
        segment = radius**2 * (half - math.sin(half) * math.cos(half))
        edge = thickness - sagitta(radius, width / 2)
        self.check("lens_cylindrical", depth * (width * edge + segment), thickness, width)

    def test_aspheric_brings_all_heights_to_one_point(self):
        quadric = of_type("lens_aspheric", "quadric")[0]
        c, moved = quadric["coefficients"], quadric["translate"][2]

        def surface(r):
            return math.sqrt((-c[9] - c[0] * r * r) / c[2]) + moved

        self.assertEqual(c[0], c[1])
        self.assertAlmostEqual(surface(0), 0)
        for i in range(1, 11):
            r = APERTURE * i / 10
            z = surface(r)
            # Fermat: from the level of the focus's apex on, all ways take as long: what a ray has more in air, one on
            # the axis has in glass.
            self.assertAlmostEqual(math.hypot(r, z + 1) - 1, INDEX * z)
        height = of_type("lens_aspheric", "cylinder")[0]["height"]
        ring = APERTURE / 2000
        radii = [ring * (i + 0.5) for i in range(2000)]
        volume = sum(2 * math.pi * r * ring * (height - surface(r)) for r in radii)
        self.check("lens_aspheric", volume, height)


if __name__ == "__main__":
    unittest.main()
