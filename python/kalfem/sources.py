"""Where the series of a run come from: a folder of results, or memory. Both use the paths of ``results.h5``."""

import json
from pathlib import Path

import numpy as np

from .errors import InvalidInput, Issue, optional


class MemorySource:
    """Arrays by path, ``{"time": (array, {"unit": "s"})}``."""

    def __init__(self, datasets):
        self._datasets = {path.strip("/"): content for path, content in datasets.items()}

    def paths(self):
        return list(self._datasets)

    def read(self, path):
        """Values and attributes of one dataset."""
        values, attributes = self._datasets[path]
        return values, attributes


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
            return dataset[()], {key: _text(value) for key, value in dataset.attrs.items()}

    def _list(self):
        paths = []
        h5py = optional("h5py", "reading results.h5")

        def collect(path, item):
            if isinstance(item, h5py.Dataset):
                paths.append(path)

        with self._open() as file:
            file.visititems(collect)
        return paths

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
