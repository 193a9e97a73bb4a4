"""pvpython check_paraview.py PROGRAM FILES OUT: ParaView opens a volume and a series through our reader, and shows them."""
import contextlib
import io
import json
import os
import subprocess
import sys

import numpy as np
from paraview import servermanager
from paraview.simple import (ColorBy, CreateView, Delete, GetColorTransferFunction, OpenDataFile, Render, SaveScreenshot,
                             Show)
from vtkmodules.util.numpy_support import vtk_to_numpy

PROGRAM, FILES, OUT = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tools", "plugins", "paraview"))
from load import OpenVDBVolumes  # noqa: E402


def program(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=True).stdout


def grids_of(file):
    return {g["name"]: g for g in json.loads(program("info", file, "--json"))["files"][0]["grids"]}


def write_series():
    scene = {"volcaustic": 1, "volume": {"bounds": {"min": [-1, -1, -2], "max": [1, 1, 1]}, "voxelSize": 0.1,
                                         "attenuation": [0.1] * 3, "scattering": [0.1] * 3},
             "objects": [{"shape": {"type": "ellipsoid", "semiAxes": [0.5, 0.5, 0.5]}}],
             "animation": {"/objects/0/translate": [[7, [-0.4, 0, 0]], [8, [0.4, 0, 0]]]},
             "lights": [{"direction": [0, 0, -1]}], "photons": {"grid": [128, 128]}}
    with open(os.path.join(OUT, "scene.json"), "w", encoding="utf-8") as file:
        json.dump(scene, file)
    program("trace", os.path.join(OUT, "scene.json"), "-o", os.path.join(OUT, "s.####.vdb"), "--frames", "7-8", "--quiet")
    return [os.path.join(OUT, f"s.{frame:04d}.vdb") for frame in (7, 8)]


def brightest(data, name="radiance"):
    """World position of the brightest point below the ball."""
    values = vtk_to_numpy(data.GetPointData().GetArray(name))
    points = np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())])
    light = np.where(points[:, 2] < -0.55, np.linalg.norm(values, axis=1), 0)
    return points[np.argmax(light)]


def test_a_file_opens_as_it_is():
    file = os.path.join(FILES, "light.vdb")
    reader = OpenDataFile(file)
    reader.UpdatePipeline()
    data = servermanager.Fetch(reader)
    grids = grids_of(file)
    assert {data.GetPointData().GetArrayName(i) for i in range(data.GetPointData().GetNumberOfArrays())} == set(grids)
    for name, grid in grids.items():
        values = vtk_to_numpy(data.GetPointData().GetArray(name))
        size = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
        assert abs(size.max() - grid["maximum"]) <= 1e-5 * grid["maximum"], (name, size.max(), grid["maximum"])
    spacing = data.GetSpacing()
    assert np.allclose(spacing, grids["radiance"]["voxelSize"])
    low = np.min([g["world"]["min"] for g in grids.values()], axis=0)
    high = np.max([g["world"]["max"] for g in grids.values()], axis=0)
    bounds = np.array(data.GetBounds()).reshape(3, 2)
    assert np.allclose(bounds[:, 0], low + np.array(spacing) / 2) and np.allclose(bounds[:, 1], high - np.array(spacing) / 2)
    Delete(reader)


def test_a_series_has_the_times_of_its_frames(series):
    reader = OpenVDBVolumes(FileNames=series)
    assert list(reader.TimestepValues) == [7, 8]
    reader.Grids = ["radiance"]
    for time, x in ((7, -0.4), (8, 0.4)):
        reader.UpdatePipeline(time)
        data = servermanager.Fetch(reader)
        assert data.GetPointData().GetNumberOfArrays() == 1
        place = brightest(data)
        assert abs(place[0] - x) < 0.11 and abs(place[1]) < 0.11 and -1 < place[2] < -0.5, (time, place)
    return reader


def test_a_picture_shows_the_caustic(reader):
    """From the front, x to the right and z upwards, the caustic of the second frame is to the right, below the middle."""
    view = CreateView("RenderView")
    view.ViewSize = [300, 450]
    view.Background = [0, 0, 0]
    view.UseColorPaletteForBackground = 0
    view.OrientationAxesVisibility = 0
    view.ViewTime = 8
    shown = Show(reader, view, "UniformGridRepresentation")
    shown.SetRepresentationType("Slice")
    shown.SliceMode = "XZ Plane"
    shown.Slice = 10
    ColorBy(shown, ("POINTS", "radiance", "Magnitude"))
    table = GetColorTransferFunction("radiance")
    table.ApplyPreset("Grayscale", True)
    table.RescaleTransferFunction(0, 2)
    Render(view)  # which sets the camera
    view.CameraParallelProjection = 1
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0, -10, -0.5], [0, 0, -0.5], [0, 0, 1]
    view.CameraParallelScale = 1.5
    Render(view)
    picture = os.path.join(OUT, "paraview.png")
    SaveScreenshot(picture, view)
    pixels = np.array(read_png(picture), float).sum(axis=2)
    assert pixels.max() > 600, "nothing is to be seen"
    rows, columns = np.nonzero(pixels > 0.9 * pixels.max())
    x = (columns.mean() + 0.5) / 300 * 2 - 1
    z = 1 - (rows.mean() + 0.5) / 450 * 3
    assert abs(x - 0.4) < 0.12 and -1.2 < z < -0.3, (x, z)


def read_png(path):
    from vtkmodules.vtkIOImage import vtkPNGReader
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1, :, :3]


def test_faults_are_sentences():
    broken = os.path.join(OUT, "broken.vdb")
    with open(broken, "wb") as file:
        file.write(b"no volume")
    for name, words in ((broken, "cannot be read"), (os.path.join(OUT, "absent.vdb"), "no such file")):
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            reader = OpenVDBVolumes(FileNames=[name])
            reader.UpdatePipeline()
        assert words in said.getvalue() and "Traceback" not in said.getvalue(), said.getvalue()


test_a_file_opens_as_it_is()
second = test_a_series_has_the_times_of_its_frames(write_series())
test_a_picture_shows_the_caustic(second)
test_faults_are_sentences()
print("ParaView opens volumes and series, and shows the caustic where it is")
