# SPDX-License-Identifier: Apache-2.0
"""Modes of a structure from its responses alone, with their uncertainty."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .compiled import core
from .errors import InvalidInput, Issue, unknown_name
from .mode_sets import ModeSet
from .progress import reporter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .analysis import Progress
    from .comparing import MeasuredModes


@dataclass(frozen=True)
class IdentifiedMode:
    """A mode that was identified, with the covariance of what was found."""

    frequency: float  #: undamped natural frequency [Hz]
    frequency_std: float  #: [Hz]
    frequency_interval: tuple[float, float]  #: 95 % [Hz]
    damping: float  #: ratio to critical
    damping_std: float
    damping_interval: tuple[float, float]  #: 95 %
    covariance: np.ndarray = field(repr=False)  #: of frequency and damping, shape (2, 2)
    degrees_of_freedom: float = field(repr=False)  #: of the standard deviations: how well the record tells them
    shape: np.ndarray = field(repr=False)  #: complex, one a channel; the largest entry is 1
    shape_std: np.ndarray = field(repr=False)  #: standard deviations of real parts + 1j those of imaginary parts
    shape_covariance: np.ndarray = field(repr=False)  #: of real parts, then imaginary ones, shape (2 n, 2 n)
    phase_collinearity: float = field(repr=False)  #: in [0, 1]; 1 where all channels move in phase or against it
    participation: float = field(repr=False)  #: share of the references' variance
    order: int = field(repr=False)  #: of the model that the mode is taken from
    orders: int = field(repr=False)  #: in which it was found
    peak: tuple[float, float] | None = field(repr=False)  #: of the spectra: frequency [Hz] and MAC; None: there is none


@dataclass(frozen=True)
class IdentifiedModes:
    """Modes of a record by frequency, ``modes[0].frequency``; shapes of all, ``modes["a3"]`` is the row of a channel."""

    modes: list[IdentifiedMode]
    channels: list[str]  #: of the shapes
    references: list[str]
    sample_rate: float  #: of the samples that were used [Hz]
    block_rows: int
    max_order: int
    diagram: dict[str, np.ndarray] = field(repr=False)  #: every pole: order, frequency, frequency_std, damping, stable
    remarks: list[str] = field(repr=False)  #: doubts about settings and record, a sentence each

    def __getitem__(self, key):
        if not isinstance(key, str):
            return self.modes[key]
        if key not in self.channels:
            raise unknown_name("channel", key, self.channels)
        return self.shapes[self.channels.index(key)]

    def __len__(self):
        return len(self.modes)

    def __iter__(self):
        return iter(self.modes)

    def __repr__(self):
        return "\n".join(
            f"{i}: {mode.frequency:.5g} +- {mode.frequency_std:.2g} Hz, damping {100 * mode.damping:.3g} "
            f"+- {100 * mode.damping_std:.2g} %"
            for i, mode in enumerate(self.modes, 1)
        ) or "no modes"

    @property
    def frequencies(self) -> np.ndarray:
        """[Hz], shape (modes,)."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def damping(self) -> np.ndarray:
        """Ratios to critical, shape (modes,)."""
        return np.array([mode.damping for mode in self.modes])

    @property
    def shapes(self) -> np.ndarray:
        """Complex, shape (channels, modes)."""
        return np.array([mode.shape for mode in self.modes]).T.reshape(len(self.channels), len(self.modes))

    @property
    def real_shapes(self) -> np.ndarray:
        """Each shape turned to the phase at which its real part is largest; the largest entry is 1."""
        shapes = self.shapes
        turned = (shapes * np.exp(-0.5j * np.angle((shapes**2).sum(axis=0)))).real
        return turned / np.take_along_axis(turned, abs(turned).argmax(axis=0)[None, :], axis=0)

    @property
    def mode_set(self) -> ModeSet:
        """The modes with all that is known of their errors, as :func:`update` and :func:`correlate` take them."""
        return ModeSet(
            points=list(self.channels),
            frequencies=self.frequencies,
            frequency_std=np.array([mode.frequency_std for mode in self.modes]),
            dampings=self.damping,
            damping_std=np.array([mode.damping_std for mode in self.modes]),
            shapes=self.shapes,
            covariances=[mode.shape_covariance for mode in self.modes],
            degrees_of_freedom=np.array([mode.degrees_of_freedom for mode in self.modes]),
        )

    def measured(
        self, substructure: str, points: Mapping[str, str] | Sequence[str] | None = None, **options: Any
    ) -> MeasuredModes:
        """What :func:`update` compares a model with: see :meth:`ModeSet.measured`."""
        return self.mode_set.measured(substructure, points, **options)


