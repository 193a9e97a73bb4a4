#!/usr/bin/python3
"""Checks every #include against the dependency rules of docs/architecture.md. Standard library only.

    tools/dev/check_includes.py               checks the sources; prints "file:line: ..." for each violation
    tools/dev/check_includes.py --self-test   checks that the rules catch what they are there to catch
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIBRARY = "libvolcaustic"

# Folder of the library -> folders whose private headers it may include.
FOLDERS = {
    "core": {"core"},
    "shapes": {"core", "shapes"},
    "mesh": {"core", "shapes", "mesh"},
    "polygonise": {"core", "shapes", "mesh", "polygonise"},
    "deform": {"core", "mesh", "deform"},
    "simulation": {"core", "mesh", "volume", "simulation"},
    "kernels": {"kernels"},
    "backends": {"core", "kernels", "backends"},
    "volume": {"core", "shapes", "mesh", "volume", "kernels", "backends"},
    "transport": {"core", "volume", "kernels", "backends", "transport"},
    "image": {"core", "image"},
    "scene": {"core", "shapes", "scene"},
    "session": {"core", "scene", "volume", "transport", "session"},
}

# Public headers that are not for everybody -> patterns of the files inside the repository that may include them.
PUBLIC = {
    "volcaustic/session.h": [f"{LIBRARY}/session/", f"{LIBRARY}/include/volcaustic/(volcaustic|live).h"],
    "volcaustic/live.h": [f"{LIBRARY}/session/", f"{LIBRARY}/include/volcaustic/volcaustic.h"],
    "volcaustic/openvdb.h": [f"{LIBRARY}/volume/"],
    "volcaustic/volcaustic.h": [],
}

# Other people's headers: what they are called -> pattern of their names, and the files that may name them. A header that
# no pattern knows is a new dependency: give it a row here and a reason in docs/architecture.md.
EXTERNAL = {
    "OpenVDB": (r"(openvdb|nanovdb)/", [f"{LIBRARY}/(volume|simulation)/", f"{LIBRARY}/include/volcaustic/openvdb.h",
                                      "tools/plugins/python/medium_grids."]),
    "OpenMesh": (r"OpenMesh/", [f"{LIBRARY}/(mesh|deform)/"]),
    "Eigen": (r"Eigen/", [f"{LIBRARY}/(deform|simulation)/"]),
    "Bullet": (r"(Bullet\w+/|LinearMath/|bullet/|bt[A-Z]\w+\.h)", [f"{LIBRARY}/simulation/"]),
    "GLFW": (r"GLFW/", ["tools/viewer/"]),
    "Dear ImGui": (r"(imgui|backends/imgui)", ["tools/viewer/"]),
    "OpenGL": (r"(GL|GLES\w*|KHR)/", ["tools/viewer/"]),
    "nlohmann/json": (r"nlohmann/", [f"{LIBRARY}/scene/", f"{LIBRARY}/session/", "tools/"]),
    "OpenEXR": (r"(OpenEXR/|Imath/|Imf\w*\.h|Imath\w*\.h|Iex\w*\.h|half\.h)", [f"{LIBRARY}/image/"]),
    "OpenImageIO": (r"OpenImageIO/", [f"{LIBRARY}/image/", "tools/plugins/openimageio/"]),
    "pybind11": (r"pybind11/", ["tools/plugins/python/"]),
    "the C interface": (r"volcaustic_c\.h$", ["tools/plugins/", "houdini_free_examples/"]),
    "oneTBB": (r"(oneapi/)?tbb/", [f"{LIBRARY}/core/parallel."]),
    "Highway": (r"hwy/", [f"{LIBRARY}/backends/highway_lanes.h"]),
    "CUDA": (r"(cuda|cub/|thrust/|cooperative_groups)", [rf"{LIBRARY}/backends/\w+\.cuh?$"]),
    "x86 intrinsics": (r"immintrin\.h$", ["tools/cli/bench_limits."]),
    "CLI11": (r"CLI/", ["tools/cli/", "tools/viewer/main."]),
    "fmt": (r"fmt/", ["tools/cli/"]),
    "POSIX": (r"(sys/\w+|unistd|fcntl|signal|poll|spawn|dirent|pthread|dlfcn|malloc)\.h$",
              [f"{LIBRARY}/(core|mesh|volume|backends|image)/", "tools/", "houdini_free_examples/11_c_host/"]),
}

INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')
STANDARD = re.compile(r"[a-z_0-9]+$|c?(assert|errno|float|inttypes|limits|math|stddef|stdint|stdio|stdlib|string|time)\.h$")


def allowed(path, patterns):
    return any(re.match(pattern, path) for pattern in patterns)


def library_folder(path):
    """The folder of the library that a file belongs to, "include" for a public header, or None."""
    match = re.match(rf"{LIBRARY}/(\w+)/", path)
    return match.group(1) if match else None


def violation(path, bracket, header):
    """Why `path` (relative to the root) may not include `header`, or None."""
    if bracket == "<" and STANDARD.match(header):
        return None
    if header.startswith("volcaustic/"):
        return public_violation(path, header)
    if bracket == "<":
        return external_violation(path, header)
    return private_violation(path, header)


def public_violation(path, header):
    if library_folder(path) == "kernels":
        return "kernels include only the standard library and kernels"
    if library_folder(path) and header in PUBLIC and not allowed(path, PUBLIC[header]):
        return f"{header} is not for this part of the library"
    return None


def external_violation(path, header):
    for name, (pattern, places) in EXTERNAL.items():
        if re.match(pattern, header):
            return None if allowed(path, places) else f"{name} may be named only by {', '.join(places)}"
    return f"<{header}> is a dependency that tools/dev/check_includes.py has no rule for"


def private_violation(path, header):
    if ".." in header.split("/"):
        return "includes go downwards from a root, never through .."
    folder = library_folder(path)
    target = header.split("/")[0]
    if folder is None:
        return f"{path.split('/')[0]} includes public headers only" if target in FOLDERS else None
    if folder == "include":
        return "public headers include the standard library and public headers only"
    if target not in FOLDERS:
        return 'private headers are included as "folder/header.h"'
    if target not in FOLDERS.get(folder, set()):
        return f"{folder} may not depend on {target}"
    return None


def check_text(path, text):
    """Messages for every violation in a file's text."""
    messages = []
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        reason = match and violation(path, *match.groups())
        if reason:
            messages.append(f"{path}:{number}: {reason}")
    return messages


