#!/usr/bin/python3
"""Writes the shapes of data/shapes whose numbers are computed: the gem's facets, the knot's beads, the drop's profile
and what is frozen into the ice.

    tools/dev/make_shapes.py [--into FOLDER] [NAME...]      writes all, or the named files, into data/shapes or FOLDER
"""

import argparse
import bisect
import math
import pathlib
import random


WATER_TENSION, WATER_DENSITY, GRAVITY = 0.0728, 998, 9.81  # SI


def number(value):
    """With six decimals at most, as people write it."""
    rounded = round(float(value), 6)
    return int(rounded) if rounded == int(rounded) else rounded


def row(values):
    return "[" + ", ".join(str(number(v)) for v in values) + "]"


def rows(items, indent, per_line):
    """Items of an array on lines of their own, `per_line` on each."""
    lines = [", ".join(items[i:i + per_line]) for i in range(0, len(items), per_line)]
    return (",\n" + " " * indent).join(lines)


def gem():
    """A round brilliant of diameter 1, ground from a cylinder."""
    table, crown, pavilion = 0.57, math.radians(34.5), math.radians(40.75)
    star_length, lower_half_length, half_girdle = 0.5, 0.77, 0.0175
    radius = 0.5
    sixteenth, thirtysecond = math.pi / 8, math.pi / 16

    def crown_main(r):
        """Height on the crown between two mains, in the azimuth of a star."""
        return half_girdle + (radius - r * math.cos(sixteenth)) * math.tan(crown)

    def pavilion_main(r):
        return half_girdle + (radius - r * math.cos(sixteenth)) * math.tan(pavilion)

    table_height = half_girdle + (radius - table / 2) * math.tan(crown)
    table_side = table / 2 * math.cos(sixteenth)
    star_tip = table_side + star_length * (radius - table_side)
    star = math.atan((table_height - crown_main(star_tip)) / (star_tip - table_side))
    upper = math.atan((crown_main(star_tip) - half_girdle) / ((radius - star_tip) * math.cos(thirtysecond)))
    lower_tip = radius * (1 - lower_half_length)
    lower = math.atan((pavilion_main(lower_tip) - half_girdle) / ((radius - lower_tip) * math.cos(thirtysecond)))

    def ring(what, count, slope, first, height):
        """`count` facets that rise to the axis at `slope`, the first in the azimuth `first`, meeting it in `height`."""
        return f'''      // {what}
      {{
        "type": "array", "count": {count}, "step": {{ "rotate": {row([0, 0, 360 / count])} }},
        "part": {{
          "use": "wheel", "rotate": {row([0, math.degrees(slope), first])}, "translate": {row([0, 0, height])}
        }}
      }}'''

    def up(slope, distance):
        return half_girdle + distance * math.tan(slope)

    edge = radius * math.cos(thirtysecond)
    # Slopes of more than 90 degrees are of facets below.
    rings = [
        ring("eight crown mains at 34.5 degrees", 8, crown, 0, up(crown, radius)),
        ring("eight stars", 8, star, 22.5, table_height + table_side * math.tan(star)),
        ring("sixteen upper halves", 16, upper, 11.25, up(upper, edge)),
        ring("eight pavilion mains at 40.75 degrees, which meet in the point below", 8, math.pi - pavilion, 0,
             -up(pavilion, radius)),
        ring("sixteen lower halves", 16, math.pi - lower, 11.25, -up(lower, edge)),
    ]
    return f'''\
// Round brilliant, 1 wide, the middle of its girdle in z = 0: a cylinder ground by 57 facets, as a cutter does it. The
// proportions are a good diamond's: table 57 %, crown 34.5 and pavilion 40.75 degrees, stars 50 %, lower halves 77 %,
// girdle 3.5 %, no culet. A facet is given by its slope, its azimuth and the height where its plane meets the axis.
// Made by tools/dev/make_shapes.py, which works out the heights for others. Play with: the cylinder (radii of
// 0.5 and 0.4 make an oval gem), material (n = 2.42 is diamond).
{{
  "volcaustic": 1,
  "shapes": {{
    // All that a grinding wheel takes away: what is above z = 0.
    "wheel": {{ "type": "plane", "normal": [0, 0, -1] }}
  }},
  "shape": {{
    "type": "difference",
    "parts": [
      {{ "type": "cylinder", "radii": [0.5, 0.5], "height": 1.2 }},
      // the table
      {{ "use": "wheel", "translate": {row([0, 0, table_height])} }},
{rows(rings, 0, 1)}
    ]
  }}
}}
'''