def _channels_of(record, t):
    """Times, samples by name, and units of a record in any of its forms."""
    if isinstance(record, (str, Path, os.PathLike)):
        from .records import read

        record = read(record)
    if t is None:
        t = getattr(record, "t", None)
    if t is None:
        raise InvalidInput([Issue("t: no times are given", "the record does not hold them", "give t in seconds")])
    if isinstance(record, Mapping) or hasattr(record, "keys"):
        names = [str(name) for name in record.keys()]
        return t, record, names, [getattr(record[name], "unit", None) or "" for name in record.keys()]
    values = np.asarray(record, float)
    count = values.shape[1] if values.ndim == 2 else 1
    return t, values, [f"{i}" for i in range(1, count + 1)], [""] * count


def modal(
    record: Mapping[str, ArrayLike] | ArrayLike | str | Path,
    t: ArrayLike | None = None,
    *,
    channels: Sequence[str] = (),
    references: Sequence[str] = (),
    inputs: Sequence[str] = (),
    segment: float = 0.0,
    estimator: Literal["h1", "h2", "hv"] = "h1",
    window: Literal["hann", "rectangular"] = "hann",
    band: tuple[float, float] | None = None,
    subspace: Literal["covariance", "data"] = "covariance",
    block_rows: int = 0,
    max_order: int = 0,
    blocks: int = 100,
    stabilisation: Mapping[str, float] | None = None,
    poles: Sequence[float | tuple[float, int]] = (),
    threads: int = 0,
    progress: Progress = True,
) -> IdentifiedModes:
    """Identify modes from responses to unknown excitation that is about white over the band, or to measured forces.

    Covariance-driven or data-driven stochastic subspace identification over all model orders; standard deviations come from the
    scatter of the correlations over blocks of the record, to first order. Poles that hold over the orders are modes.

    With `inputs` frequency responses are measured first, and the modes are identified from these, see
    :func:`modal_of_responses`.

    Parameters
    ----------
    record : Record, dict of str to array, DataFrame, array of shape (samples, channels), or path of a measured file
    t : array, shape (samples,), optional
        Even times [s]; not needed where the record holds them.
    channels : list of str
        Responses to identify from; default: all of the record.
    references : list of str
        Channels that all are correlated with; default: all.
    inputs : list of str
        Channels that are forces, or the motion of the base.
    segment : float
        With `inputs`: length of the averaged segments [s]; 0: such that sixteen, overlapping by half, cover the record.
    estimator : str
        With `inputs`: ``h1`` (noise on the responses), ``h2`` (on the force), ``hv`` (on both).
    window : str
        With `inputs`: ``hann``, or ``rectangular`` where responses decay within a segment.
    band : (float, float), optional
        Modes are looked for between these frequencies [Hz]: filters and resamples.
    subspace : str
        ``covariance``: singular vectors of the correlations of future and past; ``data``: of the future's projection
        onto the past.
    block_rows : int
        Of the Hankel matrix; 0: so many that its lags reach over a period of the lowest mode.
    max_order : int
        Largest order of the models; 0: four a channel, 30 to 100.
    blocks : int
        Parts of the record whose scatter gives the deviations.
    stabilisation : dict of str to float, optional
        Limits by name: ``frequency``, ``damping``, ``mac``, ``largest_damping``, ``frequency_std``, ``damping_std``,
        ``least_share``, ``least_participation``; see `docs/modal.md`.
    poles : list of float or (float, int)
        Poles of the stabilisation diagram that are the modes, by frequency [Hz], or frequency and order; default: those
        that hold over the orders.

    Returns
    -------
    IdentifiedModes

    Raises
    ------
    InvalidInput
        With everything that is wrong: fewer than two channels, missing samples, a dead channel, a record too short.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> rng = np.random.default_rng(1)
    >>> z, mu = 0j, 2 * np.pi * 5 * (-0.01 + 1j)
    >>> y = np.array([(z := np.exp(mu / 50) * z + rng.normal()).real for _ in range(20000)])
    >>> noise = rng.normal(size=(2, y.size))
    >>> found = kf.modal({"a": y + noise[0], "b": -0.5 * y + noise[1]}, t=np.arange(y.size) / 50, progress=False)
    >>> len(found), abs(found[0].frequency - 5) < 4 * found[0].frequency_std
    (1, True)
    """
    t, y, names, units = _channels_of(record, t)
    if channels and not isinstance(y, np.ndarray):
        known = dict(zip(names, units))
        for name in [*inputs, *channels]:
            if name not in known:
                raise unknown_name("channel", name, names)
        names = [*inputs, *channels]
        units = [known[name] for name in names]
        channels = ()
    options = {
        **_options(band, max_order, stabilisation, threads),
        "channels": list(channels),
        "references": list(references),
        "inputs": list(inputs),
        "segment": segment,
        "estimator": estimator,
        "window": window,
        "subspace": subspace,
        "poles": [pole if isinstance(pole, tuple) else (float(pole), 0) for pole in poles],
        "block_rows": block_rows,
        "blocks": blocks,
    }
    with reporter(progress) as bar:
        found = core.modal(t, y, names, units, options, bar)
    found["modes"] = [IdentifiedMode(**each) for each in found["modes"]]
    return IdentifiedModes(**found)


