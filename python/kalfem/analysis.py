# SPDX-License-Identifier: Apache-2.0
"""What is done with a structure: simulate, estimate, predict, update."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .comparing import described
from .compiled import core
from .errors import InvalidInput, Issue, unknown_name
from .progress import reporter
from .records import Record
from .results import Run

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure
    from .comparing import MeasuredDeflections, MeasuredModes, MeasuredRecord, MeasuredResponses

    Progress = bool | Callable[[float, str], None]


def estimate(
    structure: Structure,
    t: ArrayLike,
    y: Any,
    *,
    sensors: Mapping[str, Sensor],
    inputs: Mapping[str, ArrayLike] | None = None,
    unknown: Mapping[str, Any] | Iterable[str] | None = None,
    outputs: Mapping[str, Sensor] | None = None,
    filter: str = "auto",
    initial_state: Mapping[str, Mapping[str, Any]] | None = None,
    initial_connector_states: Mapping[str, Mapping[str, float]] | None = None,
    process_noise: float | str = 0.0,
    substeps: int | None = None,
    step_order: int = 4,
    settle: float | None = None,
    initial_state_from_record: bool = False,
    estimate_initial_state: bool = False,
    passes: int = 1,
    threads: int = 0,
    diagnose: bool = True,
    second_thoughts: float | str | None = None,
    known_to: Mapping[str, float | str] | None = None,
    free: str = "ask",
    adaptive_noise: Mapping[str, Any] | None = None,
    progress: Progress = True,
) -> Run:
    """Estimate states and unknown parameters of a structure from a record.

    Parameters
    ----------
    structure : Structure
    t : array, shape (n,)
        Even times of the samples [s].
    y : dict or DataFrame of name to array of shape (n,), or array of shape (n, sensors)
        What the sensors recorded [SI]; NaN is a missing sample. Columns of an array are in the order of `sensors`.
    sensors : dict of str to Sensor
        ``{"a3": kf.acceleration("body.3", noise=0.3)}``.
    inputs : dict of str to array of shape (n,)
        Samples of the structure's inputs that have none yet, in the unit of their kind [m, m/s^2, N].
    unknown : dict of str to prior, or list of str
        ``{"mount.k3": (1e8, "50 %")}``: mean and standard deviation, each a number [SI] or a text with a unit; the
        deviation may be a percentage of the mean. Or the mean alone, with half of it as deviation; None for the
        structure's own value; or a dictionary with ``initial``, ``std``, ``random_walk`` [unit/sqrt(s)], ``bounds``,
        ``transform`` (``log`` or ``none``) and ``applies_to`` (parameters that share the value). Numbers of the
        measurement are unknowns too: ``sensors.a3.offset``, ``sensors.a3.gain``, ``.delay``, ``.drift`` (of its
        clock, ``"50 ppm"``), ``.noise`` and ``process_noise``, each with its mean; all but offsets are found by maximum
        likelihood. Sensors of one rack share a clock by ``applies_to``.
    outputs : dict of str to Sensor
        Quantities to estimate without a sensor for them.
    filter : str
        ``auto``, ``ukf``, ``ukf_square_root``, ``partially_linear_ukf``, ``partially_linear_ukf_square_root``, ``ekf``.
    initial_state : dict of str to dict
        By degree of freedom, or ``all``: ``displacement``, ``velocity``, ``displacement_std``, ``velocity_std``
        [m, m/s]. Rest, known exactly, if it is not given.
    initial_connector_states : dict of str to dict
        Internal states of laws at the start, ``{"mount.z": {"value": 0.0, "std": 1e-3}}``.
    process_noise : float or str
        White acceleration on every degree of freedom [m/s^2/sqrt(Hz)].
    substeps : int, optional
        Of a sample interval, for the connectors' forces. If it is not given, as many as the estimates need are found: by
        the first run where two are enough, otherwise by further ones.
    step_order : int
        4 or 2: of the filter's step over a substep. With 4 the connectors' forces are quadratic over it; with 2 they are
        linear, at half the cost.
    settle : float, optional
        Time from which on innovations count in the verdict [s]. If it is not given: at once where the motion at the
        start is known, otherwise by the decay of the slowest mode, at the latest after a tenth of the record.
    initial_state_from_record : bool
        Take displacements and velocities at the start from the displacement sensors.
    estimate_initial_state : bool
        Keep the initial state in the filter's state; ``passes`` runs over the record then improve it.
    threads : int
        0: one a processor. Results do not depend on it.
    diagnose : bool
        Look for the mistake that explains numbers that contradict each other.
    second_thoughts : float or str, optional
        What may follow the first answer (more substeps, changes of parameters within the record, other process noise,
        the mistake behind a contradiction): so many times its filter steps, ``none``, or ``full``. If it is not
        given, all, or none without `diagnose`.
    known_to : dict of str to float or str
        Standard deviations of numbers that are held fixed; intervals and bands then hold what follows from them. A
        percentage, or a number in its unit: ``{"masses": "1 %", "body.3.mass": "0.5 %", "a1.delay": 2e-4}``. By group
        (``masses``, ``stiffnesses``, ``damping``, ``laws``, ``gains``, ``excitations``, ``delays``, ``drifts``), by
        owner or by name; the longest name counts. Without it they are taken as exact; ``run.sensitivity`` says what that matters.
    free : str
        Fixed numbers that the record asks to change: ``none`` says nothing of estimating them, ``ask`` tries them as
        unknowns and says in ``run.freed`` which predict the last third of the record better, ``auto`` takes these as
        unknowns: they are among ``run.parameters``.
    adaptive_noise : dict, optional
        Noise that the filter finds along the record: ``process`` (a factor on `process_noise`), ``sensors``, each True
        or False, and ``memory`` [s]. ``run.held_out.adapted`` says whether the first would mend bands that are too narrow.
    progress : bool or callable
        Show a bar, or call a function with the fraction done and words.

    Returns
    -------
    Run
        ``run.parameters["mount.k3"]``, ``run["estimate/body.3/displacement"]``, ``run.verdict``, ``run.residuals``.
        Standard deviations of motions are computed 100 times a second, as by the command, and stand in between.

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
    >>> sensors = {"a": kf.acceleration("m.1", noise=0.05)}
    >>> record = kf.simulate(s, t, sensors=sensors, inputs={"hammer": f}, seed=1)
    >>> run = kf.estimate(s, t, record, sensors=sensors, inputs={"hammer": f}, unknown={"m.k.stiffness": (2500, "30 %")},
    ...                   progress=False)
    >>> k = run.parameters["m.k.stiffness"]
    >>> abs(k.value - 2000) < 4 * k.std
    True
    """
    arguments = _arguments(
        sensors,
        unknown,
        outputs,
        filter=filter,
        initial_state=initial_state,
        initial_connector_states=initial_connector_states,
        process_noise=process_noise,
        substeps=substeps,
        step_order=step_order,
        threads=threads,
        initial_state_from_record=initial_state_from_record,
        estimate_initial_state=estimate_initial_state,
        passes=passes,
        settle=settle,
        diagnose=diagnose,
        second_thoughts=second_thoughts,
        known_to=known_to,
        free=free,
        adaptive_noise=adaptive_noise,
    )
    with reporter(progress) as bar:
        summary, datasets = core.estimate(structure, t, y, dict(inputs or {}), arguments, bar)
    return Run.from_memory(summary, datasets)


def _arguments(sensors, unknown, outputs, **settings):
    """Those of an estimation, as the compiled module takes them."""
    by_name = ("initial_state", "initial_connector_states", "known_to")
    return {
        "sensors": dict(sensors),
        "unknown": {} if unknown is None else dict(unknown) if isinstance(unknown, Mapping) else list(unknown),
        "outputs": dict(outputs or {}),
        **{name: dict(each or {}) if name in by_name else each for name, each in settings.items()},
    }


def _estimate_arguments(given):
    """The same of arguments of :func:`estimate` in a dictionary."""
    if "sensors" not in given:
        raise InvalidInput(Issue("estimate: 'sensors' is missing", "an estimation is one from sensors"))
    return _arguments(**_with_defaults(estimate, given))


def _update_arguments(given):
    """Arguments of :func:`update` in a dictionary, as the compiled module takes them."""
    all_of_them = _with_defaults(update, given)
    parameters, modes, std = (all_of_them[name] for name in ("parameters", "modes", "std"))
    all_of_them["parameters"] = dict(parameters) if isinstance(parameters, Mapping) else list(parameters)
    all_of_them["modes"] = None if modes is None else list(modes)
    all_of_them["std"] = float(std) if np.ndim(std) == 0 else std
    all_of_them["known_to"] = dict(all_of_them["known_to"] or {})
    all_of_them["compare"] = described(all_of_them["compare"] or {})
    return all_of_them


def _with_defaults(function, given):
    """What is said of the analysis, the rest at the defaults of the function."""
    of_the_data = ("structure", "t", "y", "inputs", "progress")
    known = {name: each.default for name, each in inspect.signature(function).parameters.items() if name not in of_the_data}
    for name in given:
        if name not in known:
            raise InvalidInput(Issue(f"{function.__name__}: {unknown_name('argument', name, list(known))}"))
    return {**known, **given}


def predict(
    structure: Structure,
    t: ArrayLike,
    y: Any,
    substructure: str,
    *,
    sensors: Mapping[str, Sensor],
    inputs: Mapping[str, ArrayLike] | None = None,
    unknown: Mapping[str, Any] | Iterable[str] | None = None,
    outputs: Mapping[str, Sensor] | None = None,
    filter: str = "auto",
    initial_state: Mapping[str, Mapping[str, Any]] | None = None,
    process_noise: float | str = 0.0,
    substeps: int | None = None,
    threads: int = 0,
    diagnose: bool = True,
    steps: int = 2,
    progress: Progress = True,
) -> Run:
    """Estimate, then drive one linear substructure by the estimated motion of its boundary.

    The boundary is what its reduction keeps, or what connectors touch. The inner motion follows the substructure's own
    equations at the estimates: no process noise disturbs it.

    Parameters
    ----------
    structure, t, y, sensors, inputs, unknown, outputs, filter, initial_state, process_noise, substeps, threads, diagnose
        As in :func:`estimate`.
    substructure : str
        To drive.
    steps : int
        Of a large substructure, steps per sample.

    Returns
    -------
    Run
        That of :func:`estimate`, and ``run["prediction/body.3/displacement"]``, ``acceleration`` of every point of the
        substructure, ``strain`` of its gauges.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, and where the substructure cannot be driven.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.chain("c", 3, mass=1.0, stiffness=1e4, damping=2.0))
    >>> _ = s.connect("mount", "c.1", "ground", law="linear", parameters=dict(k=1e4, c=2.0))
    >>> _ = s.force("hammer", "c.1")
    >>> t = np.arange(400) / 200
    >>> f = 10 * np.sin(2 * np.pi * (1 + 5 * t) * t)
    >>> sensors = {"a1": kf.acceleration("c.1", noise=0.02)}
    >>> record = kf.simulate(s, t, sensors={**sensors, "a3": kf.acceleration("c.3")}, inputs={"hammer": f}, seed=1,
    ...                      progress=False)
    >>> run = kf.predict(s, t, record, "c", sensors=sensors, inputs={"hammer": f}, progress=False)
    >>> error = run["prediction/c.3/acceleration"] - record["a3"]
    >>> bool(np.linalg.norm(error) < 0.05 * np.linalg.norm(record["a3"]))
    True
    """
    arguments = _arguments(
        sensors,
        unknown,
        outputs,
        filter=filter,
        initial_state=initial_state,
        process_noise=process_noise,
        substeps=substeps,
        threads=threads,
        diagnose=diagnose,
    )
    with reporter(progress) as bar:
        summary, datasets = core.predict(structure, t, y, substructure, steps, dict(inputs or {}), arguments, bar)
    return Run.from_memory(summary, datasets)


def simulate(
    structure: Structure,
    t: ArrayLike | None = None,
    *,
    sensors: Mapping[str, Sensor],
    inputs: Mapping[str, ArrayLike] | None = None,
    duration: float | None = None,
    sample_rate: float | None = None,
    seed: int | None = None,
    tolerance: float = 1e-3,
    progress: Progress = True,
) -> Record:
    """Simulate a structure that starts at rest under its inputs.

    Parameters
    ----------
    structure : Structure
    t : array, shape (n,), optional
        Even times from 0 on [s]; or give `duration` [s] and `sample_rate` [Hz].
    sensors : dict of str to Sensor
    inputs : dict of str to array of shape (n,)
        Samples of the structure's inputs that have none yet, at the times of the record.
    seed : int, optional
        Of the sensors' noise. If it is not given, the record is free of noise.
    tolerance : float
        Relative change of every sensor's record when the step is halved.

    Returns
    -------
    Record
        ``record["a3"]`` is a TimeSeries. ``record.failure`` says when and why the simulation stopped, if it did.
    """
    duration, sample_rate = _extent(t, duration, sample_rate)
    with reporter(progress) as bar:
        datasets, failure = core.simulate(
            structure, duration, sample_rate, dict(sensors), dict(inputs or {}), seed, tolerance, bar
        )
    return Record.from_datasets(datasets, failure)


def _extent(t, duration, sample_rate):
    if t is None:
        if duration is None or sample_rate is None:
            raise InvalidInput(Issue("t is not given", "the record needs its times", "give t, or duration and sample_rate"))
        return float(duration), float(sample_rate)
    if duration is not None or sample_rate is not None:
        raise InvalidInput(Issue("t and duration or sample_rate are given", "t says both", "give one or the other"))
    start, sample_rate, samples = core.time_grid(t)
    if start != 0.0:
        raise InvalidInput(Issue(f"t begins at {start:g} s", "a simulation begins at 0", "subtract t[0]"))
    return (samples - 1) / sample_rate, sample_rate


def update(
    structure: Structure,
    substructure: str = "",
    frequencies: ArrayLike = (),
    std: float | ArrayLike = 0.0,
    parameters: Mapping[str, Any] | Sequence[str] = (),
    *,
    compare: Mapping[str, MeasuredModes | MeasuredResponses | MeasuredDeflections | MeasuredRecord] | None = None,
    modes: Sequence[int | None] | None = None,
    above: float = 0.0,
    max_evaluations: int = 100,
    tolerance: float = 1e-6,
    known_to: Mapping[str, float | str] | None = None,
    progress: Progress = True,
) -> Run:
    """Refine parameters of linear substructures by what was measured.

    Parameters
    ----------
    structure : Structure
    substructure : str
        Whose natural frequencies were measured.
    frequencies : array, shape (n,)
        [Hz]. If none are given, `compare` has the measurements.
    std : float or array of shape (n,)
        Their standard deviations [Hz].
    parameters : dict of str to range, or list of str
        ``{"frame.steel.youngs_modulus": (200e9, 20e9)}``: start and standard deviation of the prior [SI]; or the start
        alone; or a dictionary with ``initial``, ``std``, ``lower`` and ``upper``; or None for the structure's own value.
    compare : dict of str to MeasuredModes, MeasuredResponses, MeasuredDeflections or MeasuredRecord
        Further measurements by names of your choice.
    modes : list of int or None, optional
        Number of the model's mode for each frequency, from 1; by order if it is not given.
    above : float
        Modes up to this frequency are not elastic ones [Hz].
    max_evaluations : int
        Of the model.
    tolerance : float
        The search ends once a step changes every parameter by less than this, relative.
    known_to : dict of str to float or str
        Standard deviations of numbers that are not refined; intervals then hold what follows from them. As in
        :func:`estimate`; gains are those of what is compared: ``tip.z.gain`` of a response, ``input.tip.z.gain`` of its
        force, ``a1.gain`` of a record's sensor, ``road.gain`` of an excitation.

    Returns
    -------
    Run
        ``run.parameters``, ``run.verdict``, ``run["updating/frequencies/after"]`` beside ``measured`` and ``before``;
        ``run.summary["updating"]["comparisons"]`` has the size and the rms of each before and after, in standard
        deviations.

    Examples
    --------
    >>> import kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3))
    >>> run = kf.update(s, "m", [6.0], 0.01, ["m.k.stiffness"])
    >>> round(run.parameters["m.k.stiffness"].value, 1)
    2842.4
    >>> tested = kf.MeasuredDeflections({"m.1": 10.0}, {"m.1": "4 mm"}, std="0.01 mm")
    >>> round(kf.update(s, parameters=["m.k.stiffness"], compare={"pull": tested}).parameters["m.k.stiffness"].value, 1)
    2500.0
    """
    arguments = _update_arguments(
        dict(
            substructure=substructure,
            frequencies=frequencies,
            std=std,
            parameters=parameters,
            compare=compare,
            modes=modes,
            above=above,
            max_evaluations=max_evaluations,
            tolerance=tolerance,
            known_to=known_to,
        )
    )
    with reporter(progress) as bar:
        summary, datasets = core.update(structure, arguments, bar)
    return Run.from_memory(summary, datasets)
