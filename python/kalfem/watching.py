# SPDX-License-Identifier: Apache-2.0
"""A live case that runs within a program of Python, as ``kalfem watch`` runs it by itself."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .compiled import core
from .running import as_changes


class Watch(core.Watch):
    """The filter of a live case; :func:`watch` makes it."""

    def take(self, samples: str | bytes | Mapping[str, Any] | Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
        """Take samples as they come, late ones and those of single channels too.

        Parameters
        ----------
        samples : str, bytes, dict or list of dicts
            Lines of JSON or CSV as ``kalfem watch`` reads them; or ``{"t": 1.25, "a3": 0.31, "road": 0.002}``, and with
            ``dt`` successive ones, ``{"t": 1.25, "dt": 0.002, "a3": [0.31, None, 0.28]}``, arrays too.

        Returns
        -------
        list of dict
            The estimates that are due since, one every ``live.every``: `t`, `condition`, `verdict`, `reasons`,
            `health`, `parameters`, `outputs`, `events` ... as docs/live.md lists them; and, with ``live.alarms``, the alarms, each
            under the key `alarm`, and the days that are over, under `trend`.

        Warns
        -----
        RuntimeWarning
            Of lines that cannot be used and of channels that the case does not have; the others are taken.
        """
        self._take(samples if isinstance(samples, str) else _lines(samples))
        return self._said()

    def tell(self) -> dict[str, Any]:
        """The estimates where the filter stands."""
        self._tell()
        return self._said()[-1]

    def write_state(self, file: str | Path) -> None:
        """Keep the filter and what waits in it, so that :func:`watch` goes on from there with the same bits."""
        self._write_state(os.fspath(file))

    def _said(self):
        for complaint in self._take_complaints():
            warnings.warn(complaint, RuntimeWarning, stacklevel=3)
        return [json.loads(line) for line in self._take_said()]


def _lines(samples):
    if isinstance(samples, bytes):
        return samples.decode("utf-8", "replace")
    blocks = [samples] if isinstance(samples, Mapping) else samples
    return "\n".join(json.dumps({name: _plain(value) for name, value in block.items()}) for block in blocks)


def _plain(value):
    """A number or numbers of JSON; what is not finite is missing."""
    if isinstance(value, str):
        return value
    if np.ndim(value) == 0:
        return None if value is None or not np.isfinite(value) else float(value)
    return [_plain(each) for each in value]


def watch(case: str | Path, set: Mapping[str, Any] | None = None, state: str | Path | None = None) -> Watch:
    """Open a case with ``live`` in the place of its record, to be fed by :meth:`Watch.take`.

    Parameters
    ----------
    case : path
    set : dict, optional
        Keys with other values, as of :func:`kalfem.run`.
    state : path, optional
        A file that :meth:`Watch.write_state` wrote, to go on from.

    Returns
    -------
    Watch

    Raises
    ------
    InvalidInput
        With every problem of the case, by file and line; where the state is damaged or belongs to another case.
    """
    made = Watch(os.path.abspath(case), as_changes(set))
    if state is not None:
        made._read_state(os.fspath(state))
    return made