def _options(band, max_order, stabilisation, threads):
    """What both methods take."""
    return {
        "channels": [],
        "references": [],
        "inputs": [],
        "segment": 0.0,
        "estimator": "h1",
        "window": "hann",
        "band": band,
        "subspace": "covariance",
        "poles": [],
        "block_rows": 0,
        "max_order": max_order,
        "blocks": 100,
        "stabilisation": dict(stabilisation or {}),
        "threads": threads,
    }


def modal_of_responses(
    frequencies: ArrayLike,
    responses: Mapping[str, ArrayLike] | ArrayLike,
    *,
    outputs: Sequence[str] = (),
    std: Mapping[str, ArrayLike] | ArrayLike | None = None,
    band: tuple[float, float] | None = None,
    max_order: int = 0,
    stabilisation: Mapping[str, float] | None = None,
    threads: int = 0,
    progress: Progress = True,
) -> IdentifiedModes:
    """Identify modes from frequency responses to known forces.

    The poly-reference least-squares complex frequency-domain method (p-LSCF, "PolyMAX") over many orders; the poles that
    hold over these start a modal model that is fitted to all responses by least squares. Standard deviations come from
    the scatter about the fit.

    Parameters
    ----------
    frequencies : array, shape (lines,)
        [Hz], ascending.
    responses : dict of str to complex array of shape (lines, outputs), or one such array
        By input: output per input, motions taken as exp(+i 2 pi f t).
    outputs : list of str
        Names of the outputs; default: ``"1"``, ``"2"``, ...
    std : dict of str to array, or array, optional
        Standard deviations of the real and of the imaginary part, each, as `responses`: they weigh the lines.
    band : (float, float), optional
        Lines that are used [Hz].
    max_order : int
        Largest number of poles of a model; 0: 120.
    stabilisation : dict of str to float, optional
        Limits by name, as of :func:`modal`.

    Returns
    -------
    IdentifiedModes

    Raises
    ------
    InvalidInput
        With everything that is wrong: sizes that do not fit, fewer than two outputs or 32 lines, an output without motion.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> f = np.linspace(1, 10, 400)
    >>> s, rng = 2j * np.pi * f, np.random.default_rng(1)
    >>> peak = 1 / (s**2 + 2 * 0.01 * 2 * np.pi * 5 * s + (2 * np.pi * 5) ** 2)
    >>> noise = 1e-6 * (rng.normal(size=(400, 2)) + 1j * rng.normal(size=(400, 2)))
    >>> found = kf.modal_of_responses(f, np.outer(peak, [1, -0.5]) + noise, outputs=["a", "b"], progress=False)
    >>> len(found), abs(found[0].frequency - 5) < 4 * found[0].frequency_std
    (1, True)
    """
    lines = np.asarray(frequencies, float)
    by_input = {str(k): np.asarray(v, complex) for k, v in _by_input(responses).items()}
    first = next(iter(by_input.values()))
    names = list(outputs) or [f"{i}" for i in range(1, (first.shape[1] if first.ndim == 2 else 1) + 1)]
    deviations = {} if std is None else {str(k): np.asarray(v, float) for k, v in _by_input(std).items()}
    options = _options(band, max_order, stabilisation, threads)
    with reporter(progress) as bar:
        found = core.modal_of_responses(lines, by_input, names, deviations, options, bar)
    found["modes"] = [IdentifiedMode(**each) for each in found["modes"]]
    return IdentifiedModes(**found)


def _by_input(given):
    return given if isinstance(given, Mapping) else {"1": given}


