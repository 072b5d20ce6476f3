# SPDX-License-Identifier: Apache-2.0
"""The likelihood of a case as a function of Python, for samplers of others."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from functools import lru_cache
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from .compiled import core
from .errors import unknown_name
from .posterior import Posterior
from .progress import reporter
from .running import as_changes


@lru_cache(maxsize=4)
def _opened(case, _written_at, changes):
    """Of each process one: a worker gets the same likelihood with every task."""
    return core.CaseLikelihood(case, list(changes))


class Likelihood:
    """ln p(data | theta) of the parameters of a case with ``infer``, by the filter, a simulation or comparisons.

    Parameters
    ----------
    case : path
    set : dict, optional
        Changes of the case as in :func:`kalfem.run`.

    Attributes
    ----------
    names, units : list of str
        The parameters, in the order of theta.
    start : array
        Where a search may begin: the initial values.

    Notes
    -----
    A call releases the interpreter lock, so threads run side by side. Pickled, it carries the case and the changes; a
    worker process reads the case once, when it first needs it.

    Examples
    --------
    ``emcee.EnsembleSampler(32, len(f.names), f.log_posterior)``, ``dynesty.NestedSampler(f, f.prior_transform,
    len(f.names))``.
    """

    def __init__(self, case: str | Path, set: Mapping[str, Any] | None = None):
        self._case, self._set = os.path.abspath(case), dict(set or {})
        self._opened = None
        opened = self._open()
        self.names, self.units, self.start = opened.names, opened.units, opened.start

    def _open(self):
        if self._opened is None:
            self._opened = _opened(self._case, os.stat(self._case).st_mtime_ns, tuple(as_changes(self._set)))
        return self._opened

    def __getstate__(self):
        return {**self.__dict__, "_opened": None}

    def __repr__(self):
        return f"<Likelihood of {', '.join(self.names)}: {self._open().words}>"

    def __call__(self, theta) -> float:
        """ln p(data | theta) at values [p], or a dict by name; -inf where there is no model or the filter fails."""
        return self._open().log_likelihood(self._values(theta))

    def log_prior(self, theta) -> float:
        """ln p(theta), normalised; -inf outside the prior's support."""
        return self._open().log_prior(self._values(theta))

    def log_posterior(self, theta) -> float:
        """ln p(data | theta) + ln p(theta)."""
        prior = self.log_prior(theta)
        return prior + self(theta) if math.isfinite(prior) else -math.inf

    def prior_transform(self, u) -> np.ndarray:
        """theta of a point of the unit cube: uniform points become samples of the prior."""
        inside = np.clip(np.asarray(u, float), 1e-300, 1.0 - 1e-16)
        return self._open().from_standard_normal([NormalDist().inv_cdf(each) for each in inside])

    def map(self, thetas, executor: Executor | None = None) -> np.ndarray:
        """ln p(data | theta) of many theta, on the workers of an executor (by default here, one after the other)."""
        values = [self._values(theta) for theta in thetas]
        return np.array(list(executor.map(self, values) if executor else map(self, values)))

    def sample(
        self,
        method: str = "importance",
        samples: int = 1000,
        seed: int = 1,
        executor: Executor | None = None,
        workers: int | None = None,
        progress: bool | Callable[[float, str], None] = True,
    ) -> Posterior:
        """Samples of the posterior by kalfem's own samplers, the same bits wherever the likelihoods are computed.

        Parameters
        ----------
        method : str
            ``importance``, ``laplace``, ``tempered`` or ``metropolis``: see the documentation of ``infer``.
        executor : concurrent.futures.Executor, optional
            Computes the likelihoods: processes, ``dask.distributed.Client.get_executor()`` or
            ``mpi4py.futures.MPIPoolExecutor()``. By default threads of this process.
        workers : int, optional
            Likelihoods that are asked for at once; by default one per processor.
        """
        evaluate = (lambda theta: executor.submit(self, theta).result()) if executor else None
        with reporter(progress) as bar:
            found = self._open().sample(method, samples, seed, workers or os.cpu_count() or 1, evaluate, bar)
        return Posterior(names=self.names, units=self.units, **found)

    def _values(self, theta):
        if not isinstance(theta, Mapping):
            return np.asarray(theta, float)
        for name in theta:
            if name not in self.names:
                raise unknown_name("parameter", name, self.names)
        return np.array([float(theta[name]) for name in self.names])
