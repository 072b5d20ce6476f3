# SPDX-License-Identifier: Apache-2.0
"""Innovations of a run: what the filter did not foresee."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .errors import unknown_name
from .series import TimeSeries

if TYPE_CHECKING:
    from .results import Run


class Residuals:
    """Innovations with what the filter expects of them.

    Attributes
    ----------
    sensors : list of str
    t : array, samples
        Time [s].
    value : array, samples x sensors
        Innovation, measured minus predicted [unit of the sensor]; NaN where nothing was used.
    deviation : array, samples x sensors
        Its standard deviation by the filter, the root of the diagonal of S.
    covariance : array, samples x sensors x sensors, or None
        S itself, where it is kept: ``results.h5`` holds its diagonal only.
    used : bool array, samples x sensors
        False where the sample was missing, held out or an outlier.
    nis : TimeSeries
        Normalised innovation squared; its mean is the number of sensors if model and noise are right.
    scores : array, samples x parameters, or None
        Derivative of ln p(y_k | y_1 .. y_k-1) with respect to each constant unknown, at its last estimate
        [1 / its unit]; ``results.h5`` does not hold it.

    ``residuals["a3"]`` is one sensor's innovation as a :class:`TimeSeries`, with its expected deviation as ``std``.
    """

    def __init__(self, run: Run):
        group = "innovation/value/"
        self._run = run
        self.sensors = [path[len(group) :] for path in run.keys() if path.startswith(group)]

    def __getitem__(self, sensor: str) -> TimeSeries:
        if sensor not in self.sensors:
            raise unknown_name("sensor", sensor, self.sensors)
        series = self._run[f"innovation/value/{sensor}"]
        series.std = np.asarray(self._run[f"innovation/deviation/{sensor}"])
        return series

    def __iter__(self):
        return iter(self.sensors)

    def __len__(self):
        return len(self.sensors)

    def __repr__(self):
        return f"Residuals of {', '.join(self.sensors) or 'no sensor'}"

    @property
    def t(self) -> np.ndarray:
        return self._run[f"innovation/value/{self.sensors[0]}"].t if self.sensors else np.empty(0)

    @property
    def value(self) -> np.ndarray:
        return self._columns("innovation/value")

    @property
    def deviation(self) -> np.ndarray:
        return self._columns("innovation/deviation")

    @property
    def normalised(self) -> np.ndarray:
        """Innovation over its standard deviation, samples x sensors: white and of size one for a consistent filter."""
        return self.value / self.deviation

    @property
    def used(self) -> np.ndarray:
        return np.isfinite(self.value)

    @property
    def nis(self) -> TimeSeries:
        return self._run["innovation/nis"]

    @property
    def covariance(self) -> np.ndarray | None:
        path = "innovation/covariance"
        return np.asarray(self._run[path]) if path in self._run else None

    @property
    def scores(self) -> np.ndarray | None:
        group = "innovation/scores/"
        paths = [path for path in self._run.keys() if path.startswith(group)]
        return np.stack([self._run[path] for path in paths], axis=1) if paths else None

    def _columns(self, group):
        if not self.sensors:
            return np.empty((0, 0))
        return np.stack([self._run[f"{group}/{sensor}"] for sensor in self.sensors], axis=1)
