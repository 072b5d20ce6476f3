# SPDX-License-Identifier: Apache-2.0
"""Results as tables of pandas and xarray."""

import numpy as np

from .errors import optional
from .series import TimeSeries


def series_to_pandas(series):
    """A ``pandas.Series`` over time [s]."""
    pandas = optional("pandas", "to_pandas()")
    index = None if series.t is None else pandas.Index(series.t, name="time")
    return pandas.Series(np.asarray(series), index=index, name=series.name or None)


def parameters_to_pandas(parameters):
    """One row a parameter; what is not known is NaN."""
    pandas = optional("pandas", "to_pandas()")
    columns = ["value", "std", "std_robust", "lower_95", "upper_95", "truth", "initial", "unit"]
    rows = [
        [each.value, each.std, each.std_robust, *(each.interval or (None, None)), each.truth, each.initial, each.unit]
        for each in parameters.values()
    ]
    table = pandas.DataFrame(rows, index=pandas.Index(list(parameters), name="parameter"), columns=columns)
    return table.astype(dict.fromkeys(columns[:-1], float))


def _over_time(run, group):
    """Arrays of one number a sample over the time of the run, by path; NaN after a filter has stopped."""
    if "time" not in run:
        return np.empty(0), {}
    time = np.asarray(run["time"])
    columns = {}
    for path in run.keys():
        if path == "time" or not path.startswith(group.strip("/")):
            continue
        series = run[path]
        if series.t is not None and series.ndim == 1 and np.array_equal(series.t, time[: len(series)]):
            values = np.pad(np.asarray(series), (0, len(time) - len(series)), constant_values=np.nan)
            columns[path] = TimeSeries(values, time, unit=series.unit)
    return time, columns


def run_to_pandas(run, group=""):
    """One column a path."""
    pandas = optional("pandas", "to_pandas()")
    time, series = _over_time(run, group)
    columns = {path: np.asarray(each) for path, each in series.items()}
    return pandas.DataFrame(columns, index=pandas.Index(time, name="time"))


def run_to_xarray(run, group=""):
    """One variable a path, with its unit as the attribute ``units``."""
    xarray = optional("xarray", "to_xarray()")
    time, series = _over_time(run, group)
    variables = {path: ("time", np.asarray(each), {"units": each.unit}) for path, each in series.items()}
    attributes = {key: run.summary[key] for key in ("title", "case", "run", "status") if run.summary.get(key)}
    return xarray.Dataset(variables, {"time": ("time", time, {"units": "s"})}, attributes)
