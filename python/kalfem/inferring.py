# SPDX-License-Identifier: Apache-2.0
"""What a record tells of unknown parameters, and which of several structures it comes from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .analysis import _update_arguments
from .compiled import core
from .display import rounded
from .errors import InvalidInput, Issue, unknown_name
from .parameters import Parameter, Parameters
from .posterior import Band, Posterior, Profile
from .progress import reporter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure
    from .analysis import Progress
    from .comparing import MeasuredDeflections, MeasuredModes, MeasuredRecord, MeasuredResponses


def infer(
    structure: Structure,
    t: ArrayLike,
    y: Any,
    *,
    sensors: Mapping[str, Sensor],
    unknown: Mapping[str, Any] | Iterable[str],
    inputs: Mapping[str, ArrayLike] | None = None,
    priors: Mapping[str, Mapping[str, Any]] | None = None,
    parameters: str | Sequence[str] = (),
    likelihood: str = "filter",
    correlation_time: float | str = 0.0,
    method: str = "importance",
    samples: int = 1000,
    seed: int = 1,
    profile: str | Sequence[str] = (),
    predictions: int = 40,
    filter: str = "auto",
    initial_state: Mapping[str, Mapping[str, Any]] | None = None,
    initial_state_from_record: bool = False,
    process_noise: float | str = 0.0,
    substeps: int | None = None,
    known_to: Mapping[str, float | str] | None = None,
    threads: int = 0,
    progress: Progress = True,
) -> Posterior:
    """The posterior of unknown parameters of a structure by a record.

    Parameters
    ----------
    structure, t, y, sensors, inputs, filter, initial_state, initial_state_from_record, process_noise, substeps, threads
        As in :func:`estimate`.
    unknown : dict of str to prior, or list of str
        As in :func:`estimate`: the prior is normal, log-normal with ``transform="log"``, cut at ``bounds``.
    priors : dict of str to dict, optional
        Priors of other shapes in the place of those: ``{"uniform": [lower, upper]}``, ``{"normal": [mean, std]}`` or
        ``{"lognormal": [median, std of the logarithm]}``, the last two with ``"bounds": [lower, upper]`` if they are cut.
        Texts carry units; a deviation may be a percentage.
    parameters : str or list of str
        Unknowns whose posterior is sought; all that do not drift if none is given. The filter integrates the others out.
    likelihood : str
        ``filter``: states and process noise are integrated out. ``simulation``: the record against the simulation from
        rest, with errors of the size that fits each sensor best, correlated over `correlation_time` [s].
    method : str
        ``importance``, ``laplace``, ``tempered``, ``metropolis`` or ``filter``: see the documentation of ``infer``.
    samples, seed : int
        Of the posterior. The same seed gives the same bits.
    profile : str or list of str
        Parameters whose profile likelihood is computed, about 20 searches each.
    predictions : int
        Draws whose response is simulated, for 95 % bands of the sensors; 0 for none.
    known_to : dict of str to float or str
        Standard deviations of numbers that are held fixed, as in :func:`estimate`: the posterior integrates them out.

    Returns
    -------
    Posterior
        ``found.mean``, ``found.std``, ``found.interval(0.95)``, ``found.correlation``, ``found["mount.k"]``,
        ``found.log_evidence``, ``found.warnings``.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, and where no start of the search has a likelihood.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("body").mass("m", 2.0).spring("k", "ground", "m", 800.0, 4.0))
    >>> t = np.arange(200) / 100
    >>> x = 5e-3 * np.exp(-t) * np.cos(np.sqrt(399) * t) + 1e-3 * np.random.default_rng(1).normal(size=200)
    >>> found = kf.infer(s, t, {"x": x}, sensors={"x": kf.displacement("body.m", noise=1e-3)},
    ...                  unknown={"body.k.stiffness": (780.0, 40.0)}, initial_state={"body.m": {"displacement": 5e-3}},
    ...                  progress=False)
    >>> bool(abs(found.mean[0] - 800) < 4 * found.std[0]), found.warnings
    (True, [])
    """
    arguments = {
        "sensors": dict(sensors),
        "unknown": _plain(unknown),
        "outputs": {},
        "filter": filter,
        "initial_state": dict(initial_state or {}),
        "initial_state_from_record": initial_state_from_record,
        "process_noise": process_noise,
        "threads": threads,
        "substeps": substeps,
        "known_to": dict(known_to or {}),
    }
    question = {
        "priors": _plain(priors or {}),
        "parameters": _names(parameters),
        "likelihood": likelihood,
        "correlation_time": correlation_time,
        "method": method,
        "samples": samples,
        "seed": seed,
        "profile": _names(profile),
        "predictions": predictions,
    }
    with reporter(progress) as bar:
        found = core.infer(structure, t, y, dict(inputs or {}), arguments, question, bar)
    return _posterior(found)


def infer_comparisons(
    structure: Structure,
    parameters: Mapping[str, Any] | Sequence[str],
    compare: Mapping[str, MeasuredModes | MeasuredResponses | MeasuredDeflections | MeasuredRecord],
    *,
    priors: Mapping[str, Mapping[str, Any]] | None = None,
    method: str = "importance",
    samples: int = 1000,
    seed: int = 1,
    profile: str | Sequence[str] = (),
    progress: Progress = True,
) -> Posterior:
    """The posterior of parameters of linear substructures by what an updating compares.

    Modes count with the covariances of their shapes, ``compare={"test": found.measured("frame", points)}``.

    Parameters
    ----------
    structure, parameters, compare
        As in :func:`update`: the prior of a parameter is normal with its ``std``, cut at its bounds.
    priors : dict of str to dict, optional
        Priors of other shapes, as in :func:`infer`. A parameter without ``std`` and without a prior here needs bounds.
    method, samples, seed, profile
        As in :func:`infer`; ``method`` is not ``filter``.

    Returns
    -------
    Posterior

    Examples
    --------
    >>> import kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3))
    >>> tested = kf.MeasuredDeflections({"m.1": 10.0}, {"m.1": "4 mm"}, std="0.01 mm")
    >>> found = kf.infer_comparisons(s, {"m.k.stiffness": (2e3, 1e3)}, {"pull": tested}, progress=False)
    >>> abs(found.mean[0] - 2500) < 5, 5 < found.std[0] < 8
    (True, True)
    """
    compared = _update_arguments({"parameters": parameters, "compare": compare})
    question = {
        "priors": _plain(priors or {}),
        "method": method,
        "samples": samples,
        "seed": seed,
        "profile": _names(profile),
    }
    with reporter(progress) as bar:
        found = core.infer_comparisons(structure, compared, question, bar)
    return _posterior(found)


def _posterior(found):
    entries = found.pop("entries")
    return Posterior(
        names=[each["name"] for each in entries],
        units=[each["unit"] for each in entries],
        profiles={name: Profile(**each) for name, each in found.pop("profiles").items()},
        bands={name: Band(**each) for name, each in found.pop("bands").items()},
        details=entries,
        **found,
    )


def _plain(given):
    """A dictionary for a mapping, a list for names."""
    return dict(given) if isinstance(given, Mapping) else list(given)


def _names(given):
    return [given] if isinstance(given, str) else list(given)


@dataclass(frozen=True, repr=False)
class ComparedStructure:
    """What a record says of one of several structures, from :func:`kalfem.compare`."""

    name: str
    probability: float  #: P(structure | y), of those that are compared
    log_evidence: float | None  #: ln Z; None where there is none
    log_evidence_std: float | None
    occam: float | None  #: ln Z less the largest ln p(y | theta): what the freedom of its parameters costs
    words: str  #: the best one against this one, after Kass and Raftery; empty for the best
    parameters: Parameters  #: mean, deviation and 95 % interval of its posterior
    warnings: list[str]  #: why its evidence may not hold
    failure: str  #: why it has none; empty: it has

    def __repr__(self):
        if self.failure:
            return f"{self.name}: {self.failure}"
        spread = rounded(self.log_evidence_std, self.log_evidence_std)
        return f"{self.name}: P = {self.probability:.3g}, ln Z = {rounded(self.log_evidence, self.log_evidence_std)} +- {spread}"


def compare(
    structures: Mapping[str, Structure],
    t: ArrayLike,
    y: Any,
    *,
    sensors: Mapping[str, Sensor],
    unknown: Mapping[str, Any],
    inputs: Mapping[str, ArrayLike] | None = None,
    priors: Mapping[str, Mapping[str, Any]] | None = None,
    method: str = "importance",
    samples: int = 1000,
    seed: int = 1,
    filter: str = "auto",
    initial_state: Mapping[str, Mapping[str, Any]] | None = None,
    initial_state_from_record: bool = False,
    process_noise: float | str = 0.0,
    substeps: int | None = None,
    threads: int = 0,
    progress: Progress = True,
) -> list[ComparedStructure]:
    """Which of several structures a record comes from: each by its evidence, P_i = Z_i / sum_j Z_j.

    Parameters
    ----------
    structures : dict of str to Structure
        By names of your own: ``{"linear": s, "cubic": other}``.
    unknown, priors : dict of str to what :func:`infer` takes
        Of each structure by its name: ``{"linear": {...}, "cubic": {...}}``. Unknowns that are common stand in each.
    t, y, sensors, inputs, method, samples, seed, filter, initial_state, initial_state_from_record, process_noise
        As in :func:`infer`, for all of them. An input that a structure does not have is refused.
    substeps, threads
        As in :func:`infer`.

    Returns
    -------
    list of ComparedStructure
        The most probable first: ``found[0].name``, ``found[0].probability``, ``found[1].words``.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, by the structure's name.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> def mass(c):
    ...     return kf.Structure().add(kf.lumped("body").mass("m", 2.0).spring("k", "ground", "m", 800.0, c))
    >>> t = np.arange(200) / 100
    >>> x = 5e-3 * np.exp(-t) * np.cos(np.sqrt(399) * t) + 1e-4 * np.random.default_rng(1).normal(size=200)
    >>> unknown = {"body.k.stiffness": (780.0, 40.0)}
    >>> found = kf.compare({"light": mass(1.0), "right": mass(4.0)}, t, {"x": x},
    ...                    sensors={"x": kf.displacement("body.m", noise=1e-4)},
    ...                    unknown={"light": unknown, "right": unknown},
    ...                    initial_state={"body.m": {"displacement": 5e-3}}, progress=False)
    >>> found[0].name, found[1].words
    ('right', 'very strong')
    """
    _check_names(structures, unknown, priors or {})
    arguments = {
        "sensors": dict(sensors),
        "outputs": {},
        "filter": filter,
        "initial_state": dict(initial_state or {}),
        "initial_state_from_record": initial_state_from_record,
        "process_noise": process_noise,
        "threads": threads,
        "substeps": substeps,
    }
    question = {
        "priors": {name: _plain((priors or {}).get(name, {})) for name in structures},
        "parameters": [],
        "likelihood": "filter",
        "correlation_time": 0.0,
        "method": method,
        "samples": samples,
        "seed": seed,
        "profile": [],
        "predictions": 0,
    }
    unknowns = {name: _plain(each) for name, each in unknown.items()}
    with reporter(progress) as bar:
        found = core.compare(dict(structures), t, y, dict(inputs or {}), arguments, unknowns, question, bar)
    return [
        ComparedStructure(
            parameters=Parameters(Parameter.from_summary(entry["name"], entry) for entry in each.pop("entries")), **each
        )
        for each in found
    ]


def _check_names(structures, unknown, priors):
    if not isinstance(structures, Mapping):
        raise InvalidInput(Issue("structures: it is no dictionary", "each has a name", 'write {"linear": s, "cubic": other}'))
    for name in [*unknown, *priors]:
        if name not in structures:
            raise unknown_name("structure", name, structures)
    missing = [name for name in structures if name not in unknown]
    if missing:
        raise InvalidInput(Issue(f"unknown: there are none of '{missing[0]}'", "its evidence is that of its unknowns", ""))
