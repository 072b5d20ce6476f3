# SPDX-License-Identifier: Apache-2.0
"""A filter that is moved by its caller, as a live system needs it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from .compiled import core
from .parameters import Parameter, Parameters, Verdict

if TYPE_CHECKING:
    from ._core import Sensor, Structure


class Estimate(NamedTuple):
    """Mean and standard deviation of a quantity now."""

    value: float
    std: float


class Smoothed(NamedTuple):
    """The estimate of an earlier sample from all samples so far; `time` counts from the first one [s]."""

    time: float
    parameters: Parameters
    states: dict[str, Estimate]


class Consistency(NamedTuple):
    """Normalised innovations squared (NIS) of a window of samples."""

    mean_nis: float
    expected_nis: float
    fraction_in_95: float


class Event(NamedTuple):
    """Something that a filter with gates has noticed, and what it did."""

    time: float
    kind: str
    channel: str
    text: str


class Change(NamedTuple):
    """How far a parameter is from its level in the reference windows: relative, with std and the 95 % interval."""

    parameter: str
    change: float
    std: float
    interval_95: tuple[float, float]
    since: float
    since_within: tuple[float, float]


class Alarm(NamedTuple):
    """A change that was found (`raised`, `changed`), or has gone (`ended`)."""

    number: int
    kind: str
    time: float
    what: Change
    text: str


class DailyMean(NamedTuple):
    """A parameter over one day; `corrected` is what it would be had the covariates stayed as they were at first."""

    day: float
    parameter: str
    unit: str
    mean: float
    std: float
    corrected: float
    corrected_std: float
    windows: int


class Filter(core.Filter):
    """A filter over samples as they come.

    Parameters
    ----------
    structure : Structure
        Its inputs either all have samples, or are told to `predict` or `push`.
    sample_rate : float
        [Hz].
    sensors, unknown, outputs, filter, initial_state, process_noise, substeps, step_order, threads
        As :func:`kalfem.estimate` has them; `substeps` is 4 if it is not given.
    start : float
        Time of the first sample of `push` [s].
    horizon : float
        By so much later than another channel a channel of `push` may come [s].
    input_delay : int
        Samples by which the filter stays behind inputs that come as values: their spline needs later ones, as the
        motion of a ground acts through its velocity. 0: no delay, and straight lines between the samples, which biases
        the estimates.
    window : int
        Latest samples by which `usable` and `verdict` judge.
    lag : int
        Samples N by which the estimates of `smoothed` stay behind the filter. They cost N backward steps each time they
        are asked for, and 8 N n^2 bytes for n states. 0: none.
    gates : bool or dict
        Leave sensors out that lie, and take them again: see `events` and `condition`. A dictionary gives other numbers
        than the usual ones: ``limit``, ``warm_up``, ``memory``, ``suspend_after``, ``stuck``, ``patience``,
        ``inflation``, ``silence``, ``most_events``.
    changes : bool or dict
        Watch the unknowns for changes: see `alarms`, `changes` and `trend`. A dictionary gives other numbers than the
        usual ones: ``window`` [s], ``reference``, ``memory``, ``level``, ``hysteresis``, ``persistence``,
        ``false_alarms_every`` [s], and ``covariates``, ``{"temperature": 0.01}``: the prior standard deviation of a
        relative change per unit. Their values come by ``push("temperature", t, values)`` or `covariate`.

    Notes
    -----
    Either step by step, ``update(y)`` for the first sample, then ``predict(u)`` and ``update(y)`` for each further one;
    or by blocks, ``push(name, t, values)``. Sensors and inputs of one instant have the same time. The estimates after a
    block are those `input_delay` samples before the last one that every channel has: `samples` counts these, and `time`
    says where the filter stands. `flush` takes what waits.

    Examples
    --------
    >>> import kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    >>> _ = s.force("hammer", "m.1")
    >>> live = kf.Filter(s, 250.0, sensors={"a": kf.acceleration("m.1", noise=0.05)}, unknown={"m.k.stiffness": 2500.0})
    >>> live.update([0.01]), live.predict([1.0]), live.update({"a": 0.45})
    (True, True, True)
    >>> live.parameters["m.k.stiffness"].unit
    'N/m'
    """

    def __init__(
        self,
        structure: Structure,
        sample_rate: float,
        *,
        sensors: Mapping[str, Sensor],
        unknown: Mapping[str, Any] | Iterable[str] | None = None,
        outputs: Mapping[str, Sensor] | None = None,
        filter: str = "auto",
        initial_state: Mapping[str, Mapping[str, Any]] | None = None,
        process_noise: float | str = 0.0,
        substeps: int | None = None,
        step_order: int = 4,
        threads: int = 0,
        start: float = 0.0,
        horizon: float = 10.0,
        input_delay: int = 8,
        window: int = 2000,
        lag: int = 0,
        gates: bool | Mapping[str, float] = False,
        changes: bool | Mapping[str, Any] = False,
    ):
        arguments = {
            "sensors": dict(sensors),
            "unknown": {} if unknown is None else dict(unknown) if isinstance(unknown, Mapping) else list(unknown),
            "outputs": dict(outputs or {}),
            "filter": filter,
            "initial_state": dict(initial_state or {}),
            "process_noise": process_noise,
            "substeps": substeps,
            "step_order": step_order,
            "threads": threads,
        }
        chosen = dict(gates) if isinstance(gates, Mapping) else {} if gates else None
        watched = dict(changes) if isinstance(changes, Mapping) else {} if changes else None
        covariates = dict(watched.pop("covariates", {})) if watched else {}
        super().__init__(
            structure, sample_rate, arguments, start, horizon, input_delay, window, lag, chosen, watched, covariates
        )

    def state(self, name: str) -> Estimate:
        """Mean and standard deviation now of ``body.2.displacement``, ``body.2.velocity``, or an output."""
        return Estimate(*super().state(name))

    @property
    def smoothed(self) -> Smoothed | None:
        """The estimate of sample k - `lag` from all samples up to k, where the filter stands; None without a lag.

        With the filter's estimate x, P of that sample, x_s = x + P lambda and P_s = P - P Lambda P, where lambda and
        Lambda follow from the later samples (fixed-interval smoother in the form of Bryson and Frazier, 1963). `states`
        has the names of `state`. Until `lag` samples have come, and until so many have passed after the filter
        has widened its deviations or begun anew, it is the estimate of the first one.
        """
        found = self._smoothed()
        if found is None:
            return None
        time, parameters, states = found
        return Smoothed(
            time,
            Parameters(Parameter.from_summary(*item) for item in parameters.items()),
            {name: Estimate(*each) for name, each in states.items()},
        )

    @property
    def verdict(self) -> Verdict:
        """Whether the innovations of the window are as large as expected and white, by :func:`kalfem.estimate`'s rules."""
        return Verdict.from_summary(self._verdict())

    @property
    def events(self) -> list[Event]:
        """What the gates have noticed, the oldest first: spikes, sensors that are left out and taken again."""
        return [Event(*each) for each in self._events()]

    @property
    def alarms(self) -> list[Alarm]:
        """The alarms on changes of unknowns, the latest 1000, the oldest first."""
        return [Alarm(number, kind, t, Change(*what), text) for number, kind, t, what, text in self._alarms()]

    @property
    def changes(self) -> list[Change]:
        """The changes whose alarm has been raised and has not ended, with what is known of them now."""
        return [Change(*each) for each in self._changes()]

    @property
    def trend(self) -> list[DailyMean]:
        """The unknowns by day, the present one last."""
        return [DailyMean(*each) for each in self._trend()]

    @property
    def consistency(self) -> Consistency:
        """Mean NIS of the window beside the expected one, and the part of its samples in the 95 % band."""
        return Consistency(*self._consistency())

    @property
    def parameters(self) -> Parameters:
        """The unknowns now, by name."""
        return Parameters(Parameter.from_summary(*item) for item in self._parameters().items())
