# SPDX-License-Identifier: Apache-2.0
"""The command `kalfem` in a shell, ``kalfem run case.yaml``, or ``python -m kalfem run case.yaml``.

It is part of the compiled module, prints what the program of the other packages prints, and needs no NumPy.
"""

import os
import signal
import sys


def main() -> int:
    """Run the command with the arguments of this process, and return its exit code."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # no traceback; the command soon listens itself
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # it uses no more, and under `ulimit -v` more would hang
    try:
        from .module_file import core
    except ImportError as error:
        sys.exit(str(error))
    return core._command([os.fsencode(word) for word in sys.argv])
