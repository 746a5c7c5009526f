"""A shared build exports exactly the functions that public headers mark with LITHE_API.

usage: check_exports.py INCLUDE_DIR SHARED_LIBRARY
"""
import glob
import os
import re
import subprocess
import sys

headers = "".join(open(p).read() for p in glob.glob(os.path.join(sys.argv[1], "lithe", "*.h")))
meant = set(re.findall(r"LITHE_API[^;{]*?\b(lithe_\w+)\s*\(", headers))
table = subprocess.run(["nm", "-D", "--defined-only", sys.argv[2]], check=True, capture_output=True, text=True)
found = {line.split()[-1] for line in table.stdout.splitlines()}
# what sanitizers and the linker add is not ours
found = {name for name in found if not name.startswith(("_", "__"))}
for name in sorted(meant - found):
    print("declared in a public header, not exported: %s" % name)
for name in sorted(found - meant):
    print("exported, not declared with LITHE_API: %s" % name)
print("%d functions exported" % len(found))
sys.exit(0 if found == meant and meant else 1)
