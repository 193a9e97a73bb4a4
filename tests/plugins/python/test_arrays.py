"""Memory that NumPy and volcaustic share: what is a view, what keeps it alive, what is taken and what is refused."""

import copy
import gc
import pickle
import sys

import numpy as np
import pytest
from conftest import ball_scene, octahedron

import volcaustic


def address(array):
    return array.__array_interface__["data"][0]


def test_mesh_arrays_are_views_of_one_memory(mesh):
    assert mesh.positions.shape == (6, 3) and mesh.positions.dtype == np.float64
    assert mesh.triangles.shape == (8, 3) and mesh.triangles.dtype == np.uint32
    assert address(mesh.positions) == address(mesh.positions)
    assert np.shares_memory(mesh.triangles, mesh.triangles)
    assert mesh.positions.base is mesh and mesh.triangle_group.shape == (0,)


def test_what_is_written_to_a_view_is_in_the_mesh(mesh):
    before = volcaustic.check_mesh(mesh).signed_volume
    view = mesh.positions
    view *= 2
    assert volcaustic.check_mesh(mesh).signed_volume == pytest.approx(8 * before)
    mesh.positions /= 2
    assert volcaustic.check_mesh(mesh).signed_volume == pytest.approx(before)
    assert address(mesh.positions) == address(view)


def test_assigning_keeps_the_memory_and_the_size(mesh):
    view, where = mesh.positions, address(mesh.positions)
    mesh.positions = np.asarray(view) + 1
    assert address(mesh.positions) == where and view[0, 0] == 1.5
    with pytest.raises(volcaustic.UsageError, match=r"has the shape \(5, 3\); give \(6, 3\)"):
        mesh.positions = view[:5]


def test_views_outlive_the_mesh():
    mesh = volcaustic.Mesh(*octahedron())
    views = mesh.positions, mesh.triangles
    expected = [np.array(v) for v in views]
    count = sys.getrefcount(mesh)
    del mesh
    gc.collect()
    churn = [np.full(1000, 7.0) for _ in range(200)]
    assert count and churn and all(np.array_equal(a, b) for a, b in zip(views, expected))


@pytest.mark.parametrize(
    "change",
    [
        np.asfortranarray,
        lambda a: a.astype(a.dtype.newbyteorder(">")),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1][::-1],
        lambda a: np.ascontiguousarray(a[:, ::-1])[:, ::-1],
        lambda a: a.tolist(),
        lambda a: np.lib.stride_tricks.as_strided(a, a.shape, a.strides, writeable=False),
    ],
)
def test_any_layout_is_taken_for_what_it_says(change):
    corners, faces = octahedron()
    mesh = volcaustic.Mesh(change(corners), change(faces))
    assert np.array_equal(mesh.positions, corners) and np.array_equal(mesh.triangles, faces)


@pytest.mark.parametrize("kind", [np.float32, np.float16, np.int8, np.int64])
def test_other_number_types_are_converted(kind):
    corners, faces = octahedron(radius=2)
    mesh = volcaustic.Mesh(corners.astype(kind), faces.astype(np.int16))
    assert np.array_equal(mesh.positions, corners) and mesh.triangles.dtype == np.uint32


@pytest.mark.parametrize(
    "positions, triangles, error, words",
    [
        (np.zeros((4, 2)), [(0, 1, 2)], volcaustic.UsageError, r"positions: has the shape \(4, 2\); give \(N, 3\)"),
        (np.zeros(12), [(0, 1, 2)], volcaustic.UsageError, r"positions: has the shape \(12,\)"),
        (np.zeros((4, 3)), [(0, 1)], volcaustic.UsageError, "triangles: has the shape"),
        (np.zeros((4, 3)), [(0.0, 1.0, 2.0)], TypeError, "triangles must be an array of whole numbers"),
        (np.zeros((4, 3)), [(0, 1, -1)], volcaustic.UsageError, "triangles: holds numbers from -1"),
        (np.zeros((4, 3)), [(0, 1, 2**32)], volcaustic.UsageError, "to 4294967296"),
        (np.zeros((4, 3)), [(0, 1, 4)], volcaustic.InputError, "names vertex 4 of 4"),
        (np.zeros((4, 3), complex), [(0, 1, 2)], TypeError, "positions must be an array of numbers"),
        (np.zeros((4, 3), bool), [(0, 1, 2)], TypeError, "positions must be an array of numbers"),
        ([["a", "b", "c"]], [(0, 0, 0)], TypeError, "positions must be an array of numbers"),
        (None, [(0, 0, 0)], TypeError, "positions must be an array, not None"),
    ],
)
def test_what_is_no_mesh_is_refused_by_name(positions, triangles, error, words):
    with pytest.raises(error, match=words):
        volcaustic.Mesh(positions, triangles)


