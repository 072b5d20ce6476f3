# SPDX-License-Identifier: Apache-2.0
"""Sensors that a run predicted from all others: what its virtual sensors are worth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from .errors import unknown_name


@dataclass(frozen=True)
class HeldOutSensor:
    """A sensor that the filter predicted from all others, as a quantity that no sensor measures."""

    unit: str
    samples: int  #: compared
    inside: float  #: share of them within their 95 % band, which holds the sensor's noise
    motion_std: float  #: of the band without that noise, root mean square
    noise_std: float
    followed_errors: float  #: errors that follow the prediction, in the limit above which they contradict the band
    errors_in_band: float  #: errors at the frequencies of the motion, in their limit
    motion_inside: float | None  #: share of its motion that the band holds by these errors; .95 if not contradicted
    holds: bool  #: whether neither figure exceeds its limit


@dataclass(frozen=True)
class AdaptedProcess:
    """Process noise that adapts, tried where a band did not hold."""

    acceleration: float  #: density where it starts, for ``process_noise`` [m/s^2/sqrt(Hz)]
    log_likelihood_gain: float
    mends: bool  #: the bands hold with it, and the record is far likelier
    sensors: dict[str, HeldOutSensor]


class HeldOut(Mapping[str, HeldOutSensor]):
    """Sensors held out, by name: ``run.held_out["a3"].inside``."""

    def __init__(self, summary: dict):
        self._sensors = {name: HeldOutSensor(**each) for name, each in summary.get("sensors", {}).items()}
        trial = summary.get("adapted_process_noise")
        #: The trial of adaptive process noise, or None.
        self.adapted: AdaptedProcess | None = None
        if trial:
            sensors = {name: HeldOutSensor(**each) for name, each in trial["sensors"].items()}
            self.adapted = AdaptedProcess(**{**trial, "sensors": sensors})

    def __getitem__(self, name: str) -> HeldOutSensor:
        if name not in self._sensors:
            raise unknown_name("held-out sensor", name, self._sensors)
        return self._sensors[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sensors)

    def __len__(self) -> int:
        return len(self._sensors)

    def __repr__(self):
        return "\n".join(f"{name}: {each.inside:.1%} of its samples in its band" for name, each in self.items())
