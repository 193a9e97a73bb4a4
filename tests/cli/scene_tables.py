"""The tables of docs/scene_file.md, from `volcaustic scene schema` on standard input."""

import json
import sys


def kind(field):
    if {"$ref": "#/$defs/shape"} in field.get("oneOf", []):
        return "[node](shape_file.md#nodes) or string"
    if "oneOf" in field:
        return '`"auto"` or `{min, max}`'
    if "enum" in field:
        return " ".join(f"`{json.dumps(value)}`" for value in field["enum"])
    if field["type"] == "array" and "properties" in field["items"]:
        return f"array of `{{{', '.join(field['items']['properties'])}}}`"
    if field["type"] == "array":
        return f"{field['minItems']} × {field['items']['type']}"
    return field["type"]


def limits(field):
    element = field.get("items", field)
    if "minimum" not in element:
        return ""
    return f"{element['minimum']:g} to {element['maximum']:g}"


def table(fields, required=()):
    lines = ["| key | type | range | default | meaning [unit] |", "|---|---|---|---|---|"]
    for key, field in fields.items():
        default = "required" if key in required else f"`{json.dumps(field['default'])}`"
        lines.append(f"| `{key}` | {kind(field)} | {limits(field)} | {default} | {field['description']} |")
    return "\n".join(lines)


def section_text(key, section, fields, level="###"):
    """The table of a section, then those of the lists inside it."""
    text = f"{level} `{key}`: {section['description']}\n\n{table(fields['properties'], fields.get('required', ()))}\n\n"
    for name, field in fields["properties"].items():
        if "properties" in field.get("items", {}):
            text += section_text(f"{key}[].{name}", field, field["items"], level + "#")
    return text


def tables(schema):
    """One table for each section, in the order of the schema."""
    text = ""
    for key, section in schema["properties"].items():
        fields = next((s for s in (section, section.get("items", {}), section.get("additionalProperties", {}))
                       if isinstance(s, dict) and "properties" in s), None)
        if fields:
            text += section_text(key, section, fields)
    return text.rstrip() + "\n"


if __name__ == "__main__":
    print(tables(json.load(sys.stdin)), end="")
