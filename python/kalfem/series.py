# SPDX-License-Identifier: Apache-2.0
"""A quantity over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class TimeSeries(np.ndarray):
    """Samples of one quantity: an array that knows its time, its standard deviation and its unit.

    Parameters
    ----------
    values : array, first axis is time
    t : array or None
        Time of each sample [s].
    std : array or None
        Standard deviation of each sample [unit].
    unit : str
        SI unit, ``"m/s^2"``; empty if it has none.
    name : str
        Its path in the results, ``"estimate/body.3/displacement"``.

    Indexing along time keeps all of them. Anything computed from a series is a plain array.

    >>> y = TimeSeries([1.0, 2.0, 4.0], t=[0.0, 0.1, 0.2], std=[0.5, 0.5, 0.5], unit="m")
    >>> y[1:].t
    array([0.1, 0.2])
    >>> y.max(), 2 * y
    (4.0, array([2., 4., 8.]))
    """

    t: np.ndarray | None
    std: np.ndarray | None
    unit: str
    name: str

    def __new__(cls, values, t=None, std=None, unit: str = "", name: str = "") -> TimeSeries:
        series = np.asarray(values, dtype=float).view(cls)
        series.t = None if t is None else np.asarray(t, dtype=float)
        series.std = None if std is None else np.asarray(std, dtype=float)
        series.unit, series.name = unit, name
        return series

    def __array_finalize__(self, source):
        self.t = self.std = None
        self.unit = self.name = ""

    def __array_wrap__(self, result, context=None):
        plain = np.asarray(result)
        return plain if plain.ndim else plain[()]

    def __getitem__(self, key):
        part = super().__getitem__(key)
        if not isinstance(part, TimeSeries):
            return part
        along_time = isinstance(key, slice) or (isinstance(key, np.ndarray) and key.ndim == 1)
        if not along_time:
            return np.asarray(part)
        part.t = None if self.t is None else self.t[key]
        part.std = None if self.std is None else self.std[key]
        part.unit, part.name = self.unit, self.name
        return part

    def __reduce__(self):
        return TimeSeries, (np.asarray(self), self.t, self.std, self.unit, self.name)

    def __repr__(self):
        values = np.array2string(np.asarray(self), separator=", ", threshold=6, prefix="TimeSeries(")
        return f"TimeSeries({values}, unit={self.unit!r}, name={self.name!r})"

    def to_pandas(self) -> pandas.Series:
        """A ``pandas.Series`` over time."""
        from .tables import series_to_pandas

        return series_to_pandas(self)

    def plot(self, ax: Axes | None = None, **style) -> Figure:
        """Draw the series with its band of two standard deviations. Returns the figure."""
        from . import plots

        return plots.series(self, ax=ax, **style)
