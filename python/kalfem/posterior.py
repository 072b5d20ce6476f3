# SPDX-License-Identifier: Apache-2.0
"""Samples of a posterior and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .display import rounded
from .errors import unknown_name
from .parameters import Parameter, Parameters


@dataclass(frozen=True)
class Profile:
    """ln p(y | theta) along one parameter, the others at their most likely values."""

    values: np.ndarray  #: ascending, of the parameter
    log_likelihood: np.ndarray  #: less the largest one; -inf where there is none
    lower: float | None  #: of the 95 % interval, where it has fallen by 1.92; None: it has not
    upper: float | None
    unit: str


@dataclass(frozen=True)
class Band:
    """Response of a sensor at draws of the posterior, sample by sample."""

    mean: np.ndarray
    lower: np.ndarray  #: of 95 %, with the sensor's noise
    upper: np.ndarray
    coverage: float  #: share of the measured samples inside
    unit: str


@dataclass(frozen=True, repr=False)
class Posterior:
    """Samples of a posterior p(theta | y) = p(y | theta) p(theta) / Z, from :func:`kalfem.infer` or
    :meth:`kalfem.Likelihood.sample`."""

    names: list[str]
    units: list[str]
    values: np.ndarray  #: samples [n, p]
    weights: np.ndarray  #: their sum is 1
    log_likelihood: np.ndarray
    log_prior: np.ndarray
    log_evidence: float | None  #: ln Z; None where the method gives none
    log_evidence_std: float | None
    evaluations: int  #: of the likelihood
    warnings: list[str]  #: why the samples may not hold
    method: str = ""  #: in words
    likelihood: str = ""  #: in words
    chains: int = 1  #: Markov chains; equally long, one after the other in `values`
    effective_samples: float | None = None  #: that weighted samples are worth
    pareto_k: float | None = None  #: of their weights; above 0.7 they do not hold
    identifiability: str = ""  #: what the record tells of combinations of parameters, in words
    profiles: dict[str, Profile] = field(default_factory=dict)  #: of the parameters that were asked for
    bands: dict[str, Band] = field(default_factory=dict)  #: by sensor
    details: list[dict] = field(default_factory=list)  #: of each parameter: median, intervals, most probable value, prior

    def __getitem__(self, name: str) -> np.ndarray:
        """The samples of one parameter [n], to be taken with `weights`."""
        if name not in self.names:
            raise unknown_name("parameter", name, self.names)
        return self.values[:, self.names.index(name)]

    @property
    def mean(self) -> np.ndarray:
        return self.weights @ self.values

    @property
    def covariance(self) -> np.ndarray:
        """Of the parameters [p, p], without the bias of few samples."""
        centred = self.values - self.mean
        return (centred.T * self.weights) @ centred / (1.0 - self.weights @ self.weights)

    @property
    def std(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> np.ndarray:
        """Of the parameters [p, p]; zero beside a parameter that does not vary."""
        std = self.std
        inverse = np.divide(1.0, std, out=np.zeros_like(std), where=std > 0.0)
        correlation = inverse[:, None] * self.covariance * inverse
        np.fill_diagonal(correlation, 1.0)
        return correlation

    @property
    def parameters(self) -> Parameters:
        """By name: ``found.parameters["mount.k"].interval``, of 95 %."""
        rows = zip(self.names, self.units, self.mean, self.std, self.interval())
        return Parameters(Parameter(n, float(m), float(s), None, tuple(map(float, i)), u) for n, u, m, s, i in rows)

    def quantile(self, probability) -> np.ndarray:
        """Values that the parameters stay below with some probability [p]; of several probabilities [k, p]."""
        columns = []
        for samples in self.values.T:
            order = np.argsort(samples, kind="stable")
            reached = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
            columns.append(np.interp(probability, reached, samples[order]))
        return np.stack(columns, axis=-1)

    def interval(self, probability: float = 0.95) -> np.ndarray:
        """The central interval of each parameter [p, 2]."""
        tail = 0.5 * (1.0 - probability)
        return self.quantile([tail, 1.0 - tail]).T

    def draws(self, count: int, seed: int = 1) -> np.ndarray:
        """Samples with equal weights [count, p], by systematic resampling."""
        at = (np.arange(count) + np.random.default_rng(seed).uniform()) / count
        chosen = np.searchsorted(np.cumsum(self.weights), at, side="right")
        return self.values[np.minimum(chosen, len(self.weights) - 1)]

    def __repr__(self):
        lines = [f"Posterior: {self.method}" if self.method else "Posterior"]
        if len(self.values):
            lines += map(str, self.parameters.values())
        if self.log_evidence is not None:
            spread = "" if self.log_evidence_std is None else f" +- {rounded(self.log_evidence_std, self.log_evidence_std)}"
            lines.append(f"ln Z = {rounded(self.log_evidence, self.log_evidence_std)}{spread}")
        return "\n".join(lines + [f"warning: {each}" for each in self.warnings])
