"""The stage functions by themselves: the session's numbers, and the program's, bit for bit."""

import subprocess

import numpy as np
import pytest
from conftest import DATA, ball_scene, octahedron

import volcaustic


def built(scene):
    domain = volcaustic.domain_around(scene.volume.bounds, resolution=scene.volume.resolution, padding=0)
    ambient = volcaustic.Ambient(attenuation=scene.volume.attenuation, scattering=scene.volume.scattering)
    return volcaustic.build_medium([volcaustic.Body(scene.objects[0].shape, name="ball")], domain, ambient=ambient)


def test_stages_one_by_one_are_the_session(scene, finished):
    medium = built(scene)
    assert medium.domain == finished.medium().domain and medium.ambient == finished.medium().ambient
    for field in ("index", "attenuation", "scattering", "coverage", "asymmetry"):
        assert np.array_equal(getattr(medium, field)(), getattr(finished.medium(), field)())
    light = volcaustic.trace_photons(medium, scene.lights, grid=scene.photons.grid)
    assert np.array_equal(light.radiance.fluence(), finished.photons().radiance.fluence())
    view = volcaustic.render_view(medium, light, scene.camera, background=scene.background)
    for channel in view.image.channels:
        assert np.array_equal(view.image[channel], finished.view().image[channel]), channel


def test_keywords_win_over_options(scene):
    medium = built(scene)
    options = volcaustic.PhotonOptions(grid=(64, 64), smooth=False)
    rough = volcaustic.trace_photons(medium, scene.lights, options=options, grid=(8, 8))
    assert rough.balance.photons_emitted <= 8 * 8 and options.grid == (64, 64)
    with pytest.raises(TypeError, match=r"trace_photons\(\) got an unexpected keyword argument 'grids'"):
        volcaustic.trace_photons(medium, scene.lights, grids=3)
    with pytest.raises(TypeError, match=r"lights\[0\] must be a Light, not int"):
        volcaustic.trace_photons(medium, [1])
    with pytest.raises(TypeError, match="a sequence of Lights"):
        volcaustic.trace_photons(medium, volcaustic.Light())
    with pytest.raises(TypeError, match="light must be a PhotonResult or a RadianceVolume, not int"):
        volcaustic.render_view(medium, 3, scene.camera)


