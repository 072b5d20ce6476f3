# SPDX-License-Identifier: Apache-2.0
"""Several models of one record as one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .errors import InvalidInput, Issue
from .results import Run
from .series import TimeSeries


@dataclass
class Mixture:
    """What several models say together."""

    weights: dict[str, float]  #: probability of each model, all being as probable before
    series: dict[str, TimeSeries]  #: by their paths in a run, with ``std``: ``series["estimate/mount/force"]``

    def __getitem__(self, path: str) -> TimeSeries:
        return self.series[path.strip("/")]

    def __repr__(self):
        weights = ", ".join(f"{name} {100 * weight:.3g} %" for name, weight in self.weights.items())
        return f"Mixture({weights}; {len(self.series)} series)"


def mixture(runs: Mapping[str, Run]) -> Mixture:
    """Weigh estimates of one record by their evidence, and mix their series.

    The evidence p(y) is the filter's own likelihood, in which the unknowns are integrated out: w_i = L_i / sum_j L_j.
    Series are mean = sum w_i m_i, std^2 = sum w_i (s_i^2 + (m_i - mean)^2): their bands hold the spread between models.
    A case does this by ``estimate.alternatives``.

    Parameters
    ----------
    runs : dict of str to Run
        Of :func:`estimate`, by names of your own: ``{"cubic": a, "quintic": b}``. One that stopped has no weight.

    Returns
    -------
    Mixture
        Of the series with a standard deviation that all runs with a weight have.

    Raises
    ------
    InvalidInput
        Where no run ran to its end, one has no likelihood, or records have different lengths.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> def body(c):
    ...     return kf.Structure().add(kf.lumped("body").mass("m", 2.0).spring("k", "ground", "m", 800.0, c))
    >>> t = np.arange(200) / 100
    >>> x = 5e-3 * np.exp(-t) * np.cos(np.sqrt(399) * t) + 1e-4 * np.random.default_rng(1).normal(size=200)
    >>> runs = {name: kf.estimate(body(c), t, {"x": x}, sensors={"x": kf.displacement("body.m", noise=1e-4)},
    ...                           unknown={"body.k.stiffness": (780.0, 40.0)}, diagnose=False,
    ...                           initial_state={"body.m": {"displacement": 5e-3}}, progress=False)
    ...         for name, c in (("light", 1.0), ("right", 4.0))}
    >>> kf.mixture(runs).weights["right"] > 0.99
    True
    """
    evidence = np.array([_evidence(name, run) for name, run in runs.items()])
    if not np.isfinite(evidence).any():  # nor of an empty dictionary
        raise InvalidInput(Issue("a mixture needs a run that ran to its end", "there is none", "give such runs"))
    lengths = {len(run["time"]) for run in runs.values()}
    if len(lengths) > 1:
        why = "evidences of different records cannot be weighed"
        raise InvalidInput(Issue(f"the runs have different numbers of samples: {sorted(lengths)}", why, "estimate one record"))
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    named = dict(zip(runs, map(float, weights)))
    weighty = {name: run for name, run in runs.items() if named[name] > 0.0}
    paths = set.intersection(*(set(run.keys()) for run in weighty.values()))
    series = {path: _mixed(path, weighty, named) for path in sorted(paths) if f"{path}_std" in paths}
    return Mixture(named, series)


def _evidence(name, run):
    if any(reason.code == "failed" for reason in run.verdict.reasons):
        return -np.inf
    value = run.summary.get("estimation", {}).get("log_likelihood")
    if value is None:
        raise InvalidInput(Issue(f"{name}: this run has no likelihood", "it is no estimation", "give runs of kf.estimate"))
    return value


def _mixed(path, runs, weights):
    parts = [(weights[name], run[path]) for name, run in runs.items()]
    first = parts[0][1]
    mean = sum(weight * np.asarray(part) for weight, part in parts)
    variance = sum(weight * (part.std**2 + (np.asarray(part) - mean) ** 2) for weight, part in parts)
    return TimeSeries(mean, first.t, np.sqrt(variance), first.unit, path)
