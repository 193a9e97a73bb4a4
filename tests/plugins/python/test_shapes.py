"""Functional objects built in Python."""

import pickle

import numpy as np
import pytest
from conftest import DATA

import volcaustic
from volcaustic import Shape


def test_values_and_gradients_of_a_ball():
    ball = Shape.sphere(0.5)
    points = np.random.default_rng(1).uniform(-1, 1, (1000, 3))
    values = ball.values(points)
    radius = np.linalg.norm(points, axis=1)
    assert np.array_equal(values > 0, radius < 0.5)
    surface = points / radius[:, None] / 2
    assert np.allclose(ball.values(surface), 0, atol=1e-12)
    assert np.allclose(ball.gradients(surface), -surface * 2, atol=1e-9), "of length one, inwards"
    out = np.empty(1000)
    assert ball.values(points.astype(np.float32), out=out) is out
    with pytest.raises(volcaustic.UsageError, match="points: has the shape"):
        ball.values(points[:, :2])


def test_positional_and_named_fields_are_the_same():
    assert Shape.torus(2, 0.5) == Shape.torus(major_radius=2, minor_radius=0.5) == Shape.torus(2, minor_radius=0.5)
    assert Shape.torus(2, 0.5) != Shape.torus(2, 0.4)
    with pytest.raises(TypeError, match="two values for 'major_radius'"):
        Shape.torus(2, major_radius=2)
    with pytest.raises(TypeError, match="at most 2 positional"):
        Shape.torus(1, 2, 3)
    with pytest.raises(TypeError, match="'points' is missing"):
        Shape.revolution()
    with pytest.raises(volcaustic.UsageError, match="radius is -1"):
        Shape.sphere(-1)


def test_operators_are_set_operations():
    a, b = Shape.sphere(1), Shape.cuboid((1, 1, 1)).placed(translate=(1, 0, 0))
    points = np.random.default_rng(2).uniform(-2, 2, (5000, 3))
    inside_a, inside_b = a.values(points) > 0, b.values(points) > 0
    for shape, inside in [(a | b, inside_a | inside_b), (a & b, inside_a & inside_b), (a - b, inside_a & ~inside_b),
                          (~a, ~inside_a)]:
        assert np.array_equal(shape.values(points) > 0, inside)
    assert Shape.union(a, b) == a | b and Shape.difference(a, b) == a - b
    with pytest.raises(TypeError):
        a | 3
    with pytest.raises(TypeError, match="parts must be Shapes, not int"):
        Shape.union(a, 3)
    with pytest.raises(volcaustic.InputError):
        Shape.union()


def test_operations_on_one_shape():
    ball = Shape.sphere(1)
    assert np.allclose(ball.offset(0.5).bounds, ((-1.5,) * 3, (1.5,) * 3), atol=0.2)
    row = ball.array(3, volcaustic.Placement(translate=(3, 0, 0)))
    assert row.bounds[1][0] == pytest.approx(7, abs=0.1)
    two = ball.instances(placements=[volcaustic.Placement(), volcaustic.Placement(translate=(0, 5, 0))])
    assert two.bounds[1][1] == pytest.approx(6, abs=0.1)
    assert ball.noise(amplitude=0.1, seed=3) != ball.noise(amplitude=0.1, seed=4)
    assert ball.bulge(Shape.sphere(0.5), 2).shell(0.1).waves(0.01, wavelength=0.2) != ball


def test_triangles_of_a_ball_have_its_volume():
    mesh = Shape.sphere(0.5).triangulate(resolution=48)
    report = volcaustic.check_mesh(mesh)
    assert report.closed_and_consistent and report.defects == ""
    assert report.signed_volume == pytest.approx(np.pi / 6, rel=5e-3)
    assert np.allclose(np.linalg.norm(mesh.positions, axis=1), 0.5, atol=2e-3)
    few = Shape.sphere(0.5).triangulate(triangles=500)
    assert len(few.triangles) <= 500
    with pytest.raises(volcaustic.InputError):
        Shape.plane((0, 0, 1)).triangulate()


def test_files_and_text(tmp_path):
    shape = (Shape.cuboid((1, 2, 3), rounding=0.1) - Shape.sphere(0.4).named("hole")).placed(rotate=(0, 30, 0))
    assert volcaustic.parse_shape(shape.to_json()) == shape and pickle.loads(pickle.dumps(shape)) == shape
    path = tmp_path / "shape.json"
    path.write_text(shape.to_json())
    assert volcaustic.read_shape(path).hash == shape.hash
    goblet = volcaustic.read_shape(DATA / "shapes" / "goblet.json")
    assert goblet.triangulate(resolution=24).triangles.size
    with pytest.raises(volcaustic.InputError, match="bad.json:/shape/raduis"):
        volcaustic.parse_shape('{"volcaustic": 1, "shape": {"type": "sphere", "raduis": 1}}', "bad.json")
    with pytest.raises(volcaustic.FileError):
        volcaustic.read_shape(tmp_path / "none.json")


def test_sets_change_a_file_before_it_is_checked():
    text = '{"volcaustic": 1, "shape": {"type": "sphere", "radius": 1}}'
    changed = volcaustic.parse_shape(text, sets={"shape.radius": 2})
    assert changed == Shape.sphere(2) == volcaustic.parse_shape(text, sets=["shape.radius=2"])


def test_deformation_keeps_triangles_and_moves_what_is_held():
    ball = Shape.sphere(0.5).triangulate(resolution=24)
    handles = [volcaustic.Deformer(type="handle", center=(0, 0, 0.5), radius=0.15, translate=(0, 0, 0.3)),
               volcaustic.Deformer(type="handle", center=(0, 0, -0.5), radius=0.15)]
    once = volcaustic.deform(ball, handles)
    again = volcaustic.MeshDeformer(ball).deform(handles)
    assert np.array_equal(once.positions, again.positions) and np.array_equal(once.triangles, ball.triangles)
    assert once.positions[:, 2].max() == pytest.approx(0.8, abs=0.02)
    assert once.positions[:, 2].min() == pytest.approx(-0.5, abs=0.02)
    with pytest.raises(volcaustic.UsageError, match=r"deform\[0\]"):
        volcaustic.deform(ball, [volcaustic.Deformer(type="handle", center=(9, 9, 9), radius=0.1)])
    assert volcaustic.find_self_intersections(ball).pairs == 0


def test_parts_that_meet_merge():
    ball = Shape.sphere(0.5).triangulate(resolution=20)
    moved = ball.transformed(volcaustic.Placement(translate=(0.8, 0, 0)))
    both = volcaustic.Mesh(np.concatenate([ball.positions, moved.positions]),
                           np.concatenate([ball.triangles, moved.triangles + len(ball.positions)]))
    assert volcaustic.find_self_intersections(both).pairs > 0
    assert volcaustic.find_self_intersections(both).examples.shape[1] == 2
    merged = volcaustic.control_topology(both, topology="merge")
    assert (merged.parts_before, merged.parts_after) == (2, 1)
    assert volcaustic.check_mesh(merged.mesh).closed_and_consistent
