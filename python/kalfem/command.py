# SPDX-License-Identifier: Apache-2.0
"""The command `kalfem` of a wheel that has one: ``kalfem run case.yaml`` in a shell."""

import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "_command" / "kalfem"


def main() -> None:
    """Becomes the command, with the arguments of this process."""
    if not PROGRAM.exists():
        sys.exit("kalfem: this build of the Python package has no command: scripts/build makes one, and the wheel of scripts/package holds one")
    os.execv(PROGRAM, [str(PROGRAM), *sys.argv[1:]])
