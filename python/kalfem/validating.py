# SPDX-License-Identifier: Apache-2.0
"""Parameters tried on a record that they were not found from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .compiled import core
from .display import rounded
from .errors import unknown_name
from .parameters import Parameter, Verdict
from .series import TimeSeries

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure


@dataclass(frozen=True)
class SensorValidation:
    """Errors of one sensor, each over the rms of the measured channel about its mean; None without a comparison."""

    nrmse: float | None  #: of the simulation without any correction (open loop)
    noise: float | None  #: the sensor's stated noise: the least error possible
    one_step: float | None  #: of the filter's prediction one sample ahead, with the parameters held
    measured: TimeSeries  #: the channel
    simulated: TimeSeries | None  #: the same in open loop

    def __repr__(self) -> str:
        errors = (("nrmse", self.nrmse), ("noise", self.noise), ("one_step", self.one_step))
        return f"SensorValidation({', '.join(f'{name}={rounded(value)}' for name, value in errors)})"


class Validation(Mapping[str, SensorValidation]):
    """A structure beside a record: ``validation["a3"].nrmse``.

    Attributes
    ----------
    compared_from : float
        Time of the first sample that counts [s]: those before show the initial state.
    failure : str
        Why there is no comparison; empty if there is one.
    verdict : Verdict
        Whether the structure predicts the record: ``consistent``, ``suspicious`` or ``unusable``.
    """

    def __init__(self, summary: dict[str, Any], datasets: Mapping[str, Any]):
        time = datasets["time"][0]
        self.compared_from: float = summary["compared_from"]
        self.failure: str = summary["failure"]
        self.verdict = Verdict.from_summary(summary["verdict"])

        def series(path):
            values, attributes = datasets[path]
            return TimeSeries(values, time, unit=attributes["unit"], name=path)

        self._sensors = {
            name: SensorValidation(
                **errors,
                measured=series(f"{name}/measured"),
                simulated=series(f"{name}/simulated") if f"{name}/simulated" in datasets else None,
            )
            for name, errors in summary["sensors"].items()
        }

    def __getitem__(self, sensor: str) -> SensorValidation:
        if sensor not in self._sensors:
            raise unknown_name("sensor", sensor, self._sensors)
        return self._sensors[sensor]

    def __iter__(self):
        return iter(self._sensors)

    def __len__(self) -> int:
        return len(self._sensors)

    @property
    def usable(self) -> bool:
        """Whether there is a comparison and the structure predicts the record better than no motion would."""
        return self.verdict.state != "unusable"

    def __repr__(self) -> str:
        if self.failure:
            return f"Validation: no comparison, {self.failure}"
        return f"Validation: {self.verdict.state}, " + ", ".join(
            f"{name} {rounded(each.nrmse)}" for name, each in self.items()
        )


def validate(
    structure: Structure,
    t: ArrayLike,
    y: Any,
    *,
    sensors: Mapping[str, Sensor],
    values: Mapping[str, float | str | Parameter] | None = None,
    inputs: Mapping[str, ArrayLike] | None = None,
    lead_in: float | None = None,
    from_rest: bool = False,
    process_noise: float | str = 0.0,
    filter: str = "auto",
    substeps: int | None = None,
    threads: int = 0,
) -> Validation:
    """Simulate a structure along a record that its parameters were not found from, and compare.

    Parameters
    ----------
    structure : Structure
    t : array, shape (n,)
        Even times of the samples [s].
    y : dict or DataFrame of name to array of shape (n,), or array of shape (n, sensors)
        What the sensors recorded [SI]; NaN is a missing sample.
    sensors : dict of str to Sensor
        With their noise.
    values : dict of str to float, str or Parameter
        Of parameters; ``run.parameters`` of an estimation or updating. All others are the structure's own.
    inputs : dict of str to array of shape (n,)
        Samples of the structure's inputs that have none yet.
    lead_in : float, optional
        First part of the record, from which the initial state is estimated [s]; it does not count. A tenth if it is not
        given.
    from_rest : bool
        The structure is at rest at the first sample instead.
    process_noise, filter, substeps, threads
        Of the filter that finds the initial state and predicts one sample ahead, as in :func:`estimate`; 4 substeps if
        none are given.

    Returns
    -------
    Validation
        ``validation["a3"].nrmse`` (open loop), ``.one_step``, ``.noise``, ``.measured``, ``.simulated``;
        ``validation.verdict``.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, by its name, in ``.issues``.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    >>> _ = s.force("hammer", "m.1")
    >>> t = np.arange(500) / 250
    >>> f = 10 * np.sin(2 * np.pi * (1 + 4 * t) * t)
    >>> sensors = {"x": kf.displacement("m.1", noise=1e-5)}
    >>> record = kf.simulate(s, t, sensors=sensors, inputs={"hammer": f}, seed=1, progress=False)
    >>> right = kf.validate(s, t, record, sensors=sensors, inputs={"hammer": f})
    >>> wrong = kf.validate(s, t, record, sensors=sensors, inputs={"hammer": f}, values={"m.k.stiffness": 2200})
    >>> right["x"].nrmse < 1.2 * right["x"].noise, wrong["x"].nrmse > 20 * wrong["x"].noise
    (True, True)
    """
    arguments = {
        "sensors": dict(sensors),
        "unknown": {},
        "outputs": {},
        "filter": filter,
        "initial_state": {},
        "process_noise": process_noise,
        "substeps": substeps,
        "threads": threads,
    }
    given = {name: each.value if isinstance(each, Parameter) else each for name, each in (values or {}).items()}
    return Validation(*core.validate(structure, t, y, dict(inputs or {}), given, lead_in, from_rest, arguments))