@pytest.mark.parametrize("options", [{}, {"scheme": "euler"}])
def test_rays_go_straight_where_nothing_bends(options):
    domain = volcaustic.Domain((0, 0, 0), 0.1, (10, 10, 10))
    medium = volcaustic.sample_medium(domain, lambda x, y, z: 1.25)
    start = np.full((5, 3), 0.5)
    way = np.random.default_rng(3).normal(size=(5, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    rays = volcaustic.trace_rays(medium, start, way, **options)
    assert np.allclose(rays["direction"], way, atol=1e-12) and rays["left"].all()
    assert np.allclose(rays["position"], start + rays["length"][:, None] * way, atol=1e-6)
    assert np.allclose(rays["optical_momentum"], 1.25, rtol=1e-6)
    short = volcaustic.trace_rays(medium, start, way, length=0.25, **options)
    assert np.allclose(short["length"], 0.25, rtol=1e-6) and not short["left"].any()
    with pytest.raises(volcaustic.UsageError, match=r"directions: has the shape \(4, 3\); give \(5, 3\)"):
        volcaustic.trace_rays(medium, start, way[:4])


def test_a_ray_through_a_gradient_is_the_closed_form():
    """Where n^2 = a + b z, z is a parabola of the parameter: z = z0 + w t + b t^2/4, x = u t, with |(u, w)| = n."""
    a, b = 2.0, 0.5
    domain = volcaustic.domain_around(((-1, -1, -1), (1, 1, 1)), resolution=96)
    medium = volcaustic.sample_medium(domain, lambda x, y, z: np.sqrt(a + b * z))
    n = np.sqrt(a + b * -0.5)
    rays = volcaustic.trace_rays(medium, [(-0.9, 0.0, -0.5)], [(1.0, 0.0, 0.0)], length=1.6)
    x, _, z = rays["position"][0]
    t = (x + 0.9) / n
    assert z == pytest.approx(-0.5 + b * t * t / 4, abs=2e-5)


def test_receivers_collect_light_and_are_seen(scene):
    floor = volcaustic.SceneReceiver(name="floor", scale=(4, 4, 1), translate=(0, 0, -0.9), resolution=64)
    medium = built(scene)
    light = volcaustic.trace_photons(medium, scene.lights, grid=(128, 128), receivers=[floor])
    (floor_map,) = light.receiver_maps()
    assert floor_map.name == "floor" and floor_map.image["R"].shape == (64, 64) and floor_map.image["R"].max() > 0
    assert light.balance.received[0] > 0 and floor_map.texture_coordinates.shape == (2, 3, 2)
    irradiance = floor_map.image["caustic.R"]
    del light, floor_map
    assert irradiance.max() > 0
    scene.receivers.append(floor)
    scene.photons.grid = 128, 128
    with_floor = volcaustic.Session(scene).view().image
    assert with_floor["receiver.R"].max() > 0


def test_lights_one_by_one_add_up(scene):
    scene.lights.append(volcaustic.Light(name="lamp", type="point", position=(0, 0, 5)))
    scene.photons.separate = True
    light = volcaustic.Session(scene).photons()
    parts = light.lights
    assert [part.light for part in parts] == ["sun", "lamp"]
    total = sum(part.radiance.fluence() for part in parts)
    del light
    assert np.allclose(total, volcaustic.Session(scene).photons().radiance.fluence(), rtol=1e-4, atol=1e-5)


def test_environments_need_their_background(scene):
    sky = volcaustic.Image(16, 8, {name: np.ones((8, 16)) for name in "RGB"})
    light = volcaustic.trace_photons(built(scene), [volcaustic.Light(type="environment")],
                                     background=volcaustic.Background(image=sky), grid=(64, 64))
    fluence = light.radiance.direct_fluence(start=(1, 1, 1), stop=(3, 3, 3))
    assert 0.5 * 4 * np.pi < fluence.mean() < 4.2 * np.pi, "radiance 1 from everywhere, a little absorbed"


def test_pictures_and_volumes_are_those_of_the_program(program, tmp_path):
    scene = ball_scene()
    (tmp_path / "scene.json").write_text(scene.to_json())
    for command, output in (("trace", "theirs.vdb"), ("render", "theirs.exr")):
        extra = ["--parts"] if command == "trace" else []
        subprocess.run([program, command, "scene.json", "-o", output, "--quiet", *extra], cwd=tmp_path, check=True)
    session = volcaustic.Session(volcaustic.Scene.read(tmp_path / "scene.json"))
    volcaustic.write_vdb(tmp_path / "ours.vdb", session.photons(), session.medium(), parts=True)
    volcaustic.write_image(tmp_path / "ours.exr", session.view().image)
    grids = volcaustic.compare_vdb(tmp_path / "ours.vdb", tmp_path / "theirs.vdb")
    assert {"radiance", "direction", "emission", "density", "caustic", "direct"} == {grid.name for grid in grids}
    assert all(grid.maximum == 0 for grid in grids)
    ours, theirs = (volcaustic.read_image(tmp_path / f"{name}.exr") for name in ("ours", "theirs"))
    assert ours.channels == theirs.channels
    assert all(np.array_equal(ours[channel], theirs[channel]) for channel in ours.channels)


def test_media_are_those_of_the_program(program, tmp_path):
    corners, faces = octahedron()
    volcaustic.write_mesh(tmp_path / "body.ply", volcaustic.Mesh(corners, faces))
    subprocess.run([program, "mesh2vdb", "body.ply", "-o", "theirs.vdb", "--resolution", "20", "--ior", "1.33", "--quiet"],
                   cwd=tmp_path, check=True)
    mesh = volcaustic.read_mesh(tmp_path / "body.ply")
    theirs = volcaustic.read_medium(tmp_path / "theirs.vdb")
    ours = volcaustic.build_medium([volcaustic.Body(mesh, volcaustic.Material(index=1.33))], theirs.domain)
    assert np.array_equal(ours.index(), theirs.index()) and np.array_equal(ours.coverage(), theirs.coverage())


def test_bodies_by_priority():
    small, large = volcaustic.Shape.sphere(0.3), volcaustic.Shape.sphere(0.6)
    domain = volcaustic.domain_around(((-0.7,) * 3, (0.7,) * 3), resolution=21, padding=0)
    glass, water = volcaustic.Material(index=1.5), volcaustic.Material(name="water", index=1.33)
    for priority, expected in ((1, 1.5), (-1, 1.33)):
        bodies = [volcaustic.Body(small, glass, priority), volcaustic.Body(large, water)]
        medium = volcaustic.build_medium(bodies, domain, blur=1)
        assert medium.index(start=(10, 10, 10), stop=(11, 11, 11)).item() == pytest.approx(expected)
    with pytest.raises(TypeError, match="surface must be a Mesh or a Shape, not str"):
        volcaustic.Body("ball.ply")
    with pytest.raises(volcaustic.UsageError, match="supersample is 3"):
        volcaustic.build_medium([], domain, supersample=3)


def test_an_open_mesh_is_refused_where_it_must_be_exact(mesh):
    open_mesh = volcaustic.Mesh(mesh.positions, mesh.triangles[1:])
    domain = volcaustic.domain_around(open_mesh.bounds, resolution=8)
    with pytest.raises(volcaustic.InputError):
        volcaustic.build_medium([volcaustic.Body(open_mesh)], domain, fill="exact")


@pytest.mark.parametrize("box, keywords", [(((0, 0, 0), (0, 0, 0)), {}), (((0, 0, 0), (1, 1, float("inf"))), {}),
                                           (((0, 0, 0), (1, 1, 1)), {"resolution": 10**6})])
def test_boxes_that_are_none(box, keywords):
    with pytest.raises(volcaustic.UsageError):
        volcaustic.domain_around(box, **keywords)


def test_more_memory_than_allowed_is_refused_beforehand(scene):
    scene.volume.resolution = 32768
    with pytest.raises(volcaustic.Error):
        volcaustic.Session(scene, memory_limit=1 << 20).medium()
    huge = volcaustic.Domain((0, 0, 0), 1, (32768, 32768, 32768))
    with pytest.raises((MemoryError, ValueError)):
        volcaustic.sample_medium(huge, lambda x, y, z: 1.0)


@pytest.mark.parametrize("name", ["glass_ball.ply", "bunny.ply"])
def test_a_surface_comes_back_from_its_voxels(name):
    mesh = volcaustic.read_mesh(DATA / "meshes" / name)
    medium = volcaustic.build_medium([volcaustic.Body(mesh)], volcaustic.domain_around(mesh.bounds, resolution=40))
    report = volcaustic.check_mesh(volcaustic.surface_from_medium(medium))
    assert report.closed_and_consistent
    assert report.signed_volume == pytest.approx(volcaustic.check_mesh(mesh).signed_volume, rel=0.05)
