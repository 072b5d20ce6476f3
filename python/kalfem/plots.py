# SPDX-License-Identifier: Apache-2.0
"""Plots with Matplotlib. Each function returns its figure; `ax` draws into axes of your own where there is one."""

import math

import numpy as np

from .display import rounded
from .errors import InvalidInput, Issue, optional, unknown_name

_ESTIMATE, _TRUTH, _LIMIT = "#1f77b4", "#222222", "#c62828"
_PREFIXED = ("m", "m/s", "N", "N/m", "N s/m", "Pa", "Hz", "rad")  # their axes may carry "5 kN/m"


def _axes(count, ax=None, height=2.2, width=8.0, columns=1, sharex=False):
    """Axes below each other in a new figure, or the one that is given."""
    if ax is not None:
        if count != 1:
            fix = "name one of them, or leave ax out"
            raise InvalidInput(Issue(f"{count} quantities do not fit into one pair of axes", fix=fix))
        return ax.figure, [ax]
    rows = math.ceil(count / columns)
    pyplot = optional("matplotlib.pyplot", "plotting")
    figure, axes = pyplot.subplots(
        rows, columns, figsize=(width, max(height * rows, 3.0)), squeeze=False, sharex=sharex, layout="constrained"
    )
    axes = list(axes.flat)
    for unused in axes[count:]:
        unused.remove()
    return figure, axes[:count]


def _label(ax, text, unit):
    """Name and unit on the vertical axis; lengths and forces with prefixes."""
    _scale(ax.yaxis, unit)
    ax.set_ylabel(text if unit in _PREFIXED else f"{text} [{unit}]" if unit and unit != "-" else text)


def _scale(axis, unit):
    if unit in _PREFIXED:
        axis.set_major_formatter(optional("matplotlib.ticker", "plotting").EngFormatter(unit=unit))


def _draw(ax, values, band=True, label=None, **style):
    """A line over time, or over samples, with two standard deviations about it."""
    t = np.arange(len(values)) if values.t is None else values.t
    style = {"color": _ESTIMATE, "lw": 1.2, **style}
    if band and values.std is not None:
        ax.fill_between(t, values - 2 * values.std, values + 2 * values.std, color=style["color"], alpha=0.25, lw=0)
    ax.plot(t, np.asarray(values), label=label, **style)
    ax.set_xlabel("sample" if values.t is None else "time [s]")
    ax.margins(x=0)


def _legend(ax):
    """Above the axes, where it hides nothing."""
    ax.legend(
        loc="lower right", bbox_to_anchor=(1, 1), ncol=4, frameon=False, borderaxespad=0.2, fontsize="small",
        handlelength=1.4, columnspacing=1.0
    )


def series(values, ax=None, **style):
    """One time series with its band of two standard deviations."""
    figure, (ax,) = _axes(1, ax)
    _draw(ax, values, **style)
    _label(ax, values.name.rpartition("/")[2], values.unit)
    ax.set_title(values.name, loc="left", fontsize="medium")
    return figure


def _members(run, group, ending=""):
    """Names between a group and an ending: "body.3" of "estimate/body.3/displacement"."""
    paths = [path for path in run.keys() if path.startswith(group) and path.endswith(ending)]
    names = [path[len(group) : len(path) - len(ending)] for path in paths]
    return [name for name in names if not name.endswith("_std")]


def _chosen(what, names, known, most):
    """The names that are asked for, or the first ones."""
    if not known:
        raise InvalidInput(Issue(f"the run has no {what}", "its case does not ask for them"))
    names = [names] if isinstance(names, str) else known[:most] if names is None else list(names)
    for name in names:
        if name not in known:
            raise unknown_name(what, name, known)
    return names


def parameters(run, names=None, ax=None):
    """Unknown parameters over time, with bands of two standard deviations and the truth where it is known."""
    names = _chosen("parameter over time", names, _members(run, "estimate/parameters/"), 12)
    figure, axes = _axes(len(names), ax, sharex=True)
    for ax, name in zip(axes, names):
        course = run[f"estimate/parameters/{name}"]
        _draw(ax, course, label="\u00b1 2 std")
        found = run.parameters[name] if name in run.parameters else None
        if found and found.truth is not None:
            ax.axhline(found.truth, color=_TRUTH, ls="--", lw=1.0, label="truth")
        ax.set_title(str(found or name), loc="left", fontsize="medium")
        _label(ax, "", course.unit)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    _legend(axes[0])
    return figure


def _readable_span(values, t, oscillations=25):
    """The last piece of a series that shows so many oscillations."""
    rising = np.flatnonzero(np.diff(np.signbit(values - np.nanmean(values)).astype(int)) < 0)
    return (t[0], t[-1]) if len(rising) <= oscillations else (t[rising[-oscillations]], t[-1])


def states(run, points=None, quantity="displacement", span=None, group="estimate", ax=None):
    """Estimated motion of points with its band, and the truth of a simulated record.

    Parameters
    ----------
    points : str or list of str, optional
        ``"body.3"``; by default the first four.
    quantity : str
        ``displacement``, ``velocity``, ``acceleration``; of connectors ``deformation``, ``rate``, ``force``.
    span : (float, float), optional
        Times to show [s]; by default the last oscillations.
    group : str
        ``estimate``, ``smoothed`` or ``prediction``.
    """
    points = _chosen(f"{group} with {quantity}", points, _members(run, f"{group}/", f"/{quantity}"), 4)
    figure, axes = _axes(len(points), ax, sharex=True)
    for ax, point in zip(axes, points):
        motion = run[f"{group}/{point}/{quantity}"]
        _draw(ax, motion, label="\u00b1 2 std" if motion.std is not None else group)
        if f"truth/{point}/{quantity}" in run:
            _draw(ax, run[f"truth/{point}/{quantity}"], color=_TRUTH, ls="--", lw=0.9, label="truth")
        first, last = span or _readable_span(motion, motion.t)
        shown = motion[(motion.t >= first) & (motion.t <= last)]
        ax.set_xlim(first, last)
        ax.set_ylim(*_limits(shown))
        ax.set_title(point, loc="left", fontsize="medium")
        _label(ax, quantity, motion.unit)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    _legend(axes[0])
    return figure