def knot(p=2, q=3, beads=17):
    """A trefoil of `3 * beads` balls that run together."""
    def curve(t):
        ring = 0.75 + 0.3 * math.cos(q * t)
        return (ring * math.cos(p * t), ring * math.sin(p * t), -0.3 * math.sin(q * t))

    fine = [curve(2 * math.pi / q * i / 6000) for i in range(6001)]
    length = [0.0]
    for a, b in zip(fine, fine[1:]):
        length.append(length[-1] + math.dist(a, b))
    points = [fine[bisect.bisect_left(length, length[-1] * i / beads)] for i in range(beads)]
    placements = rows([f'{{ "translate": {row(point)} }}' for point in points], 10, 2)
    return f'''\
// Torus knot (2, 3), about 2.4 wide and 1 high, around the origin: {3 * beads} balls on the curve that run together.
// A third of them is given, the array turns it twice. Made by tools/dev/make_shapes.py.
// Play with: blend (0 shows the balls, 0.3 swells the knot), or put another shape in place of the ball.
{{
  "volcaustic": 1,
  "shape": {{
    "type": "array", "count": 3, "step": {{ "rotate": [0, 0, 120] }}, "blend": 0.2,
    "part": {{
      "type": "instances", "blend": 0.2,
      "placements": [
          {placements}
      ],
      "part": {{ "type": "sphere", "radius": 0.2 }}
    }}
  }}
}}
'''


def pendant_drop(bond, step=1e-3):
    """Bashforth and Adams' profile of a hanging drop, from its apex up to where its neck is narrowest, in radii of the
    apex: points (r, z) along the curve. `bond` is density * gravity * radius^2 / surface tension."""
    def slopes(state):
        r, z, angle = state
        curvature = 1 if r < 1e-9 else math.sin(angle) / r
        return (math.cos(angle), math.sin(angle), 2 - bond * z - curvature)

    state, points = (0.0, 0.0, 0.0), [(0.0, 0.0)]
    belly = False
    while True:
        k1 = slopes(state)
        k2 = slopes(tuple(s + step / 2 * k for s, k in zip(state, k1)))
        k3 = slopes(tuple(s + step / 2 * k for s, k in zip(state, k2)))
        k4 = slopes(tuple(s + step * k for s, k in zip(state, k3)))
        before = state[2]
        state = tuple(s + step / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4))
        points.append(state[:2])
        belly = belly or state[2] > math.pi / 2
        if belly and before > math.pi / 2 >= state[2]:
            return points
        if len(points) * step > 20:
            raise ValueError(f"a drop of Bond number {bond} has no neck")


def droplet(bond=0.29, knots=14):
    points = pendant_drop(bond)
    scale = 1 / points[-1][1]
    picked = [points[round(i * (len(points) - 1) / knots)] for i in range(knots + 1)]
    curve = [(scale * r, scale * z) for r, z in picked]
    neck = curve[-1][0]
    above = [(neck, 1.1), (0, 1.1 + neck)]
    profile = rows([row(point) for point in curve + above], 12, 4)
    widest = 2 * max(r for r, _ in curve)
    height = 1e3 * math.sqrt(bond * WATER_TENSION / (GRAVITY * WATER_DENSITY)) / scale
    return f'''\
// Hanging drop of water, 1 high, {widest:.2f} wide, its lowest point at the origin, cut flat where its neck is
// narrowest, in z = 1: there it hangs on a tap. The profile solves Young and Laplace's equation for a Bond number of
// {bond} at the apex (density * gravity * radius^2 / surface tension), just before the drop falls: of water this is a
// drop of {height:.1f} mm. Made by tools/dev/make_shapes.py. Play with: scale, material (n = 1.33).
{{
  "volcaustic": 1,
  "shape": {{
    "type": "intersection",
    "parts": [
      {{
        "type": "revolution",
        "smooth": true,
        "points": [
            {profile}
        ]
      }},
      {{ "type": "plane", "normal": [0, 0, 1], "offset": 1 }}
    ]
  }}
}}
'''


