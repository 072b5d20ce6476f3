# SPDX-License-Identifier: Apache-2.0
"""Where the series of a run come from: a folder of results, or memory. Both use the paths of ``results.h5``."""

import json
import re
from pathlib import Path

import numpy as np

from .errors import InvalidInput, Issue, optional


class MemorySource:
    """Arrays by path, ``{"time": (array, {"unit": "s"})}``, or a function that gives them when one is asked for."""

    def __init__(self, datasets):
        self._given, self._datasets = datasets, None

    def paths(self):
        return list(self._all())

    def read(self, path):
        """Values and attributes of one dataset."""
        return self._all()[path]

    def _all(self):
        if self._datasets is None:
            given = self._given() if callable(self._given) else self._given
            self._given, self._datasets = None, {path.strip("/"): content for path, content in given.items()}
        return self._datasets

    def __getstate__(self):
        return {"_given": None, "_datasets": self._all()}


class FolderSource:
    """The file ``results.h5`` of a folder, opened for each reading, so that no handle is kept."""

    def __init__(self, folder, run):
        self._file = Path(folder) / "results.h5"
        self._run = run
        self._paths = None

    def paths(self):
        if self._paths is None:
            self._paths = self._list() if self._file.exists() else []
        return self._paths

    def read(self, path):
        """Values and attributes of one dataset."""
        with self._open() as file:
            dataset = file[path]
            names = (name for name in dataset.attrs if not name.isupper())  # HDF5's own: CLASS, DIMENSION_LIST
            return dataset[()], {name: _text(dataset.attrs[name]) for name in names}

    def _list(self):
        paths = []
        h5py = optional("h5py", "reading results.h5")

        def collect(path, item):
            # Whole numbers count the chains and draws of a posterior: they are axes, not results.
            if isinstance(item, h5py.Dataset) and not ("CLASS" in item.attrs and item.dtype.kind == "i"):
                paths.append(path)

        with self._open() as file:
            file.visititems(collect)
        return sorted(paths, key=_natural)

    def _open(self):
        file = optional("h5py", "reading results.h5").File(self._file, "r")
        written = _text(file.attrs.get("run", ""))
        if self._run and written != self._run:
            file.close()
            raise InvalidInput(
                Issue(
                    f"{self._file} belongs to the run {written}, not to {self._run}",
                    "the folder was written anew since its summary was read",
                    "read the results again",
                )
            )
        return file


def _natural(path):
    """Orders "body.2" before "body.10"."""
    return [(not part.isdigit(), int(part) if part.isdigit() else part) for part in re.split(r"(\d+)", path)]


def _text(value):
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.generic) else value


def read_summary(folder):
    """The content of ``summary.json`` of a folder of results."""
    file = Path(folder) / "summary.json"
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        problem = "there is no summary.json"
    except json.JSONDecodeError as error:
        problem = f"summary.json is damaged: {error}"
    fix = "give the folder that 'kalfem run CASE --out FOLDER' wrote"
    raise InvalidInput(Issue(f"'{folder}' is not a folder of results", problem, fix))
