# SPDX-License-Identifier: Apache-2.0
"""Loads the compiled module, or says in one message why it cannot be loaded here. Needs no other package."""

import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path


def _absent_features():
    """Features of the processor that the module was compiled for and that this processor lacks."""
    from ._built_for import FEATURES

    try:
        with open("/proc/cpuinfo") as processors:
            flags = next(line.split() for line in processors if line.startswith("flags"))
    except (OSError, StopIteration):
        return []
    return [feature for feature in FEATURES if feature not in flags]


def _other_python():
    """The Python that the module was built for, where it is not this one."""
    endings = [file.name.removeprefix("_core") for file in Path(__file__).parent.glob("_core*.so")]
    return None if not endings or set(endings) & set(EXTENSION_SUFFIXES) else "-".join(endings[0].split(".")[1].split("-")[:2])


if _absent_features():
    raise ImportError(
        f"kalfem was compiled for a processor with {', '.join(_absent_features())}, which this one does not have: "
        "compile it here, or with KALFEM_NATIVE=OFF for any processor"
    )
if built_for := _other_python():
    raise ImportError(
        f"kalfem was built for {built_for}, and this is Python {sys.version_info.major}.{sys.version_info.minor}: "
        "install a wheel for it, or build one by scripts/python"
    )
try:
    from . import _core as core
except ImportError as error:
    raise ImportError(
        f"the compiled part of kalfem cannot be loaded ({error}): build it by scripts/python, or install its wheel"
    ) from error

__all__ = ["core"]
