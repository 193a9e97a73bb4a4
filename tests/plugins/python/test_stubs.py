"""The type stubs against the module, and the example against the stubs."""

import ast
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest

import volcaustic
from volcaustic import _core

PACKAGE = pathlib.Path(volcaustic.__file__).parent
SOURCES = pathlib.Path(__file__).parents[3]
STUB = ast.parse((PACKAGE / "_core.pyi").read_text())
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
# What Python or pybind11 gives every class, and what needs no words.
COMMON = re.compile(r"__\w+__|_repr_png_")


def signature(text):
    """What pybind11 writes in front of a docstring: {name of parameter}, whether there are more keywords."""
    inside = text[text.index("(") + 1:text.index(") ->")]
    names = re.findall(r"(?:^|, )(\*\*?\w+|\w+)(?=:|,|$)", inside)
    return [n for n in names if not n.startswith("*") and n not in ("self", "arg0")], "**kwargs" in inside


def parameters(node):
    every = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
    return [argument.arg for argument in every if argument.arg != "self"]


def members(node):
    found = {}
    for item in node.body:
        if isinstance(item, ast.FunctionDef):
            found[item.name] = item
        elif isinstance(item, ast.AnnAssign):
            found[item.target.id] = item
    return found


def test_the_stub_is_as_it_is_written():
    script = SOURCES / "tools/plugins/python/stubs/make_stubs.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr + "run tools/plugins/python/stubs/make_stubs.py"


def test_every_public_name_is_in_the_stub_and_none_more():
    public = {name for name in vars(_core) if not name.startswith("_")}
    assert public == set(FUNCTIONS) | set(CLASSES)
    assert public < set(volcaustic.__all__) and all(hasattr(volcaustic, name) for name in volcaustic.__all__)
    assert all(getattr(_core, name).__doc__ for name in public)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_parameters_of_functions(name):
    positional, keywords = signature(getattr(_core, name).__doc__)
    declared = parameters(FUNCTIONS[name])
    assert declared[:len(positional)] == positional
    assert keywords or declared == positional


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_members_of_classes(name):
    cls, declared = getattr(_core, name), members(CLASSES[name])
    real = {member for member in vars(cls) if not COMMON.fullmatch(member)}
    assert real == {member for member in declared if not COMMON.fullmatch(member)}
    for member, node in declared.items():
        if COMMON.fullmatch(member):
            continue
        thing = inspect.getattr_static(cls, member)
        if isinstance(thing, property):
            read_only = isinstance(node, ast.FunctionDef)
            assert (thing.fset is None) == read_only, f"{name}.{member}"
        else:
            assert isinstance(node, ast.FunctionDef)
            text = getattr(cls, member).__doc__
            positional, keywords = signature(text)
            # Shapes take their fields by position as well, which pybind11 calls *args.
            assert keywords or parameters(node) == positional, f"{name}.{member}"


def test_keywords_of_long_calls_are_those_that_are_taken():
    context = [field for field, *_ in _core._fields["Context"]] + ["progress", "log"]
    for name, node in FUNCTIONS.items():
        if signature(getattr(_core, name).__doc__)[1]:
            assert [argument.arg for argument in node.args.kwonlyargs][-len(context):] == context, name
            with pytest.raises((TypeError, volcaustic.Error)):
                getattr(_core, name)(no_such_keyword=1)


def test_every_keyword_of_the_stub_is_taken(tmp_path):
    """Each is known to the function: what is complained of is not the keyword."""
    mesh = volcaustic.Shape.sphere(1).triangulate(resolution=8)
    calls = {"write_mesh": (tmp_path / "a.ply", mesh), "check_mesh": (mesh,), "deform": (mesh, []),
             "control_topology": (mesh,), "find_self_intersections": (mesh,), "read_mesh": (tmp_path / "none",),
             "read_image": (tmp_path / "none",), "read_medium": (tmp_path / "none",), "inspect_vdb": (tmp_path / "none",),
             "import_medium": (tmp_path / "none",), "surface_from_vdb": (tmp_path / "none",)}
    for name, arguments in calls.items():
        for argument in FUNCTIONS[name].args.kwonlyargs:
            try:
                getattr(_core, name)(*arguments, **{argument.arg: object()})
            except TypeError as error:
                assert "unexpected keyword" not in str(error), (name, argument.arg)
            except volcaustic.Error:
                pass


def test_the_version_is_that_of_the_project():
    project = (SOURCES / "CMakeLists.txt").read_text()
    assert volcaustic.__version__ == re.search(r"project\(volcaustic VERSION ([\d.]+)", project).group(1)
    assert (PACKAGE / "py.typed").exists()


def test_mypy_finds_nothing_in_the_package_and_the_example(tmp_path):
    pytest.importorskip("mypy", reason="python3-mypy is not installed")
    example = SOURCES / "houdini_free_examples/10_python_notebook/notebook.py"
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import volcaustic\nvolcaustic.PhotonOptions(gird=(1, 2))\nvolcaustic.Shape.sphere('x')\n"
                     "volcaustic.Light(type='directionl')\nvolcaustic.Session(3)\nvolcaustic.none\n")
    command = [sys.executable, "-m", "mypy", "--strict", f"--cache-dir={tmp_path}/cache"]
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    for what in ([str(example)], ["-p", "volcaustic"]):
        done = subprocess.run([*command, *what], capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stdout
    done = subprocess.run([*command, str(wrong)], capture_output=True, text=True, env=environment)
    assert [int(line.split(":")[1]) for line in done.stdout.splitlines() if ": error:" in line] == [2, 3, 4, 5, 6], done.stdout
