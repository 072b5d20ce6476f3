"""The compiled module, or one message why it cannot be used."""

import numpy

if int(numpy.__version__.split(".")[0]) >= 2:
    raise ImportError(
        f"kalfem was built with pybind11 2.10, which cannot serve NumPy {numpy.__version__}: install 'numpy<2'"
    )
try:
    from . import _core as core
except ImportError as error:
    raise ImportError(
        f"the compiled part of kalfem cannot be loaded ({error}): build it by scripts/python, or install its wheel"
    ) from error

__all__ = ["core"]
