#!/usr/bin/env python3
"""The include rule: a room includes rows below its own, never a neighbour or a row above.

Run from anywhere; prints every include that breaks the rule and exits with 1 if there is one.
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# room: the rooms it may include besides itself (ARCHITECTURE.md, "Layers")
BASE = {"base"}
LOW = BASE | {"geometry", "la"}
ALLOWED = {
    "base": set(),
    "geometry": BASE,
    "la": BASE,
    "engine/local": BASE | {"la"},
    "mesh": BASE | {"geometry"},
    "material": BASE,
    "disc": LOW | {"mesh"},
    "disc/dg": LOW | {"mesh", "material", "disc"},
    "disc/cg": LOW | {"mesh", "material", "disc"},
    "disc/staggered": LOW | {"mesh", "material", "disc"},
    "embed": LOW | {"mesh", "material", "disc", "disc/dg"},
    "system": LOW | {"mesh", "material", "disc", "embed"},
    "couple": LOW | {"mesh", "material", "disc", "disc/dg", "embed", "system"},
    "step": LOW | {"mesh", "material", "disc", "disc/dg", "embed", "system"},
    "io": LOW | {"mesh"},
    "scene": LOW | {"mesh", "material", "disc", "disc/dg", "disc/cg", "disc/staggered", "embed", "system", "couple", "step", "io"},
    "study": LOW | {"mesh", "disc", "disc/dg", "disc/staggered", "embed", "system", "step", "io", "scene"},
}
# the table of engines is the one place that names them
EXCEPTIONS = {("src/la/engine.c", "engine/local")}

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)


def room_of(path):
    """Room of an include path such as "disc/dg/dg_space.h"; None for a file beside the includer."""
    parts = path.split("/")[:-1]
    for n in (2, 1):
        name = "/".join(parts[:n])
        if len(parts) >= n and name in ALLOWED:
            return name
    return None


def broken_in(path):
    rel = os.path.relpath(path, ROOT)
    is_public = rel.startswith("include")
    room = room_of(rel[len("src/"):]) if rel.startswith("src/") else None
    text = open(path, encoding="utf-8").read()
    for include in INCLUDE.findall(text):
        target = room_of(include)
        if include.startswith("lithe/"):
            continue
        if rel.startswith("apps/"):
            if "/" in include:
                yield rel, include, "the program includes public headers only"
        elif is_public:
            yield rel, include, "a public header includes public headers only"
        elif target is None:
            yield rel, include, "write the room in front: \"room/file.h\""
        elif target != room and target not in ALLOWED[room] and (rel, target) not in EXCEPTIONS:
            yield rel, include, "%s may not include %s" % (room, target)


def main():
    broken, names = [], {}
    for top in ("src", "apps", "include"):
        for folder, _, files in os.walk(os.path.join(ROOT, top)):
            for name in sorted(files):
                path = os.path.join(folder, name)
                if not name.endswith((".c", ".h")):
                    continue
                broken += broken_in(path)
                names.setdefault(name, []).append(os.path.relpath(path, ROOT))
    for path, include, why in broken:
        print('%s: #include "%s": %s' % (path, include, why))
    twice = [paths for name, paths in names.items()
             if len(paths) > 1 and not any(p.startswith("include") for p in paths)]
    for paths in twice:
        print("file names are unique in the tree: %s" % ", ".join(paths))
    return 1 if broken or twice else 0


sys.exit(main())
