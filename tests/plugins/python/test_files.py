"""Files in and out: meshes, pictures, volumes; what is damaged or not there."""

import numpy as np
import pytest
from conftest import octahedron

import volcaustic


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.stl", "a.off"])
@pytest.mark.parametrize("binary", [True, False])
def test_meshes(name, binary, mesh, tmp_path):
    path = tmp_path / name
    volcaustic.write_mesh(path, mesh, binary=binary)
    again = volcaustic.read_mesh(str(path))
    assert volcaustic.check_mesh(again).signed_volume == pytest.approx(1 / 6)
    assert len(again.positions) == 6 and len(again.triangles) == 8


def test_a_report_of_an_open_mesh(mesh):
    report = volcaustic.check_mesh(volcaustic.Mesh(mesh.positions, mesh.triangles[1:]))
    assert report.open_edges == 3 and "3 open edges" in report.defects and report.shells[0].role == "open"
    whole = volcaustic.check_mesh(mesh)
    assert whole.defects == "" and whole.remarks == [] and whole.shells[0].role == "body"
    assert whole.shells[0].enclosed_by is None and whole.bounds == ((-0.5,) * 3, (0.5,) * 3)


def test_files_that_are_not_there_or_damaged(tmp_path):
    with pytest.raises(volcaustic.FileError, match="none.ply") as caught:
        volcaustic.read_mesh(tmp_path / "none.ply")
    assert isinstance(caught.value, OSError) and isinstance(caught.value, volcaustic.Error)
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 x\n")
    with pytest.raises(volcaustic.InputError, match="bad.obj:2"):
        volcaustic.read_mesh(tmp_path / "bad.obj")
    (tmp_path / "bad.vdb").write_bytes(b"\0" * 100)
    for read in (volcaustic.read_medium, volcaustic.inspect_vdb, volcaustic.surface_from_vdb):
        with pytest.raises(volcaustic.InputError, match="bad.vdb"):
            read(tmp_path / "bad.vdb", progress=lambda stage, fraction: None)
    (tmp_path / "bad.exr").write_bytes(b"v/1\x01" + b"\0" * 100)
    with pytest.raises(volcaustic.Error, match="bad.exr"):
        volcaustic.read_image(tmp_path / "bad.exr")
    with pytest.raises(TypeError):
        volcaustic.read_mesh(None)


def test_a_folder_that_cannot_be_written(mesh, tmp_path):
    with pytest.raises(volcaustic.FileError):
        volcaustic.write_mesh(tmp_path / "none" / "a.ply", mesh)
    with pytest.raises(volcaustic.UsageError):
        volcaustic.write_mesh(tmp_path / "a.xyz", mesh)
    assert list(tmp_path.iterdir()) == []


def test_pictures(tmp_path):
    random = np.random.default_rng(4).uniform(0, 2, (5, 7)).astype(np.float32)
    image = volcaustic.Image(7, 5, {"R": random, "G": random / 2, "B": random * 0, "extra.Y": -random})
    image.metadata = {"note": "by hand"}
    volcaustic.write_image(tmp_path / "a.exr", image, half=False)
    again = volcaustic.read_image(tmp_path / "a.exr")
    assert again.shape == (5, 7) and set(again.channels) == set(image.channels)
    assert all(np.array_equal(again[name], image[name]) for name in image.channels)
    assert again.metadata["note"] == "by hand"
    assert all(d.maximum == 0 for d in volcaustic.compare_images(image, again))
    volcaustic.write_image(tmp_path / "a.png", image, exposure=-1)
    png = volcaustic.read_image(tmp_path / "a.png")
    assert np.allclose(png["R"], np.clip(random / 2, 0, 1), atol=0.01)
    assert image._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(volcaustic.UsageError):
        volcaustic.write_image(tmp_path / "a.exr", image, layers=["none"])
    with pytest.raises(TypeError, match="layers must be a sequence"):
        volcaustic.write_image(tmp_path / "a.exr", image, layers="R")


def test_differences_that_are_seen():
    grey = volcaustic.Image(32, 24, {name: np.full((24, 32), 0.5) for name in "RGB"})
    other = grey.copy()
    assert volcaustic.flip_difference(grey, other).maximum == 0
    other["R"][10:14, 10:14] = 2
    seen = volcaustic.flip_difference(grey, other, high_dynamic_range=False)
    assert seen.map.shape == (24, 32) and seen.map[12, 12] > 0.2 > seen.map[2, 30] and seen.maximum == seen.map.max()
    assert grey["R"].max() == 0.5, "a copy is apart"
    assert volcaustic.difference_picture(seen.map).channels == ("R", "G", "B")
    with pytest.raises(volcaustic.InputError):
        volcaustic.flip_difference(grey, volcaustic.Image(3, 3, {"R": np.zeros((3, 3))}))
    with pytest.raises(volcaustic.UsageError, match="pixels_per_degree is 0"):
        volcaustic.flip_difference(grey, other, pixels_per_degree=0)