def ice(bubbles=36, cracks=4, seed=7):
    """Bubbles and cracks that keep clear of each other and of the surface."""
    chance = random.Random(seed)
    half = (0.5, 0.4, 0.35)
    balls = []  # centre and a radius that holds the inclusion
    for reach in [0.19] * cracks + [0.05] * bubbles:
        while True:
            spread = 0.42 if reach > 0.1 else 0.5
            centre = [chance.uniform(-spread, spread) * h * 1.2 for h in half]
            if all(abs(c) + reach < h - 0.06 for c, h in zip(centre, half)) and all(
                    math.dist(centre, other) > reach + size + 0.02 for other, size in balls):
                balls.append((centre, reach))
                break
            if reach > 0.1:  # cracks are as large as the room that they find
                reach *= 0.998

    def placement(centre, rotate, scale):
        return f'{{ "translate": {row(centre)}, "rotate": {row(rotate)}, "scale": {row(scale)} }}'

    slits = [placement(centre, [chance.uniform(-90, 90), chance.uniform(-90, 90), 0], [size / 0.19, size / 0.19, 1])
             for centre, size in balls[:cracks]]
    blisters = []
    for centre, _ in balls[cracks:]:
        # They are drawn out towards the middle, where the ice froze last.
        rise = math.degrees(math.atan2(math.hypot(centre[0], centre[1]), centre[2]))
        heading = math.degrees(math.atan2(centre[1], centre[0]))
        blisters.append(placement(centre, [0, rise, heading], [chance.uniform(0.4, 1)] * 3))
    return f'''\
// Block of ice, 1 by 0.8 by 0.7, around the origin: a rounded cuboid that has begun to melt (noise), with {bubbles}
// bubbles, drawn out towards the middle, and {cracks} cracks, all of air. Made by tools/dev/make_shapes.py.
// Play with: the noise (amplitude, size, seed; key its drift and the block melts), material (n = 1.31), the bubbles'
// semi-axes.
{{
  "volcaustic": 1,
  "shape": {{
    "type": "difference",
    "parts": [
      {{
        "type": "noise", "amplitude": 0.03, "size": 0.4, "octaves": 3, "gain": 0.4,
        "part": {{ "type": "cuboid", "size": [1, 0.8, 0.7], "rounding": 0.09 }}
      }},
      {{
        "type": "instances",
        "placements": [
          {rows(blisters, 10, 1)}
        ],
        "part": {{ "type": "ellipsoid", "semiAxes": [0.03, 0.03, 0.05] }}
      }},
      {{
        "type": "instances",
        "placements": [
          {rows(slits, 10, 1)}
        ],
        "part": {{ "type": "cylinder", "radii": [0.18, 0.13], "height": 0.02 }}
      }}
    ]
  }}
}}
'''


SHAPES = {"gem.json": gem, "torus_knot.json": knot, "droplet.json": droplet, "ice.json": ice}


def main():
    data = pathlib.Path(__file__).resolve().parents[2] / "data" / "shapes"
    parser = argparse.ArgumentParser(description="writes the computed shapes of data/shapes")
    parser.add_argument("--into", metavar="FOLDER", type=pathlib.Path, default=data)
    parser.add_argument("names", metavar="NAME", nargs="*", help=", ".join(SHAPES))
    options = parser.parse_args()
    if unknown := set(options.names) - set(SHAPES):
        parser.error(f"{unknown.pop()} is not among {', '.join(SHAPES)}")
    options.into.mkdir(parents=True, exist_ok=True)
    for name, make in SHAPES.items():
        if not options.names or name in options.names:
            (options.into / name).write_text(make())


if __name__ == "__main__":
    main()