def check_tree():
    messages, files = [], 0
    for folder in (LIBRARY, "tools", "houdini_free_examples"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in {".h", ".cpp", ".cu", ".cuh", ".c"}:
                files += 1
                messages += check_text(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    for message in messages:
        print(message)
    print(f"{files} files, {len(messages)} violations")
    return 1 if messages or not files else 0


def self_test():
    bad = [
        (f"{LIBRARY}/kernels/march.h", '#include "volcaustic/types.h"'),
        (f"{LIBRARY}/kernels/march.h", '#include "core/parallel.h"'),
        (f"{LIBRARY}/kernels/march.h", "#include <cuda_runtime.h>"),
        (f"{LIBRARY}/kernels/march.h", "#include <unistd.h>"),
        (f"{LIBRARY}/mesh/read.cpp", "#include <openvdb/openvdb.h>"),
        (f"{LIBRARY}/mesh/read.cpp", '#include "volume/grids.h"'),
        (f"{LIBRARY}/mesh/read.cpp", '#include "volcaustic/session.h"'),
        (f"{LIBRARY}/volume/optics.cpp", '#include "transport/radiance.h"'),
        (f"{LIBRARY}/volume/optics.cpp", "#include <tbb/parallel_for.h>"),
        (f"{LIBRARY}/volume/optics.cpp", "  #  include <OpenMesh/Core/IO/MeshIO.hh>"),
        (f"{LIBRARY}/transport/view.cpp", "#include <nanovdb/NanoVDB.h>"),
        (f"{LIBRARY}/transport/view.cpp", '#include "volcaustic/openvdb.h"'),
        (f"{LIBRARY}/transport/view.cpp", '#include "session/session.h"'),
        (f"{LIBRARY}/backends/cpu_tracer.cpp", "#include <cuda_runtime.h>"),
        (f"{LIBRARY}/backends/devices.cpp", "#include <tbb/info.h>"),
        (f"{LIBRARY}/scene/scene_read.cpp", "#include <OpenEXR/ImfArray.h>"),
        (f"{LIBRARY}/image/read.cpp", "#include <nlohmann/json.hpp>"),
        (f"{LIBRARY}/image/read.cpp", "#include <boost/any.hpp>"),
        (f"{LIBRARY}/core/hash.h", '#include "parallel.h"'),
        (f"{LIBRARY}/include/volcaustic/mesh.h", '#include "core/hash.h"'),
        (f"{LIBRARY}/include/volcaustic/mesh.h", "#include <openvdb/openvdb.h>"),
        ("tools/cli/main.cpp", '#include "core/parallel.h"'),
        ("tools/cli/main.cpp", '#include "../../libvolcaustic/core/parallel.h"'),
        ("houdini_free_examples/01_glass_ball/main.cpp", '#include "kernels/march.h"'),
    ]
    good = [
        (f"{LIBRARY}/kernels/march.h", "#include <cmath>"),
        (f"{LIBRARY}/kernels/march.h", '#include "kernels/vec.h"'),
        (f"{LIBRARY}/volume/flatten.cpp", '#include "kernels/flat_medium.h"'),
        (f"{LIBRARY}/volume/flatten.cpp", "#include <nanovdb/NanoVDB.h>"),
        (f"{LIBRARY}/core/parallel.cpp", "#include <tbb/parallel_for.h>"),
        (f"{LIBRARY}/backends/cuda_tracer.cu", "#include <cuda_runtime.h>"),
        (f"{LIBRARY}/backends/cuda_memory.cuh", "#include <cuda_runtime.h>"),
        (f"{LIBRARY}/session/session.cpp", '#include "volcaustic/session.h"'),
        (f"{LIBRARY}/include/volcaustic/openvdb.h", "#include <openvdb/openvdb.h>"),
        ("tools/cli/main.cpp", '#include "volcaustic/session.h"'),
        ("tools/cli/main.cpp", '#include "commands.h"'),
        ("tools/cli/main.cpp", "#include <CLI/CLI.hpp>"),
        ("houdini_free_examples/01_glass_ball/main.cpp", "#include <volcaustic/volcaustic.h>"),
    ]
    wrong = [f"not caught: {path}: {line}" for path, line in bad if not check_text(path, line)]
    wrong += [f"caught without reason: {path}: {line}" for path, line in good if check_text(path, line)]
    for message in wrong:
        print(message)
    print(f"{len(bad)} violating and {len(good)} good lines, {len(wrong)} judged wrongly")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(self_test() if sys.argv[1:] == ["--self-test"] else check_tree())
