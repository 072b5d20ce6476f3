# SPDX-License-Identifier: Apache-2.0
"""Plots: what they draw, and what they say where there is nothing to draw."""

from types import SimpleNamespace

import numpy as np
import pytest

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

from conftest import small_results  # noqa: E402
from kalfem import plots  # noqa: E402
from kalfem.errors import InvalidInput, UnknownName  # noqa: E402
from kalfem.results import Run  # noqa: E402


@pytest.fixture(autouse=True)
def close_figures():
    yield
    matplotlib.pyplot.close("all")


def drawn(ax, label):
    """Values of the line with that label."""
    return next(line.get_ydata() for line in ax.lines if line.get_label() == label)


@pytest.mark.parametrize("what", ["overview", "parameters", "states", "innovations", "law"])
def test_every_plot_is_drawn(memory_run, what, tmp_path):
    memory_run.plot(what).savefig(tmp_path / "plot.png")


def test_parameters_with_band_and_truth(memory_run):
    (ax,) = plots.parameters(memory_run).axes
    course = memory_run["estimate/parameters/mount.k"]
    assert np.array_equal(drawn(ax, "\u00b1 2 std"), course) and list(drawn(ax, "truth")) == [20.0, 20.0]
    band = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert band.max() == (course + 2 * course.std).max() and band.min() == (course - 2 * course.std).min()
    assert ax.get_title(loc="left") == "mount.k = 19.98 +- 0.20 N/m"


def test_states_with_truth(memory_run):
    (ax,) = plots.states(memory_run, "body.3", span=(0.5, 1.0)).axes
    assert np.array_equal(drawn(ax, "truth"), memory_run["truth/body.3/displacement"])
    assert ax.get_xlim() == (0.5, 1.0)


def test_a_long_state_shows_its_last_oscillations():
    t = np.arange(10000) / 1000
    first, last = plots._readable_span(np.sin(2 * np.pi * 10 * t + 0.1), t)
    assert last == t[-1] and abs(last - first - 2.5) < 0.11
    assert plots._readable_span(np.sin(2 * np.pi * t), t) == (t[0], t[-1])


def test_innovations_say_how_many_lie_inside():
    summary, datasets = small_results()
    values = np.zeros(200)
    values[:50] = 3.0
    datasets["innovation/value/a3"] = (values, datasets["innovation/value/a3"][1])
    (ax,) = plots.innovations(Run.from_memory(summary, datasets)).axes
    assert ax.get_title(loc="left") == "a3: 75.0 % inside (expected 95.4 %)"
    assert np.array_equal(drawn(ax, "\u00b1 2 std"), np.full(200, 2.0))


def test_the_law_is_force_against_deformation(memory_run):
    (ax,) = plots.law(memory_run).axes
    assert np.array_equal(drawn(ax, "estimate"), memory_run["estimate/mount/force"])
    assert np.array_equal(drawn(ax, "truth"), memory_run["truth/mount/force"])
    (ax,) = plots.law(memory_run, "mount", span=(1.0, 2.0)).axes
    assert np.array_equal(drawn(ax, "estimate"), memory_run["estimate/mount/force"][100:])


def test_modes():
    shapes = np.array([[1.0, 1.0], [2.0, -0.5]])
    found = SimpleNamespace(frequencies=np.array([3.0, 8.0]), shapes=shapes, dofs=["body.1", "body.2"])
    axes = plots.modes(found).axes
    assert [ax.get_ylabel() for ax in axes] == ["3.000 Hz", "8.000 Hz"]
    assert axes[0].lines[1].get_ydata().tolist() == [0.5, 1.0]


def test_a_series_draws_itself(memory_run):
    (ax,) = memory_run["estimate/body.3/displacement"].plot(color="k").axes
    assert ax.lines[0].get_color() == "k" and ax.get_title(loc="left") == "estimate/body.3/displacement"


def test_axes_of_the_caller(memory_run):
    figure, ax = matplotlib.pyplot.subplots()
    assert plots.states(memory_run, ax=ax) is figure and len(ax.lines) == 2
    with pytest.raises(InvalidInput, match="2 quantities do not fit"):
        plots.states(memory_run, ["body.3", "body.3"], ax=ax)


def test_what_is_not_there_is_said(memory_run):
    with pytest.raises(UnknownName, match=r"no estimate with displacement 'body.4' \(did you mean 'body.3'\?\)"):
        plots.states(memory_run, "body.4")
    with pytest.raises(InvalidInput, match="the run has no smoothed with displacement"):
        plots.states(memory_run, group="smoothed")
    with pytest.raises(InvalidInput, match="nothing to draw over time"):
        Run.from_memory({}, {}).plot()
