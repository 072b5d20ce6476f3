# SPDX-License-Identifier: Apache-2.0
"""The compiled module, or one message why it cannot be used."""

import numpy

if int(numpy.__version__.split(".")[0]) >= 2:
    raise ImportError(
        f"kalfem was built with pybind11 2.10, which cannot serve NumPy {numpy.__version__}: install 'numpy<2'"
    )


def _absent_features():
    """Features of the processor that the module was compiled for and that this processor lacks."""
    from ._built_for import FEATURES

    try:
        with open("/proc/cpuinfo") as processors:
            flags = next(line.split() for line in processors if line.startswith("flags"))
    except (OSError, StopIteration):
        return []
    return [feature for feature in FEATURES if feature not in flags]


if _absent_features():
    raise ImportError(
        f"kalfem was compiled for a processor with {', '.join(_absent_features())}, which this one does not have: "
        "compile it here, or with KALFEM_NATIVE=OFF for any processor"
    )
try:
    from . import _core as core
except ImportError as error:
    raise ImportError(
        f"the compiled part of kalfem cannot be loaded ({error}): build it by scripts/python, or install its wheel"
    ) from error

from .arguments import name_arguments

name_arguments(core)

__all__ = ["core"]
