"""A folder that keeps the outcomes of an ensemble, so that a killed one continues."""

import hashlib
import json
import os
import pickle
from pathlib import Path

import numpy as np

from .errors import InvalidInput, Issue
from .tasks import Summary


class OutcomeStore:
    """One file a point, named by a hash of the task's content and the point's settings.

    Summaries are ``HASH.json``, values of functions ``HASH.pickle``. A file is complete or absent; a damaged one counts
    as absent.
    """

    def __init__(self, folder, task):
        self._folder = Path(folder)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._identity = task.identity()

    def load(self, settings):
        """(outcome,) of a point, or None."""
        place = self._place(settings)
        try:
            return (Summary(json.loads(place.with_suffix(".json").read_bytes())["summary"]),)
        except FileNotFoundError:
            pass
        except (ValueError, KeyError, TypeError):
            return None
        try:
            return (pickle.loads(place.with_suffix(".pickle").read_bytes()),)
        except Exception:  # absent, damaged, or of a class that is no longer there: computed anew
            return None

    def save(self, settings, outcome):
        """Write the outcome of a point in one step."""
        place = self._place(settings)
        if isinstance(outcome, Summary):
            content = json.dumps({"settings": settings, "summary": outcome}, default=_plain).encode()
            _write(place.with_suffix(".json"), content)
        else:
            _write(place.with_suffix(".pickle"), pickle.dumps(outcome))

    def _place(self, settings):
        try:
            text = json.dumps(settings, sort_keys=True, default=_plain)
        except TypeError as error:
            fix = "use numbers, text and lists, or leave folder out"
            raise InvalidInput(Issue(f"the settings {settings!r} cannot be stored", str(error), fix)) from None
        return self._folder / hashlib.sha256((self._identity + text).encode()).hexdigest()[:24]


def _plain(value):
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is neither a number, text nor a list")


def _write(file, content):
    temporary = file.with_name(f"{file.name}.{os.getpid()}.part")
    temporary.write_bytes(content)
    os.replace(temporary, file)
