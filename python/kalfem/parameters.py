# SPDX-License-Identifier: Apache-2.0
"""What a run says about parameters, and whether to trust it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .display import parameters_html, rounded, verdict_html
from .errors import unknown_name

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Parameter:
    """An identified parameter, in its SI unit. What is not known is None."""

    name: str
    value: float | None
    std: float | None = None  #: standard deviation
    std_robust: float | None = None  #: the same where innovations are correlated; about `std` if the model is right
    interval: tuple[float, float] | None = None  #: of 95 % probability (lower, upper), from the larger deviation
    unit: str = ""
    truth: float | None = None  #: of simulated records
    initial: float | None = None  #: mean of the prior
    prior_std: float | None = None
    std_considered: float | None = None  #: `std` with what ``known_to`` adds; None where nothing is stated
    details: dict = field(default_factory=dict, repr=False, compare=False)  #: its whole entry in ``summary.json``

    @classmethod
    def from_summary(cls, name: str, entry: dict) -> Parameter:
        """The parameter from its entry in ``summary.json``."""
        interval = entry.get("interval_95")
        if interval is not None:
            interval = None if None in interval else tuple(interval)
        return cls(
            name=name,
            value=entry.get("estimate"),
            std=entry.get("std"),
            std_robust=entry.get("std_robust"),
            interval=interval,
            unit=entry.get("unit", ""),
            truth=entry.get("true"),
            initial=entry.get("initial"),
            prior_std=entry.get("prior_std"),
            std_considered=entry.get("std_considered"),
            details=entry,
        )

    def __str__(self):
        spread = "" if self.std is None else f" +- {rounded(self.std, self.std)}"
        return f"{self.name} = {rounded(self.value, self.std)}{spread} {self.unit}".rstrip()


class Parameters(Mapping[str, Parameter]):
    """Parameters by name: ``run.parameters["suspension.mu_k1"].value``."""

    def __init__(self, parameters: Iterable[Parameter]):
        self._by_name = {each.name: each for each in parameters}

    def __getitem__(self, name: str) -> Parameter:
        try:
            return self._by_name[name]
        except KeyError:
            raise unknown_name("parameter", name, self._by_name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    def __repr__(self):
        return "\n".join(map(str, self.values())) or "no parameters"

    def _ipython_key_completions_(self):
        return list(self._by_name)

    def _repr_html_(self):
        return parameters_html(self)

    def to_pandas(self) -> pandas.DataFrame:
        """A ``pandas.DataFrame``, one row a parameter."""
        from .tables import parameters_to_pandas

        return parameters_to_pandas(self)


@dataclass(frozen=True)
class Reason:
    """Why a run is not consistent."""

    code: str  #: for programs: ``"innovation_large"``
    subject: str  #: the sensor, parameter or step that it is about
    text: str  #: the figure that was found and the one that was expected
    remedy: str  #: what to look at or to change

    def __str__(self):
        return f"{self.subject}: {self.text}; {self.remedy}"


@dataclass(frozen=True)
class Verdict:
    """Whether the numbers of a run agree with each other: ``consistent``, ``suspicious`` or ``unusable``."""

    state: str
    reasons: tuple[Reason, ...] = ()  #: of :class:`Reason`, worst first

    @classmethod
    def from_summary(cls, entry: dict) -> Verdict:
        """The verdict from its entry in ``summary.json``."""
        keys = ("code", "subject", "text", "remedy")
        reasons = tuple(Reason(*(each.get(key) or "" for key in keys)) for each in entry.get("reasons", []))
        return cls(entry.get("state", "unknown"), reasons)

    def __str__(self):
        return "\n".join([self.state, *map(str, self.reasons)])

    def _repr_html_(self):
        return verdict_html(self)
