# SPDX-License-Identifier: Apache-2.0
"""Arguments of a wrong type, told by their names."""

from __future__ import annotations

import functools
import inspect
import numbers
import re

from .errors import InvalidInput, Issue, unknown_name

_SIGNATURE = re.compile(r"^ +1\. (?:\w+)?\((.*)\)(?: -> .*)?$", re.M)
_NAMED = {
    "str": ("a text", str),
    "float": ("a number", numbers.Real),
    "int": ("a whole number", numbers.Integral),
    "bool": ("True or False", (bool, numbers.Integral)),
    "dict": ("a dictionary", dict),
}


def _parameters(signature):
    """(name, type, whether it may be left out) of each parameter of pybind11's text; '*' is left out."""
    depth, begin, parts = 0, 0, []
    for at, letter in enumerate(signature + ","):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            parts.append(signature[begin:at].strip())
            begin = at + 1
    found = []
    for part in parts:
        name, _, kind = part.partition(":")
        if kind:
            kind, _, default = kind.partition("=")
            found.append((name.strip(), kind.strip(), bool(default)))
    return found


def _wrong(function, error, given, named):
    """The issue that an error of pybind11 is about, or None where its text does not tell."""
    match = _SIGNATURE.search(str(error))
    if not match:
        return None
    parameters = _parameters(match[1])
    known = [name for name, _, _ in parameters if name != "self"]
    for name in named:
        if name not in known:
            return Issue(f"{function}(): {unknown_name('argument', name, known)}")
    if len(given) > len(parameters):
        return Issue(f"{function}(): {len(given)} arguments are given", f"it takes {', '.join(known)}")
    values = {name: value for (name, _, _), value in zip(parameters, given)} | named
    for name, kind, optional in parameters:
        if name not in values and not optional:
            return Issue(f"{function}(): '{name}' is missing", f"it takes {', '.join(known)}")
        words, accepted = _NAMED.get(kind, ("", object))
        if name in values and not isinstance(values[name], accepted):
            return Issue(f"{function}(): {name}: {values[name]!r} is given", f"{words} is needed")
    return None


def _naming(function):
    """The function, with :class:`InvalidInput` in the place of pybind11's text about its arguments."""

    @functools.wraps(function)
    def call(*given, **named):
        try:
            return function(*given, **named)
        except TypeError as error:
            if "incompatible" not in str(error):
                raise
            issue = _wrong(function.__name__.strip("_"), error, given, named)
            if issue is None:
                raise
            raise InvalidInput(issue) from None

    return call


def name_arguments(module):
    """Let all functions and methods of a compiled module tell wrong arguments by their names."""
    for name, each in list(vars(module).items()):
        if inspect.isbuiltin(each):
            setattr(module, name, _naming(each))
        elif inspect.isclass(each) and each.__module__ == module.__name__:
            for key, method in list(vars(each).items()):
                if type(method).__name__ == "instancemethod" and (key == "__init__" or not key.startswith("__")):
                    setattr(each, key, _naming(method))