def test_groups():
    corners, faces = octahedron()
    groups = np.arange(8) // 4
    mesh = volcaustic.Mesh(corners, faces, groups, ["top", "bottom"])
    assert mesh.group_names == ("top", "bottom") and np.array_equal(mesh.triangle_group, groups)
    assert [len(part.triangles) for part in mesh.split_by_group()] == [4, 4]
    with pytest.raises(volcaustic.UsageError, match="triangle_group: has the shape"):
        volcaustic.Mesh(corners, faces, groups[:3], ["top", "bottom"])
    with pytest.raises(volcaustic.InputError, match="names group 1 of 1"):
        volcaustic.Mesh(corners, faces, groups, ["top"])


def test_an_index_written_out_of_range_is_found_before_it_is_used(mesh):
    mesh.triangles[3, 1] = 2**32 - 1
    for use in (volcaustic.check_mesh, lambda m: m.bounds, lambda m: m.transformed(np.eye(4)), lambda m: m.split_by_group(),
                lambda m: volcaustic.deform(m, []), volcaustic.MeshDeformer, volcaustic.find_self_intersections):
        with pytest.raises(volcaustic.InputError, match=r"triangles\[3\]: names vertex 4294967295 of 6"):
            use(mesh)
    domain = volcaustic.domain_around(((-1, -1, -1), (1, 1, 1)), resolution=8)
    with pytest.raises(volcaustic.InputError, match=r"triangles\[3\]"):
        volcaustic.build_medium([volcaustic.Body(mesh)], domain)
    scene = volcaustic.Scene(objects=[volcaustic.SceneObject(mesh=mesh)])
    with pytest.raises(volcaustic.InputError, match=r"triangles\[3\]"):
        volcaustic.Session(scene)


def test_copies_of_a_mesh_share_nothing(mesh):
    for other in (copy.copy(mesh), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):
        assert np.array_equal(other.positions, mesh.positions) and np.array_equal(other.triangles, mesh.triangles)
        assert not np.shares_memory(other.positions, mesh.positions)


