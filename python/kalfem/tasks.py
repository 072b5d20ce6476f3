# SPDX-License-Identifier: Apache-2.0
"""What an ensemble computes at each point: a case with other settings, or a function of the caller."""

import hashlib
import os
import pickle
import re
from pathlib import Path

from .errors import InvalidInput, Issue
from .results import Run

_WORD = re.compile(r"[^\s\[\]{}\"',:]+")
_VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")  # ${NAME:-default}


def _value_of(variable):
    return os.environ.get(variable[1], variable[2] or "")


class CaseTask:
    """Runs a case file with the settings of a point; writes no files."""

    def __init__(self, case):
        self.case = Path(case).resolve()
        if not self.case.is_file():
            raise InvalidInput(Issue(f"there is no case file '{case}'", fix="give its path, or a function"))

    def __call__(self, settings, progress=False):
        import kalfem

        return kalfem.run(self.case, set=settings, progress=progress)

    def identity(self):
        """Hash of the case and of the files that it names."""
        text = self.case.read_bytes()
        content = hashlib.sha256(text)
        for name in sorted(set(_WORD.findall(_VARIABLE.sub(_value_of, text.decode(errors="replace"))))):
            file = self.case.parent / name
            if file.is_file():
                content.update(name.encode() + hashlib.sha256(file.read_bytes()).digest())
        return content.hexdigest()


class FunctionTask:
    """Calls a function with the settings of a point."""

    def __init__(self, function):
        self.function = function

    def __call__(self, settings, progress=False):
        return self.function(settings)

    def identity(self):
        """Hash of the function's name and source; of functions that it calls it sees nothing."""
        import inspect

        name = f"{self.function.__module__}.{self.function.__qualname__}"
        try:
            name += inspect.getsource(self.function)
        except (OSError, TypeError):
            pass
        return hashlib.sha256(name.encode()).hexdigest()


def make_task(case_or_function):
    """A function is called, anything else names a case file."""
    return FunctionTask(case_or_function) if callable(case_or_function) else CaseTask(case_or_function)


class Summary(dict):
    """The summary of a run that was made elsewhere: all of it that travels."""


class Failed:
    """The exception of one point, in a form that travels."""

    def __init__(self, error):
        try:
            pickle.loads(pickle.dumps(error))
            self.error = error
        except Exception:  # whatever hinders its journey: its message arrives
            self.error = RuntimeError(f"{type(error).__name__}: {error}")


def compute(task, points, progress=False):
    """Outcomes of some points in a worker: a Summary, the function's value, or Failed."""
    return [_outcome(task, settings, progress) for settings in points]


def _outcome(task, settings, progress):
    try:
        value = task(settings, progress)
    except Exception as error:
        return Failed(error)
    return Summary(value.summary) if isinstance(value, Run) else value