def merge_setups(
    setups: Sequence[IdentifiedModes] | Mapping[str, IdentifiedModes],
    *,
    references: Sequence[str] = (),
    frequency: float = 0.03,
    mac: float = 0.8,
) -> IdentifiedModes:
    """Merge the modes of several set-ups of a test whose sensors were moved, by those that stayed.

    Each shape is brought to the common one of the references by a complex factor of its own; covariances pass through
    this to first order. Frequencies and dampings are means weighted by their covariances, with the scatter of the
    set-ups where it is larger.

    Parameters
    ----------
    setups : list of IdentifiedModes, or dict by name
        Of :func:`modal`, one a record.
    references : list of str
        Channels that stay; default: those that all set-ups have.
    frequency : float
        Largest difference of a mode between set-ups, relative.
    mac : float
        Least MAC of its shapes at the references.

    Returns
    -------
    IdentifiedModes
        The references first, then the other channels set-up by set-up; where several set-ups call them alike, behind
        the set-up's name: ``"2:a5"``. Modes that a set-up lacks are left out, which ``remarks`` say.

    Raises
    ------
    InvalidInput
        With fewer than two set-ups, or without a common reference.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> rng = np.random.default_rng(1)
    >>> def record(others):
    ...     z, mu = 0j, 2 * np.pi * 5 * (-0.01 + 1j)
    ...     y = np.array([(z := np.exp(mu / 50) * z + rng.normal()).real for _ in range(20000)])
    ...     return {name: share * y + rng.normal(size=y.size) for name, share in {"a": 1.0, **others}.items()}
    >>> t = np.arange(20000) / 50
    >>> found = [kf.modal(record({name: share}), t=t, progress=False) for name, share in {"b": -0.5, "c": 0.3}.items()]
    >>> whole = kf.merge_setups(found)
    >>> whole.channels, bool(np.allclose(whole[0].shape.real, [1, -0.5, 0.3], atol=0.02))
    (['a', 'b', 'c'], True)
    """
    given = _named(setups)
    merged = core.merge_setups(given, list(references), frequency, mac)
    merged["modes"] = [IdentifiedMode(**each) for each in merged["modes"]]
    return IdentifiedModes(**merged)


def _named(records):
    """What the compiled part takes of several identifications."""
    named = records if isinstance(records, Mapping) else {str(i + 1): each for i, each in enumerate(records)}
    fields = ("frequency", "damping", "covariance", "degrees_of_freedom", "shape", "shape_covariance")
    counts = ("participation", "order", "orders")
    return [
        {
            "name": name,
            "channels": list(found.channels),
            "sample_rate": found.sample_rate,
            "modes": [{key: getattr(mode, key) for key in fields + counts} for mode in found],
        }
        for name, found in named.items()
    ]


@dataclass(frozen=True)
class Told:
    """A number that several records tell: its median and 95 % interval."""

    median: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Trend:
    """How a number follows covariates over records, and scatters beside."""

    mean: Told  #: at the mean of the covariates
    slopes: dict[str, Told]  #: per unit of each covariate
    spread: Told  #: standard deviation of the true values about the mean that follows


@dataclass(frozen=True)
class ModeTrack:
    """One mode through several records."""

    modes: list[IdentifiedMode | None]  #: one a record; None where it was not found
    frequency: Trend | None  #: [Hz]; None where too few records have the mode
    damping: Trend | None  #: ratio to critical


def track_modes(
    records: Sequence[IdentifiedModes],
    covariates: Mapping[str, ArrayLike] | None = None,
    *,
    frequency: float = 0.1,
    mac: float = 0.8,
) -> list[ModeTrack]:
    """Follow the modes of one structure from record to record, and over temperatures and the like.

    Two modes are the same where their shapes agree at the channels that all records have and their frequencies lie
    near. Means, slopes and scatter rest on the deviations of every record: what these explain is not in the scatter.

    Parameters
    ----------
    records : list of IdentifiedModes
        Of :func:`modal`, in the order of time.
    covariates : dict of str to array, optional
        Numbers that frequencies and dampings follow linearly, each one a record.
    frequency : float
        Largest relative change of a frequency from one record to the next.
    mac : float
        Least MAC of the two shapes.

    Returns
    -------
    list of ModeTrack
        By frequency.

    Raises
    ------
    InvalidInput
        With fewer than two records, without a common channel, and with covariates that are not one a record.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> def record(f, seed):
    ...     rng, z, mu = np.random.default_rng(seed), 0j, 2 * np.pi * f * (-0.01 + 1j)
    ...     y = np.array([(z := np.exp(mu / 50) * z + rng.normal()).real for _ in range(10000)])
    ...     return {name: share * y + rng.normal(size=y.size) for name, share in {"a": 1.0, "b": -0.5}.items()}
    >>> T = np.array([0.0, 5.0, 10.0, 15.0, 20.0])
    >>> found = [kf.modal(record(5 - 0.02 * t, int(t)), t=np.arange(10000) / 50, progress=False) for t in T]
    >>> track = kf.track_modes(found, {"temperature": T})[0]
    >>> low, high = track.frequency.slopes["temperature"].interval
    >>> low < -0.02 < high < 0
    True
    """
    names = list(covariates or {})
    values = [np.asarray(covariates[name], float) for name in names]
    table = np.column_stack(values) if values else np.zeros((len(records), 0))

    def told(pair):
        return Told(pair[0], tuple(pair[1]))

    def trend(found):
        if found is None:
            return None
        return Trend(told(found["mean"]), dict(zip(names, map(told, found["slopes"]))), told(found["spread"]))

    return [
        ModeTrack(
            [None if at is None else records[i][at] for i, at in enumerate(track["modes"])],
            trend(track["frequency"]),
            trend(track["damping"]),
        )
        for track in core.track_modes(_named(records), table, frequency, mac)
    ]
