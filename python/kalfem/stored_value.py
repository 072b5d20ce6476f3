# SPDX-License-Identifier: Apache-2.0
"""Values of functions as JSON text and arrays: reading them back runs no code, unlike a pickle."""

import numpy as np

_PLAIN = (type(None), bool, int, float, str)


def packed(value):
    """(JSON content, arrays) of a value; TypeError where it holds something else than numbers, text, arrays, lists,
    tuples and dictionaries with keys of text."""
    arrays = []
    return _pack(value, arrays), arrays


def unpacked(content, arrays):
    """The value again; ValueError, KeyError, IndexError or TypeError where the content is damaged."""
    if isinstance(content, list):
        return [unpacked(each, arrays) for each in content]
    if not isinstance(content, dict):
        return content
    ((kind, inner),) = content.items()
    if kind == "dict":
        return {key: unpacked(each, arrays) for key, each in inner.items()}
    if kind == "tuple":
        return tuple(unpacked(each, arrays) for each in inner)
    if kind == "complex":
        return complex(*inner)
    array = arrays[inner]
    return array if kind == "array" else array[()]


def _pack(value, arrays):
    if type(value) in _PLAIN:
        return value
    if type(value) is list:
        return [_pack(each, arrays) for each in value]
    if type(value) is tuple:
        return {"tuple": [_pack(each, arrays) for each in value]}
    if type(value) is dict and all(type(key) is str for key in value):
        return {"dict": {key: _pack(each, arrays) for key, each in value.items()}}
    if type(value) is complex:
        return {"complex": [value.real, value.imag]}
    if (type(value) is np.ndarray or isinstance(value, np.generic)) and not value.dtype.hasobject:
        arrays.append(np.asarray(value))
        return {"array" if isinstance(value, np.ndarray) else "number": len(arrays) - 1}
    raise TypeError(type(value).__name__)
