# SPDX-License-Identifier: Apache-2.0
"""A folder that keeps the outcomes of an ensemble, so that a killed one continues."""

import hashlib
import io
import json
import os
import pickle
from pathlib import Path

import numpy as np

from .errors import InvalidInput, Issue
from .stored_value import packed, unpacked
from .tasks import Summary


class OutcomeStore:
    """One file a point, named by a hash of the task's content and the point's settings.

    Summaries and plain values are ``HASH.json``, values with arrays ``HASH.npz``, and everything else ``HASH.pickle``,
    which is written and read only with `trust`: a pickle runs what whoever wrote it wants. A file is complete or
    absent; a damaged one counts as absent.
    """

    def __init__(self, folder, task, trust=False):
        self._folder = Path(folder)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._identity = task.identity()
        self._trust = trust

    def load(self, settings):
        """(outcome,) of a point, or None. InvalidInput where only a pickle holds it and these are not trusted."""
        place = self._place(settings)
        readers = {".json": _from_text, ".npz": _from_arrays, ".pickle": self._from_pickle}
        for ending, read in readers.items():
            file = place.with_suffix(ending)
            if file.is_file():  # no pipe, which would keep us waiting
                return read(file)
        return None

    def save(self, settings, outcome):
        """Write the outcome of a point in one step."""
        place = self._place(settings)
        if isinstance(outcome, Summary):
            return _write(place.with_suffix(".json"), _text({"settings": settings, "summary": outcome}))
        try:
            content, arrays = packed(outcome)
        except TypeError as error:
            return self._save_pickle(place, outcome, str(error))
        if not arrays:
            return _write(place.with_suffix(".json"), _text({"settings": settings, "value": content}))
        named = {f"array{i}": array for i, array in enumerate(arrays)}
        buffer = io.BytesIO()
        np.savez(buffer, value=np.array(json.dumps(content)), **named)
        _write(place.with_suffix(".npz"), buffer.getvalue())

    def _from_pickle(self, file):
        if not self._trust:
            why = "reading a pickle runs code of whoever wrote it"
            fix = "pass trust=True if nobody else can write into this folder; otherwise choose an empty folder"
            raise InvalidInput(Issue(f"'{file}' is a pickle", why, fix))
        try:
            return (pickle.loads(file.read_bytes()),)
        except Exception:  # damaged, or of a class that is no longer there: computed anew
            return None

    def _save_pickle(self, place, outcome, kind):
        if not self._trust:
            why = "only numbers, text, arrays, lists, tuples and dictionaries are kept without a pickle"
            fix = "return these, or pass trust=True if nobody else can write into the folder"
            what = f"the function returns a value of type {kind}, which the folder cannot keep"
            raise InvalidInput(Issue(what, why, fix))
        _write(place.with_suffix(".pickle"), pickle.dumps(outcome))

    def _place(self, settings):
        try:
            text = json.dumps(settings, sort_keys=True, default=_plain)
        except TypeError as error:
            fix = "use numbers, text and lists, or leave folder out"
            raise InvalidInput(Issue(f"the settings {settings!r} cannot be stored", str(error), fix)) from None
        return self._folder / hashlib.sha256((self._identity + text).encode()).hexdigest()[:24]


def _from_text(file):
    try:
        content = json.loads(file.read_bytes())
        return (Summary(content["summary"]) if "summary" in content else unpacked(content["value"], []),)
    except Exception:  # damaged: computed anew
        return None


def _from_arrays(file):
    try:
        with np.load(file, allow_pickle=False) as content:
            arrays = [content[f"array{i}"] for i in range(len(content.files) - 1)]
            return (unpacked(json.loads(str(content["value"])), arrays),)
    except Exception:  # damaged: computed anew
        return None


def _text(content):
    return json.dumps(content, default=_plain).encode()


def _plain(value):
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is neither a number, text nor a list")


def _write(file, content):
    temporary = file.with_name(f"{file.name}.{os.getpid()}.part")
    temporary.write_bytes(content)
    os.replace(temporary, file)
