# SPDX-License-Identifier: Apache-2.0
"""Identification and updating of nonlinear finite-element models from vibration measurements.

>>> import kalfem as kf
>>> s = kf.Structure()
>>> _ = s.add(kf.chain("body", 3, mass=1.0, stiffness=3e4))
>>> _ = s.connect("mount", "body.1", "ground", law="linear", parameters=dict(k=1e4, c=20.0))
>>> kf.modes(s).frequencies.round(1)
array([ 8.4, 29.9, 48.2])

`docs/python.md` of the project shows what else there is. Results of a run can be read without the compiled module.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

__version__ = "0.1.0"

_NAMES = {
    "_core": (
        "Structure",
        "Lumped",
        "FiniteElements",
        "Sensor",
        "lumped",
        "chain",
        "read_deck",
        "read_matrices",
        "deck_notes",
        "write_updated_deck",
        "displacement",
        "velocity",
        "acceleration",
        "force",
        "deformation",
        "rate",
        "strain",
        "low_pass",
        "high_pass",
        "delay",
        "without_lag",
        "resonance",
        "gain",
    ),
    "inferring": ("infer", "infer_comparisons", "compare", "ComparedStructure"),
    "mixing": ("mixture", "Mixture"),
    "posterior": ("Posterior",),
    "analysis": ("estimate", "predict", "simulate", "update"),
    "comparing": ("MeasuredModes", "MeasuredResponses", "MeasuredDeflections", "MeasuredRecord"),
    "modal_identification": ("modal", "modal_of_responses", "merge_setups", "track_modes", "IdentifiedMode", "IdentifiedModes", "ModeTrack"),
    "mode_sets": ("read_modes", "ModeSet"),
    "matching": ("match_points", "PointMatch", "MatchedPoint", "PlaceFit"),
    "correlating": ("correlate", "correlate_responses", "Correlation", "CorrelatedMode", "ResponseAgreement", "SetupMistake", "ShapeExpansion"),
    "placing": ("place", "Placement", "SensorSet"),
    "validating": ("validate", "Validation", "SensorValidation"),
    "loading": ("statics", "Statics", "StaticCase"),
    "vibration": ("modes", "frf", "frequency_responses", "mac", "Modes", "FrequencyResponses", "FrequencyResponse"),
    "live": ("Filter", "Estimate"),
    "watching": ("watch", "Watch"),
    "law_library": ("laws",),
    "running": ("run",),
    "finished_runs": ("compare_runs", "RunComparison"),
    "cases": ("read_case", "to_case", "Case"),
    "sweeping": ("sweep", "Sweep"),
    "likelihood": ("Likelihood",),
    "records": ("read", "Record", "MeasuredFile"),
    "ensemble": ("map", "Ensemble", "Failure"),
    "results": ("read_results", "Run"),
    "series": ("TimeSeries",),
    "errors": ("InvalidInput", "Issue", "MissingPackage", "UnknownName"),
    "mesh": ("read_mesh", "mesh_of"),
}
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names}
_MODULES = ("plots",)

__all__ = [*_MODULE_OF, *_MODULES]


def __getattr__(name):
    """Modules are loaded when they are used: the import takes no time, and results need no compiled module."""
    if name in _MODULES:
        return importlib.import_module(f"kalfem.{name}")
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'kalfem' has no attribute '{name}'")
    module = _MODULE_OF[name]
    if module == "_core":
        from .compiled import core as found
    else:
        found = importlib.import_module(f"kalfem.{module}")
    globals()[name] = getattr(found, name)
    return globals()[name]


def __dir__():
    return sorted([*globals(), *__all__])


if TYPE_CHECKING:
    from . import plots as plots
    from ._core import (
        FiniteElements as FiniteElements,
        Lumped as Lumped,
        Sensor as Sensor,
        Structure as Structure,
        acceleration as acceleration,
        chain as chain,
        deck_notes as deck_notes,
        deformation as deformation,
        delay as delay,
        displacement as displacement,
        force as force,
        gain as gain,
        high_pass as high_pass,
        low_pass as low_pass,
        lumped as lumped,
        rate as rate,
        read_deck as read_deck,
        read_matrices as read_matrices,
        resonance as resonance,
        strain as strain,
        velocity as velocity,
        without_lag as without_lag,
        write_updated_deck as write_updated_deck,
    )
    from .analysis import estimate as estimate, predict as predict, simulate as simulate, update as update
    from .cases import Case as Case, read_case as read_case, to_case as to_case
    from .comparing import (
        MeasuredDeflections as MeasuredDeflections,
        MeasuredModes as MeasuredModes,
        MeasuredRecord as MeasuredRecord,
        MeasuredResponses as MeasuredResponses,
    )
    from .ensemble import Ensemble as Ensemble, Failure as Failure, map as map
    from .errors import (
        InvalidInput as InvalidInput,
        Issue as Issue,
        MissingPackage as MissingPackage,
        UnknownName as UnknownName,
    )
    from .finished_runs import RunComparison as RunComparison, compare_runs as compare_runs
    from .inferring import (
        ComparedStructure as ComparedStructure,
        compare as compare,
        infer as infer,
        infer_comparisons as infer_comparisons,
    )
    from .law_library import laws as laws
    from .likelihood import Likelihood as Likelihood
    from .live import Estimate as Estimate, Filter as Filter
    from .watching import Watch as Watch, watch as watch
    from .loading import StaticCase as StaticCase, Statics as Statics, statics as statics
    from .mesh import mesh_of as mesh_of, read_mesh as read_mesh
    from .modal_identification import (
        IdentifiedMode as IdentifiedMode,
        IdentifiedModes as IdentifiedModes,
        ModeTrack as ModeTrack,
        merge_setups as merge_setups,
        modal as modal,
        modal_of_responses as modal_of_responses,
        track_modes as track_modes,
    )
    from .mode_sets import ModeSet as ModeSet, read_modes as read_modes
    from .correlating import (
        CorrelatedMode as CorrelatedMode,
        Correlation as Correlation,
        ResponseAgreement as ResponseAgreement,
        SetupMistake as SetupMistake,
        ShapeExpansion as ShapeExpansion,
        correlate as correlate,
        correlate_responses as correlate_responses,
    )
    from .matching import (
        MatchedPoint as MatchedPoint,
        PlaceFit as PlaceFit,
        PointMatch as PointMatch,
        match_points as match_points,
    )
    from .placing import Placement as Placement, SensorSet as SensorSet, place as place
    from .posterior import Posterior as Posterior
    from .records import MeasuredFile as MeasuredFile, Record as Record, read as read
    from .results import Run as Run, read_results as read_results
    from .running import run as run
    from .series import TimeSeries as TimeSeries
    from .sweeping import Sweep as Sweep, sweep as sweep
    from .validating import SensorValidation as SensorValidation, Validation as Validation, validate as validate
    from .vibration import (
        FrequencyResponse as FrequencyResponse,
        FrequencyResponses as FrequencyResponses,
        Modes as Modes,
        frequency_responses as frequency_responses,
        frf as frf,
        mac as mac,
        modes as modes,
    )
