"""The tables of docs/shape_file.md, from `volcaustic scene schema --shape` on standard input."""

import json
import sys

from scene_tables import limits, table


def kind(field):
    """The type of a field in words, arrays in arrays too."""
    if "$ref" in field:
        return "node"
    if field["type"] == "object":
        return f"`{{{', '.join(field['properties'])}}}`"
    if field["type"] != "array":
        return field["type"]
    count = f"{field['minItems']} × " if "maxItems" in field else "array of "
    inner = kind(field["items"])
    return count + (f"({inner})" if "×" in inner else inner)


def innermost(field):
    return innermost(field["items"]) if "items" in field else field


def row(key, field, required):
    default = "required" if key in required else f"`{json.dumps(field['default'])}`"
    return f"| `{key}` | {kind(field)} | {limits(innermost(field))} | {default} | {field['description']} |"


def table_of(definition, left_out):
    rows = [row(key, field, definition.get("required", ()))
            for key, field in definition["properties"].items() if key not in left_out]
    return "\n".join(table({}).splitlines() + rows)


def tables(schema):
    """What every node takes, what quadrics take, then each type with what is its own."""
    definitions = schema["$defs"]
    common = [key for key in definitions["use"]["properties"] if key != "use"]
    deviations = definitions["sphere"]["properties"]["deviations"]
    text = f"### Every node\n\n{table_of(definitions['use'], ['use'])}\n\n"
    text += f"### `deviations` of quadrics: {deviations['description']}\n\n{table_of(deviations['items'], [])}\n\n"
    for name, definition in definitions.items():
        if name == "shape":
            continue
        quadric = " (a quadric)" if "deviations" in definition["properties"] else ""
        own = table_of(definition, ["type", "deviations", *common])
        text += f"### `{name}`{quadric}\n\n{own}\n\n"
    return text.rstrip() + "\n"


if __name__ == "__main__":
    print(tables(json.load(sys.stdin)), end="")
