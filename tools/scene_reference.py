#!/usr/bin/env python3
"""Make docs/reference/scene.md from schema/scene.schema.json, or check that it is current (--check)."""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCHEMA = ROOT / "schema" / "scene.schema.json"
PAGE = ROOT / "docs" / "reference" / "scene.md"

HEAD = """# The scene file: every key

<!-- made by tools/scene_reference.py from schema/scene.schema.json; change that file instead -->

A scene is one YAML 1.2 document (JSON is YAML too). Point your editor's YAML language server to
`schema/scene.schema.json` and it completes these keys.

**Numbers** are SI. Any number may be written as a constant expression with a unit behind it: `1/120`,
`210 GPa`, `2*3 mm`, `1.1 g/cm^3`, `20 deg`. A unit of the wrong dimension is an error. Units: m, g, s, N,
Pa, J, W, Hz, rad, L, bar with the prefixes T G M k h da d c m u n p; deg, t, min, h, in, ft; and products
of their powers such as `kg/m^3`, `N/mm^2`, `1/s`. An angle without unit is in radians.

**Expressions**: where a table says *varies with*, a string of these variables may stand for the number:
`"0.1*t*sin(2*pi*x)"`. x, y, z are the placed rest position [m], t the time [s]; value and label what the
image of the body shows there (images.md). Operators: `+ - * / ^`,
comparisons, `&& ||`, `c ? a : b`. Functions: sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh
atanh exp log (natural) ln log2 log10 sqrt abs sign rint min max sum avg. Constant: pi.

**Not built yet** marks what the format knows and this version refuses, with a message that says so.

"""


def resolve(schema, node):
    """A node with what its $ref holds filled in; its own keywords win."""
    merged = {}
    if "$ref" in node:
        merged.update(resolve(schema, schema["$defs"][node["$ref"].rsplit("/", 1)[1]]))
    merged.update(node)
    return merged


def types(node):
    kind = node.get("type", [])
    return kind if isinstance(kind, list) else [kind]


def bounds(node):
    signs = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    return ", ".join(f"{sign} {node[key]:g}" for key, sign in signs.items() if key in node)


def words(node):
    unbuilt = node.get("x-unbuilt", [])
    return ", ".join(f"`{w}`" + (" *(not built yet)*" if w in unbuilt else "") for w in node["enum"])


def anchor(name):
    return f"[{name}](#{name.replace('_', '-')})"


def object_name(node):
    """Name of the definition that a node points to, where it has a section of its own."""
    return node["$ref"].rsplit("/", 1)[1] if "$ref" in node else None


def describe(schema, node, sections):
    name = object_name(node)
    if name in sections:
        return anchor(name)
    node = resolve(schema, node)
    if "anyOf" in node:
        return " or ".join(describe(schema, choice, sections) for choice in node["anyOf"])
    if "enum" in node:
        return words(node)
    kind = types(node)
    if "array" in kind:
        count = f"{node['minItems']} " if node.get("minItems") == node.get("maxItems") and "minItems" in node else ""
        each = describe(schema, node["items"], sections) if "items" in node else "values"
        return f"list of {count}" + re.sub(r"^(number|integer|list)\b", r"\1s", each)
    if "object" in kind:
        keys = ", ".join(f"`{key}`" for key in node.get("properties", {}))
        return f"mapping of {keys}" if keys else "mapping"
    if "boolean" in kind:
        return "`true`, `false`"
    if "number" in kind or "integer" in kind:
        text = "integer" if "integer" in kind else "number"
        limits = bounds(node)
        built = f", up to {node['x-built-maximum']} built yet" if "x-built-maximum" in node else ""
        empty = " or `null`" if "null" in kind else ""
        return text + (f" {limits}" if limits else "") + built + empty
    return "text" if "string" in kind else "value"


def default_text(node):
    if "default" not in node or node["default"] in ({}, [], ""):
        return ""
    value = node["default"]
    return f"`{value}`" if isinstance(value, str) else f"`{json.dumps(value)}`"


def unit_text(schema, node):
    node = resolve(schema, node)
    unit = node.get("x-unit")
    if unit is None:
        for choice in node.get("anyOf", []) + [node.get("items", {})]:
            unit = resolve(schema, choice).get("x-unit", unit)
    return "" if unit in (None, "1") else unit


def varies_text(schema, node):
    node = resolve(schema, node)
    names = node.get("x-varies") or next(
        (resolve(schema, c)["x-varies"] for c in node.get("anyOf", []) if "x-varies" in resolve(schema, c)), None)
    words = {"v": "value, label"}
    return f" Varies with {', '.join(words.get(n, n) for n in names)}." if names else ""


def one_of(node):
    return [choice["required"][0] for choice in node.get("oneOf", []) if "required" in choice]


def table(schema, node, sections, prefix=""):
    rows = []
    for key, value in node.get("properties", {}).items():
        merged = resolve(schema, value)
        need = " *(required)*" if key in node.get("required", []) else ""
        state = " **Not built yet.**" if merged.get("x-built", True) is False else ""
        if isinstance(merged.get("x-built-maximum"), int) and "array" in types(merged):
            state = f" **This version takes {merged['x-built-maximum']}.**"
        text = (merged.get("description", "") + varies_text(schema, value) + state).strip()
        rows.append(f"| `{prefix}{key}`{need} | {describe(schema, value, sections)} | {unit_text(schema, value)} "
                    f"| {default_text(merged)} | {text} |")
        forms = [f for f in [value] + value.get("anyOf", []) if "properties" in f and f.get("x-built", True)]
        nested = forms[0] if len(forms) == 1 else None
        if nested and object_name(value) not in sections:
            rows += table(schema, nested, sections, f"{prefix}{key}.")
    return rows


def section(schema, title, node, sections):
    lines = [f"## {title}", ""]
    if node.get("description") and title != "scene":
        lines += [node["description"], ""]
    choices = one_of(node)
    if choices:
        lines += ["Exactly one of " + ", ".join(f"`{c}`" for c in choices) + ".", ""]
    lines += ["| key | value | unit | default | meaning |", "| --- | --- | --- | --- | --- |"]
    lines += table(schema, node, sections) + [""]
    return lines


def objects(schema):
    """Definitions with properties; a choice of forms is shown by its mapping."""
    found = {}
    for name, node in schema["$defs"].items():
        forms = [node] + node.get("anyOf", [])
        form = next((f for f in forms if "properties" in f), None)
        if form:
            found[name] = form
    return found


def page(schema):
    sections = objects(schema)
    lines = section(schema, "scene", schema, sections)
    for name, node in sections.items():
        lines += section(schema, name.replace("_", "-"), node, sections)
    return HEAD + "\n".join(lines).rstrip() + "\n"


def main():
    text = page(json.loads(SCHEMA.read_text()))
    if "--check" not in sys.argv:
        PAGE.parent.mkdir(parents=True, exist_ok=True)
        PAGE.write_text(text)
        return 0
    if PAGE.exists() and PAGE.read_text() == text:
        return 0
    print(f"{PAGE.relative_to(ROOT)} is not what the schema says; run tools/scene_reference.py", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
