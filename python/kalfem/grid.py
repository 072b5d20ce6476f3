# SPDX-License-Identifier: Apache-2.0
"""Grids of settings."""

import itertools
from collections.abc import Mapping

import numpy as np

from .errors import InvalidInput, Issue


def points(grid):
    """The points of a grid, each a dictionary of settings.

    Parameters
    ----------
    grid : dict of sequences, or list of dict
        A dictionary gives every combination, the last name fastest; a single value stands for a list of one.

    >>> points({"simulate.seed": [1, 2], "estimate.filter": ["ukf", "ekf"]})[1]
    {'simulate.seed': 1, 'estimate.filter': 'ekf'}
    >>> len(points([{"simulate.seed": 1}, {"simulate.seed": 2}]))
    2
    """
    if isinstance(grid, Mapping):
        values = [sequence(each) for each in grid.values()]
        return [dict(zip(grid, combination)) for combination in itertools.product(*values)]
    all_points = list(grid)
    for i, point in enumerate(all_points):
        if not isinstance(point, Mapping):
            fix = "give a list of dictionaries, or a dictionary of lists"
            raise InvalidInput(Issue(f"grid[{i}] is {point!r}", "must be a dictionary of settings", fix))
    return [{name: _plain(value) for name, value in point.items()} for point in all_points]


def sequence(values):
    """A list of plain values; a single value stands for a list of one."""
    if isinstance(values, np.ndarray):
        return values.tolist()
    if isinstance(values, (str, bytes, Mapping)) or not hasattr(values, "__iter__"):
        return [_plain(values)]
    return [_plain(value) for value in values]


def _plain(value):
    """Numbers of NumPy as Python's: they are told and stored alike."""
    return value.item() if isinstance(value, np.generic) else value
