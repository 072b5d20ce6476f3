# SPDX-License-Identifier: Apache-2.0
"""The library of connector laws."""

from __future__ import annotations

from typing import NamedTuple

from .compiled import core


class LawDescription(NamedTuple):
    """A law of the library."""

    name: str
    equation: str
    meaning: str
    parameters: dict  #: name -> (unit, meaning)


def laws() -> dict[str, LawDescription]:
    """Every law of the library by its name, for ``Structure.connect(..., law=name)``.

    >>> import kalfem as kf
    >>> sorted(kf.laws()["linear"].parameters)
    ['c', 'k']
    """
    return {each[0]: LawDescription(*each) for each in core.laws()}
