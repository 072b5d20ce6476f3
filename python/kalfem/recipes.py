# SPDX-License-Identifier: Apache-2.0
"""Pickles and copies of structures and their parts: the calls that made them are made again.

A deck or a case is read again where a pickle is loaded; a law that is a function is found by its module and name, as
functions are in every pickle. A compiled function has no pickle.
"""

from __future__ import annotations

import copy
import ctypes
import functools
import inspect

import numpy as np

_CLASSES = ("Structure", "Lumped", "FiniteElements")
_FACTORIES = ("lumped", "chain", "read_deck", "read_matrices")


class Recipe:
    """The calls that make an object: a function, then methods of what the call before returned."""

    def __init__(self, calls):
        self.calls = tuple(calls)

    def __call__(self):
        function, given, named = self.calls[0]
        made = function(*map(_made, given), **{name: _made(each) for name, each in named.items()})
        for method, given, named in self.calls[1:]:
            made = getattr(made, method)(*map(_made, given), **{name: _made(each) for name, each in named.items()})
        return made


def _kept(value):
    """An argument as it is now: parts by their recipes, arrays as copies."""
    if hasattr(value, "_calls"):
        return Recipe(value._calls)
    if isinstance(value, np.ndarray):
        return np.array(value)
    if isinstance(value, dict):
        return {key: _kept(each) for key, each in value.items()}
    if type(value) in (list, tuple):
        return type(value)(map(_kept, value))
    if isinstance(value, ctypes._CFuncPtr) or hasattr(value, "ctypes"):
        return value  # compiled functions do not change
    return copy.deepcopy(value)


def _made(value):
    if isinstance(value, Recipe):
        return value()
    if isinstance(value, dict):
        return {key: _made(each) for key, each in value.items()}
    if type(value) in (list, tuple):
        return type(value)(map(_made, value))
    return value


def _call(function, given, named):
    return function, tuple(map(_kept, given)), {name: _kept(each) for name, each in named.items()}


def made_by(made, function, *given):
    """Notes that a call of the function, which a pickle can name, made the object. Returns the object."""
    made._calls = [_call(function, given, {})]
    return made


def _noting_factory(factory, name):
    @functools.wraps(factory)
    def make(*given, **named):
        made = factory(*given, **named)
        made._calls = [_call(Named(name), given, named)]
        return made

    return make


def _noting_method(method, name):
    @functools.wraps(method)
    def call(self, *given, **named):
        result = method(self, *given, **named)
        if result is self:
            self._calls.append(_call(name, given, named))
        elif type(result) is type(self):
            result._calls = [*self._calls, _call(name, given, named)]
        return result

    return call


class Named:
    """A function of the compiled module by its name, as pickles hold it."""

    def __init__(self, name):
        self.name = name

    def __call__(self, *given, **named):
        from .compiled import core

        return getattr(core, self.name)(*given, **named)


def note_calls(core):
    """Let what the compiled module makes of a user's words be pickled and copied."""
    for name in _FACTORIES:
        setattr(core, name, _noting_factory(getattr(core, name), name))
    for name in _CLASSES:
        each = getattr(core, name)
        for key, method in list(vars(each).items()):
            if key == "__init__":
                each.__init__ = _noting_init(method, name)
            elif inspect.isfunction(method) and not key.startswith("_"):
                setattr(each, key, _noting_method(method, key))
        each.__reduce__ = lambda self: (Recipe(self._calls), ())
        each.__copy__ = each.__deepcopy__ = _copied


def _noting_init(init, name):
    @functools.wraps(init)
    def begin(self, *given, **named):
        init(self, *given, **named)
        self._calls = [_call(Named(name), given, named)]

    return begin


def _copied(self, memo=None):
    return self.copy() if hasattr(self, "copy") else Recipe(self._calls)()
