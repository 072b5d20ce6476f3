# SPDX-License-Identifier: Apache-2.0
"""Numbers that an estimation holds fixed: what the estimates owe to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from .errors import unknown_name


@dataclass(frozen=True)
class FixedNumber:
    """A number of the structure, of a sensor or of an excitation that was held fixed, in its SI unit."""

    name: str  #: ``frame.3.mass``, ``a1.gain``, ``road.delay``
    group: str  #: ``masses``, ``stiffnesses``, ``damping``, ``laws``, ``gains``, ``excitations`` or ``delays``
    value: float
    unit: str
    known_to: float | None  #: stated standard deviation; None: taken as exact
    stands_at_change: float  #: at which the estimates stand; 0 unless a stated number was moved
    asked_change: float | None  #: that makes the record most likely, the parameters estimated along with it
    asked_change_std: float | None  #: None where the record does not tell
    log_likelihood_gain: float | None  #: by that change
    shift: dict[str, float]  #: d(estimate)/d(number) of every parameter

    def __str__(self):
        unit = "" if self.unit == "-" else f" {self.unit}"
        asked = "" if self.asked_change is None else f", the record asks for {self.asked_change:+.3g}{unit}"
        spread = "" if self.asked_change_std is None else f" +- {self.asked_change_std:.2g}"
        return f"{self.name} = {self.value:.6g}{unit}{asked}{spread}"


@dataclass(frozen=True)
class NumberTrial:
    """A number that was held fixed, tried as an unknown."""

    name: str  #: of the unknown, ``frame.3.mass`` or ``sensors.a3.gain``
    unit: str
    held: float  #: the value at which it was held fixed
    prior_std: float  #: of the unknown
    value: float | None  #: found
    std: float | None
    predicted_gain: float | None  #: rise of the log-likelihood of the last third of the record, from what is before
    kept: bool  #: it predicts that third better by far


@dataclass(frozen=True)
class Move:
    """An estimate before and after numbers were freed."""

    parameter: str
    unit: str
    before: float
    after: float
    deviations: float  #: of the move, in those of the interval before


@dataclass(frozen=True)
class Freed:
    """What became of fixed numbers that the record asks to change."""

    how: str  #: ``none``, ``ask`` or ``auto``
    tried: list[NumberTrial]
    moved: list[Move]  #: by those kept

    @classmethod
    def from_summary(cls, summary: dict) -> Freed:
        """Of the object ``freed`` of summary.json."""
        tried = [NumberTrial(**entry) for entry in summary.get("tried", [])]
        return cls(summary.get("how", "none"), tried, [Move(**entry) for entry in summary.get("moved", [])])


class FixedNumbers(Mapping[str, FixedNumber]):
    """Fixed numbers by name: ``run.sensitivity["frame.3.mass"].shift["mount.k"]``."""

    def __init__(self, summary: dict):
        keys = [each for each in FixedNumber.__dataclass_fields__]
        self._by_name = {each["name"]: FixedNumber(*(each.get(key) for key in keys)) for each in summary["numbers"]}

    def __getitem__(self, name: str) -> FixedNumber:
        try:
            return self._by_name[name]
        except KeyError:
            raise unknown_name("fixed number", name, self._by_name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    def __repr__(self):
        return "\n".join(map(str, self.values())) or "no fixed numbers"
