# SPDX-License-Identifier: Apache-2.0
"""The compiled module for NumPy's arrays, or one message why it cannot be used."""

import ctypes

import numpy

if int(numpy.__version__.split(".")[0]) >= 2:
    raise ImportError(
        f"kalfem was built with pybind11 2.10, which cannot serve NumPy {numpy.__version__}: install 'numpy<2'"
    )
# A process has one C++ run time. Where the system has its own, other packages may need that one, which is never older
# than a wheel's: it comes first.
try:
    ctypes.CDLL("libstdc++.so.6")
except OSError:
    pass

from .arguments import name_arguments
from .module_file import core
from .recipes import note_calls

name_arguments(core)
note_calls(core)

__all__ = ["core"]
