#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails where a file of src/kalfem includes a folder that its own may not use, and where two headers define one type.

ALLOWED is the picture of docs/architecture.md as a table: a folder, and all that its files may include beside their own.
"""
import pathlib
import re
import sys

NUMERICS = {"base", "linalg"}
MODEL = NUMERICS | {"records", "model"}
MOTION = MODEL | {"system", "dynamics", "statistics"}
ALLOWED = {
    "base": set(),
    "linalg": {"base"},
    "statistics": {"base"},
    "sampling": NUMERICS | {"statistics"},
    "information": NUMERICS | {"statistics"},
    "verdict": {"base", "statistics"},
    "records": NUMERICS,
    "model": NUMERICS,
    "formats": MODEL,
    "reduction": NUMERICS | {"model"},
    "system": MODEL,
    "dynamics": MODEL | {"system"},
    "estimation": MOTION,
    "prediction": MOTION | {"reduction"},
    "modal": NUMERICS | {"records", "statistics"},
    "updating": MOTION | {"information", "reduction", "estimation", "prediction", "modal"},
    "correlation": MODEL | {"statistics", "modal", "updating"},
    "distributed": NUMERICS,
    "yaml": {"base"},
}
LIBRARY = set(ALLOWED) - {"yaml", "distributed"}
CORE = LIBRARY - {"formats", "verdict"}
ALLOWED["identification"] = CORE | {"verdict"}
ROOMS = {"inference", "placement", "validation", "vibration"}
ALLOWED.update({room: CORE | {"identification"} for room in ROOMS})
ALLOWED["live"] = CORE | {"identification", "verdict"}
ALLOWED["casefile"] = LIBRARY | {"identification", "vibration", "live", "yaml"}
ALLOWED["study"] = ALLOWED["casefile"] | {"casefile", "inference", "placement", "validation"}
ALLOWED["diagnosis"] = CORE | {"identification", "validation", "verdict"}
ALLOWED["api"] = ALLOWED["diagnosis"] | ROOMS | {"diagnosis", "live"}
ALLOWED["pictures"] = CORE | {"identification"}
ALLOWED["page"] = NUMERICS | {"statistics", "records", "verdict", "pictures"}
ALLOWED["steps"] = LIBRARY | ROOMS | {"identification", "diagnosis", "study", "pictures", "page"}
ALLOWED["watch"] = ALLOWED["study"] | {"study"}
ALLOWED["report"] = ALLOWED["steps"] | {"steps"}
ALLOWED["analysis"] = ALLOWED["api"] | {"api", "yaml", "casefile", "study", "steps", "formats"}
INCLUDE = re.compile(r'#include "kalfem/(\w+)/')
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{")
TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)(?: final)?(?: :.*)? \{")


def violations(root):
    for path in sorted(root.rglob("*/*.[ch]pp")):  # kalfem.hpp itself is above all folders
        folder = path.relative_to(root).parts[0]
        if folder not in ALLOWED:
            yield f"{path}: the folder '{folder}' is not in the table; name what it may use in {__file__}"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match and match[1] != folder and match[1] not in ALLOWED[folder]:
                yield f"{path}:{number}: {folder} may not include {match[1]}"


def doubled_types(root):
    """Types of one namespace with two definitions: a program that has both is wrong, and no linker says so."""
    first = {}
    for path in sorted(root.rglob("*.hpp")):
        namespace = ""
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if match := NAMESPACE.match(line):
                namespace = match[1]
            elif match := TYPE.match(line):
                name = f"{namespace}::{match[1]}"
                if name in first:
                    yield f"{path}:{number}: {name} is defined in {first[name]} already"
                first.setdefault(name, f"{path}:{number}")


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "src/kalfem")
    found = [*violations(root), *doubled_types(root)]
    print("\n".join(found) if found else "every include is allowed, every type has one definition")
    return 1 if found else 0


sys.exit(main())
