# SPDX-License-Identifier: Apache-2.0
"""Measured files and simulated records: channels by name."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .compiled import core
from .errors import unknown_name
from .series import TimeSeries


class Record(Mapping):
    """Channels by name, each a :class:`TimeSeries` with its unit and the time of every sample.

    Attributes
    ----------
    failure : str
        When and why a simulation stopped; empty if it ran to its end.
    """

    def __init__(self, channels, failure=""):
        self._channels, self.failure = dict(channels), failure

    @classmethod
    def from_datasets(cls, datasets, failure=""):
        """The channels ``measurements/NAME`` of datasets as ``results.h5`` has them."""
        group = "measurements/"
        time = datasets["time"][0]
        names = [path[len(group) :] for path in datasets if path.startswith(group)]
        series = {name: datasets[group + name] for name in names}
        return cls(
            {name: TimeSeries(values, time, unit=entry["unit"], name=name) for name, (values, entry) in series.items()},
            failure,
        )

    def __getitem__(self, name):
        try:
            return self._channels[name]
        except KeyError:
            raise unknown_name("channel", name, self._channels) from None

    def __iter__(self):
        return iter(self._channels)

    def __len__(self):
        return len(self._channels)

    def __repr__(self):
        lines = [f"{name}: {len(values)} samples [{values.unit or '-'}]" for name, values in self.items()]
        return "\n".join(lines) or "no channels"

    def _ipython_key_completions_(self):
        return list(self._channels)

    @property
    def t(self) -> np.ndarray:
        """Time of the samples of the first channel [s]."""
        return next(iter(self.values())).t if self._channels else np.empty(0)

    def to_pandas(self):
        """A ``pandas.DataFrame``, one column a channel, over time; channels of other times leave gaps."""
        from .errors import optional

        pandas = optional("pandas", "to_pandas()")
        columns = {name: pandas.Series(np.asarray(values), values.t) for name, values in self.items()}
        return pandas.DataFrame(columns).rename_axis("time")


@dataclass(frozen=True)
class MeasuredFunction:
    """A function of frequency: a frequency response, a coherence, a spectrum."""

    name: str
    kind: str
    frequency: np.ndarray  #: lines [Hz], shape (n,)
    values: np.ndarray  #: complex, shape (n,)
    unit: str = ""
    description: str = ""
    response: dict | None = None  #: node and direction: 1, 2, 3 along x, y, z; 4, 5, 6 about them; with a minus against
    reference: dict | None = None


@dataclass(frozen=True)
class MeasuredShape:
    """A measured mode, or a static shape."""

    name: str
    frequency: float  #: [Hz]
    damping: float  #: ratio to critical
    nodes: list  #: one a row of the values
    values: np.ndarray  #: complex, shape (nodes, 3 or 6)


class MeasuredFile(Record):
    """Everything that a file of a test bench holds, in the file's units: its channels by name, and

    Attributes
    ----------
    format : str
        ``"Universal file"``, ``"TDMS"``, ...
    functions : list of MeasuredFunction
    shapes : list of MeasuredShape
    nodes : dict of int to (x, y, z)
        Points of the test's geometry.
    places : dict of str to dict
        Node and direction of each channel, as far as the file says it.
    descriptions, quantities : dict of str to str
        Of the channels, as far as the file says it.
    skipped, notes : list of str
        What was not read, and contradictions of the file, in words.
    """

    def __init__(self, content):
        channels = _with_own_names(content["channels"])
        super().__init__(
            {name: TimeSeries(each["values"], each["t"], unit=each["unit"], name=name) for name, each in channels.items()}
        )
        self.format, self.description = content["format"], content["description"]
        self.functions = [MeasuredFunction(**each) for each in content["functions"]]
        self.shapes = [MeasuredShape(**each) for each in content["shapes"]]
        self.nodes = content["nodes"]
        self.places = {name: each["place"] for name, each in channels.items()}
        self.descriptions = {name: each["description"] for name, each in channels.items()}
        self.quantities = {name: each["quantity"] for name, each in channels.items()}
        self.skipped, self.notes = content["skipped"], content["notes"]


def _with_own_names(channels):
    """Channels by name; of several with one name the further ones are ``name (2)`` and so on."""
    named = {}
    for each in channels:
        name, number = each["name"], 1
        while name in named:
            number += 1
            name = f"{each['name']} ({number})"
        named[name] = each
    return named


def read(file: str | Path, large: bool = False) -> MeasuredFile:
    """Read a measured file, whatever its format, without a case.

    Parameters
    ----------
    file : path
        Universal file, TDMS, LabVIEW text, MATLAB, WAV, HDF5, or a table of text. The content decides.
    large : bool, optional
        Read also parts of compressed files (HDF5, MATLAB) that unpack to more than 64 MiB and 8 times the file's size.
        Otherwise they are listed in ``skipped``.

    Returns
    -------
    MeasuredFile
        ``file["a3"]`` is a :class:`TimeSeries` in the file's unit, ``.unit``, with the exact time of every sample, ``.t``
        [s], which is None where the file does not say it.

    Raises
    ------
    InvalidInput
        Where the file cannot be read, by its line or place.
    """
    return MeasuredFile(core.read(os.fspath(file), large))