def _limits(values):
    """Of an axis that shows the values with their band."""
    spread = 0.0 if values.std is None else 2 * values.std
    low, high = np.nanmin(values - spread), np.nanmax(values + spread)
    margin = 0.1 * (high - low) or 1.0
    return low - margin, high + margin


def innovations(run, sensors=None, ax=None):
    """Innovations with two standard deviations that the filter expects; 95 % of a consistent filter's lie between."""
    residuals = run.residuals
    sensors = _chosen("innovations", sensors, residuals.sensors, 8)
    figure, axes = _axes(len(sensors), ax, sharex=True)
    for ax, sensor in zip(axes, sensors):
        found = residuals[sensor]
        ax.plot(found.t, np.asarray(found), ".", ms=1.5, color=_ESTIMATE, alpha=0.6, rasterized=True)
        for sign in (-2, 2):
            ax.plot(found.t, sign * found.std, color=_LIMIT, lw=1.0, label="\u00b1 2 std" if sign > 0 else None)
        used = np.isfinite(found)
        inside = np.mean(np.abs(found[used]) <= 2 * found.std[used]) if used.any() else math.nan
        ax.set_title(f"{sensor}: {100 * inside:.1f} % inside (expected 95.4 %)", loc="left", fontsize="medium")
        _label(ax, "innovation", found.unit)
        ax.set_xlabel("time [s]")
        ax.margins(x=0)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    _legend(axes[0])
    return figure


def law(run, connectors=None, span=None, ax=None):
    """Force of connectors against their deformation: estimated, and true where it is known.

    `span`: times to show [s]; by default the last oscillations.
    """
    known = [name for name in _members(run, "estimate/", "/force") if f"estimate/{name}/deformation" in run]
    connectors = _chosen("connector", connectors, known, 6)
    columns = min(2, len(connectors))
    figure, axes = _axes(len(connectors), ax, height=4.0, width=2.0 + 4.0 * columns, columns=columns)
    for ax, connector in zip(axes, connectors):
        estimated = run[f"estimate/{connector}/deformation"]
        first, last = span or _readable_span(estimated, estimated.t)
        for group, style in (("estimate", {"color": _ESTIMATE, "lw": 1.5}), ("truth", {"color": _TRUTH, "lw": 0.6})):
            if f"{group}/{connector}/force" not in run:
                continue
            deformation, force = run[f"{group}/{connector}/deformation"], run[f"{group}/{connector}/force"]
            shown = (force.t >= first) & (force.t <= last)
            ax.plot(np.asarray(deformation[shown]), np.asarray(force[shown]), label=group, **style)
        _scale(ax.xaxis, "m")
        ax.locator_params(axis="x", nbins=5)
        ax.set_xlabel("deformation")
        _label(ax, "force", "N")
        ax.set_title(connector, loc="left", fontsize="medium")
        _legend(ax)
    return figure


def modes(found, count=6, ax=None):
    """Mode shapes over the degrees of freedom.

    Parameters
    ----------
    found : object
        With ``frequencies`` [Hz], ``shapes`` (dofs x modes) and ``dofs``, the names of the rows: what ``kf.modes``
        returns.
    """
    count = min(count, len(found.frequencies))
    figure, axes = _axes(count, ax, height=1.4, sharex=True)
    place = np.arange(len(found.dofs))
    for ax, frequency, shape in zip(axes, found.frequencies, np.asarray(found.shapes).T):
        shape = shape / np.max(np.abs(shape))
        ax.axhline(0, color="#999999", lw=0.8)
        ax.plot(place, shape, "o-" if len(place) <= 60 else "-", color=_ESTIMATE, ms=4, lw=1.2)
        ax.set_ylim(-1.2, 1.2)
        ax.set_ylabel(f"{rounded(float(frequency))} Hz")
    last = axes[-1]
    if len(place) <= 30:
        last.set_xticks(place, found.dofs, rotation=45, ha="right")
    else:
        last.set_xlabel("degree of freedom")
    return figure


def overview(run):
    """The first of each that the run has: parameters, motion of one point, innovations of one sensor, one law."""
    drawings = []
    for name in _members(run, "estimate/parameters/")[:2]:
        drawings.append(lambda ax, name=name: parameters(run, name, ax=ax))
    for point in _members(run, "estimate/", "/displacement")[:1]:
        drawings.append(lambda ax: states(run, point, ax=ax))
    for sensor in run.residuals.sensors[:1]:
        drawings.append(lambda ax: innovations(run, sensor, ax=ax))
    for connector in _members(run, "estimate/", "/force")[:1]:
        drawings.append(lambda ax: law(run, connector, ax=ax))
    if not drawings:
        fix = "run.keys() lists its arrays"
        raise InvalidInput(Issue("the run has nothing to draw over time", "it estimates nothing", fix))
    figure, axes = _axes(len(drawings), height=3.0, width=13.0, columns=min(2, len(drawings)))
    for draw, ax in zip(drawings, axes):
        draw(ax)
    figure.suptitle(f"{run.summary.get('title') or run.summary.get('case') or 'run'}: {run.verdict.state}")
    return figure
