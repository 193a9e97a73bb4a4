"""make_stubs.py [--check]: writes volcaustic/_core.pyi from core.pyi.in and the descriptions in the built module.

A template names a described struct (@class Camera@, @keywords PhotonOptions@) and never a field of it. Run it with the built
package on PYTHONPATH; --check only says whether the file is as it would be written.
"""

import pathlib
import re
import sys
import textwrap

from volcaustic import _core

FOLDER = pathlib.Path(__file__).resolve().parent
STUB = FOLDER.parent / "volcaustic" / "_core.pyi"
WIDTH = 120
SET_OPERATIONS = ("union", "intersection", "difference")


def taken(annotation):
    """What a keyword takes, of a field that gives back `annotation`."""
    if annotation.startswith("tuple[tuple["):
        return "Numbers"
    if re.fullmatch(r"tuple\[float(, (float|\.\.\.))*\]", annotation):
        return "Vector"
    if annotation.startswith(("tuple[", "list[")):
        return "Sequence[" + re.match(r"\w+\[(\w+)", annotation).group(1) + "]"
    return annotation.replace("Box", "BoxLike")


def given(annotation):
    return annotation.replace("StrPath", "str")


def keywords(name):
    return [f"{field}: {taken(annotation)}" + ("" if required else " = ...")
            for field, annotation, _, _, required in sorted(_core._fields[name], key=lambda f: not f[4])]


def positional(name):
    """In described order, which positional arguments follow; so what comes after a default has one, too."""
    parameters = [f"{field}: {taken(annotation)}" + ("" if required else " = ...")
                  for field, annotation, _, _, required in _core._fields[name]]
    first = next((i for i, p in enumerate(parameters) if p.endswith("= ...")), len(parameters))
    return parameters[:first] + optional(parameters[first:])


def context():
    return keywords("Context") + ["progress: Progress | None = ...", "log: Log | None = ..."]


def signature(head, parameters, result):
    line = f"{head}({', '.join(parameters)}) -> {result}: ..."
    if len(line) <= WIDTH:
        return [line]
    packed = [""]
    for parameter in parameters:
        if len(packed[-1]) + len(parameter) > WIDTH - 10:
            packed.append("")
        packed[-1] += f" {parameter},"
    return [head + "("] + ["    " + line.strip() for line in packed] + [f") -> {result}: ..."]


def described_class(name):
    lines = [f"class {name}:", *wrapped_doc(getattr(_core, name).__doc__, "    "), ""]
    lines += ["    " + line for line in signature("def __init__", ["self", "*", *keywords(name)], "None")]
    for field, annotation, _, text, _ in _core._fields[name]:
        lines += [f"    {field}: {given(annotation)}", *wrapped_doc(text, "    ")]
    lines += ["    " + line for line in signature("def replace", ["self", "*", *optional(keywords(name))], name)]
    return lines + ["    def to_dict(self) -> dict[str, Any]: ...", "    __hash__ = None  # type: ignore[assignment]", ""]


def optional(parameters):
    return [p if p.endswith("= ...") else p + " = ..." for p in parameters]


def wrapped_doc(text, indent):
    lines = textwrap.wrap(text.replace('"', "'"), WIDTH - len(indent) - 6)
    return textwrap.indent('"""' + "\n".join(lines) + '"""', indent).split("\n")


def shape_factories():
    lines = []
    for name in (key.removeprefix("Shape.") for key in _core._fields if key.startswith("Shape.")):
        parameters, static = positional("Shape." + name), isinstance(vars(_core.Shape)[name], staticmethod)
        if name in SET_OPERATIONS:
            parameters = ["*shapes: Shape", *parameters]
        elif not static:
            parameters = ["self", *parameters]
        lines += (["@staticmethod"] if static else []) + signature("def " + name, parameters, "Shape")
    return lines


def exceptions():
    lines = []
    for name in ("Error", "UsageError", "InputError", "FileError", "DeviceError", "Cancelled", "InternalError"):
        bases = ", ".join(base.__name__ for base in getattr(_core, name).__bases__)
        lines += [f"class {name}({bases}):", *wrapped_doc(getattr(_core, name).__doc__, "    "), ""]
    return lines


VOXELS = ["start: Sequence[int] | NDArray[Any] | None = ...", "stop: Sequence[int] | NDArray[Any] | None = ...",
          "out: FloatArray | None = ..."]


def parameters_of(text):
    """The parameters of a signature in the template, each placeholder replaced by what it stands for."""
    parameters = []
    for part in re.split(r",\s*(?![^\[\]]*\])", text.strip().strip(",")):
        if part == "@context@":
            parameters += context()
        elif part == "@voxels@":
            parameters += VOXELS
        elif part.startswith("@keywords "):
            parameters += keywords(part.strip("@").split()[1])
        elif part.strip():
            parameters.append(part.strip())
    return parameters


def documentation(path):
    """The docstring of what the template declares, without the signature that pybind11 puts in front."""
    thing = _core
    for name in path:
        thing = getattr(thing, name, None)
    text = getattr(thing, "__doc__", None) or ""
    return re.sub(r"^\w+\(.*\n\n?", "", text).strip()


def expanded(template):
    lines, inside = [], []
    pieces = re.split(r"(?m)^( *)(def \w+)\(((?:[^()]|\n)*)\) -> (.+?): \.\.\.$", template)
    for i in range(0, len(pieces), 5):
        for line in pieces[i].strip("\n").split("\n") if pieces[i].strip("\n") else []:
            if match := re.fullmatch(r"@class (\w+)@", line):
                lines += described_class(match.group(1))
            elif line.strip() == "@shapes@":
                lines += ["    " + text for text in shape_factories()]
            elif line == "@exceptions@":
                lines += exceptions()
            else:
                if match := re.match(r"class (\w+)", line):
                    lines += ["", line, *wrapped_doc(documentation([match.group(1)]), "    "), ""]
                    inside = [match.group(1)]
                else:
                    lines.append(line)
        if i + 4 < len(pieces):
            indent, head, parameters, result = pieces[i + 1:i + 5]
            inside = inside if indent else []
            made = signature(head, parameters_of(parameters), result)
            lines += [indent + line for line in with_doc(made, documentation([*inside, head.split()[1]]), bool(indent))]
    return lines


def with_doc(made, text, member):
    """Functions and methods carry their docstrings; those of properties and of Python's own methods speak for themselves."""
    if not text or (member and made[0].startswith("def __")):
        return made
    return [*made[:-1], made[-1].removesuffix(" ..."), *wrapped_doc(text, "    ")]


def stub():
    head = ["# Written by make_stubs.py from core.pyi.in and the described options; change those.", ""]
    text = "\n".join(head + expanded((FOLDER / "core.pyi.in").read_text()))
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def main():
    if sys.argv[1:] == ["--check"]:
        if STUB.read_text() == stub():
            return 0
        print(f"{STUB.name} is not as make_stubs.py writes it", file=sys.stderr)
        return 1
    STUB.write_text(stub())
    return 0


if __name__ == "__main__":
    sys.exit(main())