def test_volumes(finished, tmp_path):
    path = tmp_path / "light.vdb"
    light, medium = finished.photons(), finished.medium()
    volcaustic.write_vdb(path, light, medium, parts=True, metadata={"frame": "7"})
    info = volcaustic.inspect_vdb(path)
    assert {grid.name for grid in info.grids} == {"radiance", "direction", "emission", "density", "caustic", "direct"}
    assert info.metadata["frame"] == "7"
    radiance = next(grid for grid in info.grids if grid.name == "radiance")
    assert radiance.maximum == pytest.approx(
        np.linalg.norm(light.radiance.fluence() / (4 * np.pi), axis=-1).max(), rel=1e-5)
    again = volcaustic.read_radiance(path, medium.domain)
    assert np.allclose(again.fluence(), light.radiance.fluence(), rtol=1e-5, atol=1e-5)
    volcaustic.convert_vdb(path, tmp_path / "light.nvdb")
    assert {g.name for g in volcaustic.inspect_vdb(tmp_path / "light.nvdb").grids} == {g.name for g in info.grids}
    volcaustic.write_vdb(tmp_path / "alone.vdb", light.radiance, medium)
    assert all(d.maximum == 0 for d in volcaustic.compare_vdb(tmp_path / "alone.vdb", tmp_path / "alone.vdb"))


def test_media_in_files(finished, tmp_path):
    medium = finished.medium()
    volcaustic.write_vdb(tmp_path / "m.vdb", medium)
    again = volcaustic.read_medium(tmp_path / "m.vdb")
    assert again.domain == medium.domain and again.ambient == medium.ambient
    for field in ("index", "attenuation", "scattering", "coverage"):
        assert np.array_equal(getattr(again, field)(), getattr(medium, field)()), field
    assert len(volcaustic.surface_from_vdb(tmp_path / "m.vdb", grid="index", isovalue=1.25).triangles) > 100
    with pytest.raises(volcaustic.InputError, match="coverage"):
        volcaustic.surface_from_vdb(tmp_path / "m.vdb", grid="nothing")
    with pytest.raises(TypeError, match="give medium"):
        volcaustic.write_vdb(tmp_path / "m.vdb", finished.photons())
    with pytest.raises(TypeError, match="two media"):
        volcaustic.write_vdb(tmp_path / "m.vdb", medium, medium)
    with pytest.raises(TypeError, match="not str"):
        volcaustic.write_vdb(tmp_path / "m.vdb", "light", medium)


def test_stages(finished, tmp_path):
    files = {frame: tmp_path / f"light.{frame:04d}.vdb" for frame in (3, 2)}
    for file in files.values():
        volcaustic.write_vdb(file, finished.photons(), finished.medium(), preset="unreal")
    assert {grid.name for grid in volcaustic.inspect_vdb(files[2]).grids} == {"emission", "density"}
    volcaustic.write_usd(tmp_path / "light.usda", files, meters_per_unit=.01, up_axis="y", rate=25)
    stage = (tmp_path / "light.usda").read_text()
    for line in ("metersPerUnit = 0.01", 'upAxis = "Y"', "timeCodesPerSecond = 25", "startTimeCode = 2", "endTimeCode = 3",
                 "@./light.0003.vdb@"):
        assert line in stage, line
    volcaustic.write_usd(tmp_path / "one.usda", str(files[3]))
    assert "timeSamples" not in (tmp_path / "one.usda").read_text()
    with pytest.raises(volcaustic.UsageError, match="one.obj"):
        volcaustic.write_usd(tmp_path / "one.usda", tmp_path / "one.obj")
    with pytest.raises(TypeError):
        volcaustic.write_usd(tmp_path / "one.usda", {"first": files[3]})


def test_volumes_of_others_become_media(finished, tmp_path):
    path = tmp_path / "coverage.vdb"
    volcaustic.write_vdb(path, finished.medium())
    fog = volcaustic.import_medium(path, attenuation=volcaustic.GridMapping(grid="coverage", scale=(2, 2, 2)), padding=0)
    assert fog.attenuation().max() == pytest.approx(2) and fog.index().max() == 1
    glass = volcaustic.import_medium(path, body="coverage", material=volcaustic.Material(index=1.7), blur=1)
    assert glass.index().max() == pytest.approx(1.7)
    with pytest.raises(volcaustic.InputError, match="coverage"):
        volcaustic.import_medium(path, index="heat")
    with pytest.raises(TypeError, match="index must be a GridMapping"):
        volcaustic.import_medium(path, index=4)
    smoke = volcaustic.PropertyGrid(name="coverage", property="attenuation", scale=(3, 3, 3))
    volume = volcaustic.MediumVolume(path, [smoke])
    assert np.allclose(volume.bounds, ((-0.4,) * 3, (0.4,) * 3), atol=0.15)
    domain = volcaustic.domain_around(volume.bounds, resolution=24)
    medium = volcaustic.build_medium([], domain, volumes=[volume])
    assert medium.attenuation().max() == pytest.approx(3, rel=1e-5)


def test_matrices_place_as_placements_do(mesh):
    placement = volcaustic.Placement(translate=(1, 2, 3), scale=(2, 2, 2))
    matrix = np.array([(2, 0, 0, 1), (0, 2, 0, 2), (0, 0, 2, 3)])
    moved = mesh.transformed(placement).positions
    assert np.array_equal(moved, octahedron()[0] * 2 + (1, 2, 3))
    assert np.array_equal(moved, mesh.transformed(matrix).positions)
    assert np.array_equal(moved, mesh.transformed(np.vstack([matrix, (0, 0, 0, 1)])).positions)
    with pytest.raises(volcaustic.UsageError, match="ends with 0 0 0 1"):
        mesh.transformed(np.ones((4, 4)))
    mirror = volcaustic.check_mesh(mesh.transformed(np.diag((-1.0, 1, 1, 1))))
    assert mirror.signed_volume == pytest.approx(1 / 6)


def test_names_of_sequences():
    assert volcaustic.has_frame_place("a.####.vdb") and not volcaustic.has_frame_place("a.vdb")
    assert volcaustic.with_frame("a.####.vdb", 12) == "a.0012.vdb"