def test_results_are_read_only_views(finished):
    image = finished.view().image
    assert image["R"].shape == (30, 40) and image["R"].dtype == np.float32 and not image["R"].flags.writeable
    assert address(image["R"]) == address(finished.view().image["R"]), "asked again it is the same memory"
    with pytest.raises(ValueError, match="read-only"):
        image["R"][0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        image["R"] = np.zeros((30, 40))
    surface = finished.surface(0)
    assert not surface.writable and not surface.positions.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        surface.positions = surface.positions + 1


def test_results_outlive_the_session():
    session = volcaustic.Session(ball_scene())
    red, light, medium, surface = session.view().image["R"], session.photons(), session.medium(), session.surface(0)
    corners = surface.positions
    expected = red.copy(), light.radiance.fluence(), medium.index(), corners.copy()
    session.scene.lights[0].direction = 0, 0, -1
    session.view()
    del session, surface
    gc.collect()
    churn = [np.full(40 * 30, 7, np.float32) for _ in range(500)]
    now = red, light.radiance.fluence(), medium.index(), corners
    assert churn and all(np.array_equal(a, b) for a, b in zip(now, expected))


def test_image_planes():
    image = volcaustic.Image(3, 2, {"R": np.arange(6).reshape(2, 3)})
    view = image["R"]
    for i in range(40):  # the vector of planes grows under the view
        image[f"extra{i}"] = np.full((2, 3), i)
    view[1, 2] = 9
    assert image["R"][1, 2] == 9 and address(image["R"]) == address(view)
    assert image.channels[:2] == ("R", "extra0") and len(image) == 41 and "extra7" in image and image.shape == (2, 3)
    image["R"] += 1
    assert view[0, 0] == 1
    assert np.array_equal(image.stack(["extra1", "R"])[..., 1], view)
    with pytest.raises(KeyError, match="nearest is 'extra1'"):
        image["xtra1"]
    with pytest.raises(volcaustic.UsageError, match=r"has the shape \(3, 2\); give \(2, 3\)"):
        image["G"] = np.zeros((3, 2))
    with pytest.raises(volcaustic.UsageError):
        volcaustic.Image(0, 5)
    del image
    gc.collect()
    assert view[1, 2] == 10


def test_dense_boxes_into_given_memory(finished):
    light = finished.photons().radiance
    whole = light.fluence()
    assert whole.shape == (32, 32, 32, 3) and whole.dtype == np.float32
    out = np.full((2, 3, 4, 3), np.nan, np.float32)
    part = light.fluence(start=(5, 6, 7), stop=(7, 9, 11), out=out)
    assert part is out and np.array_equal(out, whole[5:7, 6:9, 7:11])
    assert light.direction(start=(32, 0, 0)).shape == (0, 32, 32, 3)
    assert np.allclose(light.caustic_fluence() + light.direct_fluence(), whole, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(
    "out, error, words",
    [
        (np.zeros((32, 32, 32)), TypeError, "out must be of float32, not of float64"),
        (np.zeros((32, 32, 31), np.float32), volcaustic.UsageError, r"give \(32, 32, 32\)"),
        (np.zeros((32, 32, 64), np.float32)[:, :, ::2], volcaustic.UsageError, "C-contiguous"),
        (np.broadcast_to(np.float32(0), (32, 32, 32)), volcaustic.UsageError, "C-contiguous and writable"),
        (np.zeros((32, 32, 32), ">f4"), TypeError, "out must be of float32"),
        ([0], TypeError, "numpy.ndarray"),
    ],
)
def test_memory_that_does_not_do_is_refused(finished, out, error, words):
    with pytest.raises(error, match=words):
        finished.medium().index(out=out)


@pytest.mark.parametrize("start, stop", [((0, 0, 0), (33, 1, 1)), ((5, 0, 0), (4, 1, 1)), ((2**31, 0, 0), None)])
def test_voxels_outside_the_domain_are_refused(finished, start, stop):
    for field in (finished.medium().index, finished.photons().radiance.fluence):
        with pytest.raises(volcaustic.UsageError, match="is no part of a domain of"):
            field(start=start, stop=stop)
        with pytest.raises(volcaustic.UsageError, match="numbers from -1"):
            field(start=(-1, 0, 0))
        with pytest.raises(TypeError):
            field(start=(0.5, 0, 0))


def test_medium_from_arrays_is_the_medium_that_it_was_read_from(finished):
    medium = finished.medium()
    again = volcaustic.medium_from_arrays(
        medium.domain, medium.index(), attenuation=medium.attenuation(), scattering=medium.scattering(),
        coverage=medium.coverage(), ambient=medium.ambient)
    for field in ("index", "attenuation", "scattering", "coverage", "asymmetry"):
        assert np.array_equal(getattr(again, field)(), getattr(medium, field)()), field
    light = volcaustic.trace_photons(again, finished.scene.lights, options=finished.scene.photons)
    assert np.array_equal(light.radiance.fluence(), finished.photons().radiance.fluence())


@pytest.mark.parametrize(
    "fields, words",
    [
        ({"index": np.full((2, 2, 2), 0.01)}, "index: holds 0.01"),
        ({"index": np.full((2, 2, 2), np.nan)}, "index: holds .*nan"),
        ({"index": np.ones((2, 2, 3))}, r"index: has the shape \(2, 2, 3\); give \(2, 2, 2\)"),
        ({"index": np.ones((2, 2, 2)), "attenuation": np.ones((2, 2, 2))}, "attenuation: has the shape"),
        ({"index": np.ones((2, 2, 2)), "scattering": np.ones((2, 2, 2, 3))}, "more than the attenuation"),
        ({"index": np.ones((2, 2, 2)), "coverage": np.full((2, 2, 2), 2)}, "coverage: holds 2"),
    ],
)
def test_media_that_cannot_be_are_refused(fields, words):
    with pytest.raises(volcaustic.UsageError, match=words):
        volcaustic.medium_from_arrays(volcaustic.Domain((0, 0, 0), 1, (2, 2, 2)), **fields)


def test_order_of_axes_is_x_y_z():
    domain = volcaustic.Domain((10, 20, 30), 0.5, (2, 3, 4))
    x, y, z = domain.centers()
    assert (x[0], y[2], z[3]) == (10.25, 21.25, 31.75) and domain.max_corner == (11, 21.5, 32)
    medium = volcaustic.sample_medium(domain, lambda x, y, z: 1 + 0.01 * (x - 10) + 0.1 * (y - 20) + (z - 30))
    expected = 1 + 0.01 * (x - 10)[:, None, None] + 0.1 * (y - 20)[None, :, None] + (z - 30)[None, None, :]
    assert np.allclose(medium.index(), expected, rtol=1e-6)
