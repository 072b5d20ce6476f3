# SPDX-License-Identifier: Apache-2.0
"""Case files, run in this process."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .compiled import core
from .progress import reporter
from .results import Run


def run(
    case: str | Path,
    set: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    steps: str = "everything",
    progress: bool | Callable[[float, str], None] = True,
) -> Run:
    """Run every step that a case file declares, as the command does.

    Parameters
    ----------
    case : path
    set : dict, optional
        Keys with the values that they get instead of those of the case: ``{"simulate.duration": "4 s"}``. A text is
        read as the case file would be; numbers, lists and dictionaries are taken as they are; None removes the key. An
        item of a list is its number from 0, or its ``name``. Paths in values are relative to the case.
    out : path, optional
        A folder for the files that the command writes, bit for bit. If it is not given, nothing is written.
    steps : str
        ``everything``, or what one of ``modes``, ``simulate``, ``estimate``, ``predict``, ``update``, ``infer`` and
        ``place`` needs.
    progress : bool or callable
        Show a bar, or call a function with the fraction done and words. An exception that it raises stops the run.

    Returns
    -------
    Run
        ``run["estimate/body.3/displacement"]``, ``run.parameters``, ``run.verdict``, ``run.report("report.html")``.

    Raises
    ------
    InvalidInput
        With every problem of the case in ``.issues``, by file and line, or by the key of `set`.
    """
    changes = as_changes(set)
    folder = "" if out is None else os.fspath(out)
    with reporter(progress) as bar:
        done = core.run_case(os.fspath(case), changes, folder, steps, bar)
    return Run.from_memory(done.summary, done.datasets, done.write_report)


def as_changes(settings: Mapping[str, Any] | None) -> list[tuple[str, str | None]]:
    """Keys of a case with their values as YAML; None removes the key."""
    return [(key, None if value is None else as_yaml(value)) for key, value in (settings or {}).items()]


def as_yaml(value: Any) -> str:
    """A value of a key as the case file would have it; a text is taken as it is."""
    return value if isinstance(value, str) else _flow(value)


def _flow(value):
    """A value as YAML on one line."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(key))}: {_flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, (list, tuple, range)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, Path):
        value = str(value)
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)
