#!/usr/bin/env python3
"""Fails where a file of src/kalfem includes a stage that comes after its own in the data flow."""
import pathlib
import re
import sys

STAGES = ["base", "linalg", "model", "formats", "reduction", "system", "dynamics", "estimation", "prediction", "updating",
          "casefile", "report"]
INCLUDE = re.compile(r'#include "kalfem/(\w+)/')


def violations(root):
    for path in sorted(root.rglob("*.[ch]pp")):
        stage = path.relative_to(root).parts[0]
        if stage not in STAGES:
            yield f"{path}: the folder '{stage}' is not a stage; name it in {__file__}"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match and STAGES.index(match[1]) > STAGES.index(stage):
                yield f"{path}:{number}: {stage} includes {match[1]}, which comes after it"


def main():
    found = list(violations(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "src/kalfem")))
    print("\n".join(found) if found else "every include points up the data flow")
    return 1 if found else 0


sys.exit(main())
