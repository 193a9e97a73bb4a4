"""check_openimageio.py PROGRAM PLUGIN OUT: OpenImageIO's programs and its Python open scenes through our plugin."""
import json
import os
import subprocess
import sys

PROGRAM, PLUGIN, OUT = sys.argv[1:4]
os.environ["OIIO_LIBRARY_PATH"] = os.path.dirname(PLUGIN)

import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402  (reads the variable)
import pyopenvdb as vdb  # noqa: E402

SCENE = os.path.join(OUT, "ball.volcaustic")
DIMS = (36, 24, 28)  # of the box, at 0.1


def call(*arguments):
    return subprocess.run(arguments, cwd=OUT, capture_output=True, text=True, check=False)


def succeed(*arguments):
    done = call(*arguments)
    assert done.returncode == 0, (arguments, done.stderr, done.stdout)
    return done.stdout


def write_scene():
    scene = {"volcaustic": 1, "frames": {"first": 2, "last": 4, "rate": 30},
             "volume": {"bounds": {"min": [-1.8, -1.2, -1.4], "max": [1.8, 1.2, 1.4]}, "voxelSize": 0.1,
                        "attenuation": [0.1, 0.2, 0.3], "scattering": [0.1, 0.1, 0.1]},
             "objects": [{"name": "ball", "shape": {"type": "ellipsoid", "semiAxes": [0.5, 0.6, 0.7]}}],
             "animation": {"/objects/0/translate": [[2, [-0.5, 0, 0]], [4, [0.5, 0, 0]]]},
             "lights": [{"direction": [0.3, 0.1, -1], "irradiance": [3, 2, 1]}], "photons": {"grid": [96, 64]},
             "camera": {"position": [0, -6, 0], "resolution": [80, 60]}}
    with open(SCENE, "w", encoding="utf-8") as file:
        json.dump(scene, file)
    succeed(PROGRAM, "render", SCENE, "-o", "r.####.exr", "--float", "--frames", "2-4")
    succeed(PROGRAM, "trace", SCENE, "-o", "l.####.vdb", "--frames", "2-4")


def opened(name):
    image = oiio.ImageInput.open(name)
    assert image, oiio.geterror()
    return image


def test_frames_are_sub_images():
    image = opened(SCENE)
    for subimage, frame in enumerate((2, 3, 4)):
        assert image.seek_subimage(subimage, 0)
        spec = image.spec()
        assert spec["Frame"] == frame and spec["FramesPerSecond"] == 30
        ours = image.read_image("float")
        with_program = opened(os.path.join(OUT, f"r.{frame:04d}.exr"))
        theirs = with_program.read_image("float")
        names = {n: i for i, n in enumerate(with_program.spec().channelnames)}
        assert sorted(spec.channelnames) == sorted(names)
        for i, name in enumerate(spec.channelnames):
            assert np.array_equal(ours[:, :, i], theirs[:, :, names[name]]), (frame, name)
    assert not image.seek_subimage(3, 0)


def test_grids_are_three_dimensional_images():
    file = os.path.join(OUT, "l.0004.vdb")
    for name, components in (("radiance", 3), ("emission", 3), ("density", 1), ("direction", 3)):
        image = opened(f"{SCENE}?grid={name}&frame=4")
        spec = image.spec()
        assert (spec.width, spec.height, spec.depth, spec.nchannels) == (*DIMS, components), name
        voxels = np.asarray(image.read_image("float")).reshape(DIMS[2], DIMS[1], DIMS[0], components)
        grid = vdb.read(file, name)
        wanted = np.empty((*DIMS, components) if components == 3 else DIMS, np.float32)
        grid.copyToArray(wanted)
        assert np.array_equal(voxels.transpose(2, 1, 0, 3).reshape(wanted.shape), wanted), name
        assert np.allclose(spec["minCorner"], (-1.8, -1.2, -1.4)) and abs(spec["voxelSize"] - 0.1) < 1e-7
    image = opened(SCENE + "?grid=index")
    assert image.spec().channelnames == ("index",)
    assert abs(np.asarray(image.read_image("float")).max() - 1.5) < 0.02


def test_places_in_the_scene_may_be_set():
    assert opened(SCENE + "?camera.resolution=[40,30]").spec().width == 40


def test_programs():
    assert "volcaustic" in succeed("oiiotool", "--help")
    assert "3 subimages" in succeed("iinfo", SCENE)
    succeed("oiiotool", SCENE, "--subimage", "frame 3", "--ch", "R,G,B", "-o", "frame.png")
    succeed("iconvert", SCENE + "?frame=2", "two.tif")
    assert oiio.ImageInput.open(os.path.join(OUT, "two.tif")).spec().nchannels == 21
    succeed("maketx", SCENE, "-o", "two.tx")  # looks for a file of that very name, so that it takes no arguments
    assert opened(os.path.join(OUT, "two.tx")).seek_subimage(0, 3), "a texture with mip levels"


def test_faults_are_one_sentence():
    with open(os.path.join(OUT, "broken.volcaustic"), "w", encoding="utf-8") as file:
        file.write('{"volcaustic": 1, "lights": [{"irradianc": [1,1,1]}]}')
    for name, words in ((SCENE + "?grid=radianse", "no such grid"), (SCENE + "?gird=x", "gird"),
                        (SCENE + "?frame=x", "no number"), (SCENE + "?frame=3x", "no number"), (SCENE + "?frame=99999999999", "no number"), (SCENE + "?photons.gird=[8,8]", "photons.gird"),
                        (os.path.join(OUT, "broken.volcaustic"), "/lights/0/irradianc")):
        assert not oiio.ImageInput.open(name)
        error = oiio.geterror()
        assert words in error and "\n" not in error.strip(), error
    library = dict(os.environ, LD_LIBRARY_PATH=OUT)
    with open(os.path.join(OUT, "libvolcaustic_c.so.1"), "w", encoding="utf-8") as file:
        file.write("no library")
    done = subprocess.run(["iinfo", SCENE], capture_output=True, text=True, check=False, env=library)
    assert "libvolcaustic_c.so.1" in done.stdout + done.stderr and "install volcaustic" in done.stdout + done.stderr


write_scene()
for test in (test_frames_are_sub_images, test_grids_are_three_dimensional_images, test_places_in_the_scene_may_be_set,
             test_programs, test_faults_are_one_sentence):
    test()
print("OpenImageIO", oiio.VERSION_STRING, "opens scenes")
