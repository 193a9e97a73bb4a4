"""check_usd.py PROGRAM FILES OUT: stages for sequences and single volumes, ours and others', opened by OpenUSD."""
import json
import os
import shutil
import subprocess
import sys

from pxr import Gf, Usd, UsdGeom, UsdValidation, UsdVol

PROGRAM, FILES, OUT = sys.argv[1:4]
TYPES = {"Tree_float_5_4_3": "float", "Tree_vec3s_5_4_3": "float3"}
ROLES = {"invariant": "Color", "contravariant relative": "Vector"}
CLASSES = {"fog volume": "fogVolume", "level set": "levelSet", "unknown": "unknown"}


def run(*arguments):
    done = subprocess.run([PROGRAM, *arguments, "--json"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def complaints(stage):
    """Every validator that OpenUSD brings."""
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    return [f"{e.GetName()}: {e.GetMessage()}" for e in context.Validate(stage)]


def check(path, files, fields=None):
    """Opens a stage and compares what it says with the volumes; `files`: frame -> path. Returns stage and volume."""
    stage = Usd.Stage.Open(path)
    assert not complaints(stage), complaints(stage)
    volume = UsdVol.Volume(stage.GetDefaultPrim().GetChild("volume"))
    assert volume
    grids = {g["name"]: g for g in run("info", next(iter(files.values())))["files"][0]["grids"]}
    found = {}
    for relation, prim in volume.GetFieldPaths().items():
        asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(prim))
        assert asset, prim
        name = asset.GetFieldNameAttr().Get()
        found[name] = relation
        grid = grids[name]
        assert asset.GetFieldDataTypeAttr().Get() == TYPES[grid["type"]], name
        assert asset.GetFieldClassAttr().Get() == CLASSES[grid["class"]], (name, grid["class"])
        scalar = TYPES[grid["type"]] == "float"
        assert asset.GetVectorDataRoleHintAttr().Get() == ("None" if scalar else ROLES[grid["vectorType"]]), name
        for frame, file in files.items():
            resolved = asset.GetFilePathAttr().Get(frame).resolvedPath
            assert os.path.samefile(resolved, file), (frame, resolved)
    assert set(found) == set(fields or grids), found
    return stage, volume


def test_sequence():
    folder = os.path.join(OUT, "light @ night")
    os.mkdir(folder)
    scene = os.path.join(OUT, "scene.json")
    with open(scene, "w", encoding="utf-8") as file:
        json.dump({"volcaustic": 1, "frames": {"first": 1, "last": 3, "rate": 30},
                   "volume": {"bounds": {"min": [-1, -2, -1], "max": [1, 2, 1]}, "resolution": 32,
                              "attenuation": [0.1] * 3, "scattering": [0.1] * 3},
                   "objects": [{"shape": {"type": "ellipsoid", "semiAxes": [0.5, 0.5, 0.5]}}],
                   "lights": [{"direction": [0, 0, -1], "name": "key light"}, {"direction": [0, 1, -1], "name": "rim-1"}],
                   "photons": {"grid": [32, 32], "separate": True}, "camera": {"up": [0, 1, 0], "position": [0, 0, 5]}},
                  file)
    stage_file = os.path.join(OUT, "stage.usda")
    report = run("trace", scene, "-o", os.path.join(folder, "l.####.vdb"), "--frames", "1-3x2", "--usd", stage_file,
                 "--meters-per-unit", "0.01")
    assert stage_file in report["outputs"]
    files = {f: os.path.join(folder, f"l.{f:04d}.vdb") for f in (1, 3)}
    stage, volume = check(stage_file, files)
    assert {p.GetName() for p in volume.GetPrim().GetChildren()} >= {"radiance_key_light", "radiance_rim_1"}
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01 and UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1, 3, 30)
    extent = volume.GetExtentAttr().Get()
    assert Gf.IsClose(extent[0], Gf.Vec3f(-1, -2, -1), 1e-6) and Gf.IsClose(extent[1], Gf.Vec3f(1, 2, 1), 1e-6), extent
    before = open(stage_file, encoding="utf-8").read()
    run("trace", scene, "-o", os.path.join(folder, "l.####.vdb"), "--frames", "1-3x2", "--usd", stage_file,
        "--meters-per-unit", "0.01", "--resume")
    assert open(stage_file, encoding="utf-8").read() == before, "frames that are there are named, too"
    run("trace", scene, "-o", os.path.join(folder, "l.####.vdb"), "--frames", "1-3x2", "--usd", stage_file,
        "--up-axis", "z", "--resume")
    assert 'upAxis = "Z"' in open(stage_file, encoding="utf-8").read()


def test_volumes_of_others():
    """A box that changes is time sampled, and a single file is a value, not a sample."""
    for frame, source in ((1, "medium.vdb"), (2, "light.vdb")):
        shutil.copy(os.path.join(FILES, source), os.path.join(OUT, f"mixed.{frame:04d}.vdb"))
    stage_file = os.path.join(OUT, "mixed.usda")
    run("convert", os.path.join(OUT, "mixed.####.vdb"), stage_file, "--frames", "1-2", "--rate", "25")
    stage = Usd.Stage.Open(stage_file)
    assert not complaints(stage)
    volume = UsdVol.Volume(stage.GetDefaultPrim().GetChild("volume"))
    assert volume.GetExtentAttr().Get(1) != volume.GetExtentAttr().Get(2)
    assert stage.GetTimeCodesPerSecond() == 25
    for field, frames in (("index", {1}), ("emission", {2})):  # only the frames that have such a grid
        asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(volume.GetFieldPath(field)))
        for frame in (1, 2):
            assert bool(asset.GetFilePathAttr().Get(frame)) == (frame in frames), (field, frame)
    single = os.path.join(OUT, "single.usda")
    run("convert", os.path.join(FILES, "half.vdb"), single)
    stage, volume = check(single, {1: os.path.join(FILES, "half.vdb")})
    asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(volume.GetFieldPath("radiance")))
    assert asset.GetFilePathAttr().GetNumTimeSamples() == 0 and not stage.HasAuthoredTimeCodeRange()


def test_the_validators_can_complain():
    text = open(os.path.join(OUT, "single.usda"), encoding="utf-8").read()
    broken = os.path.join(OUT, "broken.usda")
    with open(broken, "w", encoding="utf-8") as file:
        file.write(text.replace('    defaultPrim = "volcaustic"\n', ""))
    assert complaints(Usd.Stage.Open(broken))


def test_faults_are_one_line():
    for arguments, status, words in (
            (["convert", os.path.join(FILES, "light.nvdb"), os.path.join(OUT, "x.usda")], 2, ".vdb"),
            (["convert", os.path.join(FILES, "absent.vdb"), os.path.join(OUT, "x.usda")], 3, "absent.vdb"),
            (["trace", os.path.join(OUT, "scene.json"), "-o", os.path.join(OUT, "x.nvdb"), "--usd",
              os.path.join(OUT, "x.usda")], 2, "--usd"),
            (["trace", os.path.join(OUT, "scene.json"), "-o", os.path.join(OUT, "x.vdb"), "--usd",
              os.path.join(OUT, "x.usd")], 2, ".usda")):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
        assert done.returncode == status, (arguments, done.returncode, done.stderr)
        assert len(done.stderr.splitlines()) == 1 and words in done.stderr, done.stderr
        assert not os.path.exists(os.path.join(OUT, "x.usda"))


for test in (test_sequence, test_volumes_of_others, test_the_validators_can_complain, test_faults_are_one_line):
    test()
print("OpenUSD", ".".join(map(str, Usd.GetVersion())), "opens our stages, and its validators are content")
