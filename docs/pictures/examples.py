# SPDX-License-Identifier: Apache-2.0
"""The pictures of the examples. Those of measured records need $KALFEM_DATA."""

import re

import numpy as np
from drawing import (
    BLACK,
    BLUE,
    EXAMPLES,
    GREEN,
    GREY,
    RED,
    above,
    band,
    command,
    panels,
    picture,
    results,
    run,
    scratch,
    title,
)
from meshes import read_vtu

import kalfem as kf


@picture
def static_hole():
    """Von Mises stress on the deformed quarter plate."""
    mesh = read_vtu(results("static/hole.yaml", verb="static") / "quarter_static.vtu")
    motion = mesh["tension: displacement"]
    x, y, _ = (1e3 * (mesh["points"] + 150 * motion)).T
    figure, ax = panels(height=3.4)
    stress = mesh["tension: von Mises stress"] / 1e6
    shades = ax.tricontourf(x, y, mesh.triangles, stress, levels=range(0, 321, 20), cmap="viridis")
    ax.triplot(x, y, mesh.triangles, lw=0.15, color="white")
    figure.colorbar(shades, ax=ax, label="von Mises stress [MPa]")
    ax.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    title(ax, "A quarter of the plate, pulled to the right by 50 kN (motion 150 times enlarged)")
    return figure


@picture
def southampton():
    found = run("southampton/southampton.yaml", verb="update")
    figure, axes = panels(2, height=2.3, sharex=True)
    for ax, number, name in zip(axes, (1, 3), ("first floor, blow on the first", "third floor, blow on the first")):
        for which, style in (
            ("before", {"color": GREY, "lw": 1.0, "ls": "--"}),
            ("measured", {"color": BLACK, "lw": 2.2, "alpha": 0.5}),
            ("after", {"color": RED, "lw": 1.0}),
        ):
            path = f"updating/responses/accelerance/{number}"
            label = {"before": "model before", "after": "model after the updating"}.get(which, which)
            ax.semilogy(found[f"{path}/frequency"], found[f"{path}/{which}"], label=label, **style)
        ax.set_ylabel("accelerance [m/s²/N]")
        ax.margins(x=0)
        title(ax, name)
    axes[1].set_xlabel("frequency [Hz]")
    above(axes[0])
    return figure


@picture
def garteur():
    """Errors of the ten natural frequencies before and after, of the table that the run prints."""
    printed = command("update", EXAMPLES / "garteur/wing.yaml", "--out", scratch("garteur"))
    table = re.search(r"before \[Hz\].*?\n.*?\n(.*?)\n\n", printed, re.DOTALL)[1]
    rows = [re.findall(r"[-+]?\d+\.\d+", line) for line in table.splitlines()]
    measured, before, after = ([float(row[column]) for row in rows] for column in (0, 2, 4))
    figure, ax = panels(height=2.6)
    places = np.arange(len(rows))
    ax.bar(places - 0.2, before, 0.4, color=GREY, label="before the updating")
    ax.bar(places + 0.2, after, 0.4, color=BLUE, label="after it")
    ax.axhline(0, color=BLACK, lw=0.8)
    ax.set_xticks(places, [f"{f:g}" for f in measured])
    ax.set(xlabel="measured natural frequency [Hz]", ylabel="error of the model [%]")
    above(ax)
    return figure


@picture
def mr_damper():
    """The held-back half: the coil's voltage is an input of the law."""
    found = run("mr-damper/mr_damper.yaml", "estimate.diagnose=false")
    figure, axes = panels(1, 2, height=3.2, gridspec_kw={"width_ratios": [2, 1]})
    measured, simulated = found["validation/force_N/measured"], found["validation/force_N/simulated"]
    shown = (measured.t >= 8) & (measured.t <= 10)
    axes[0].plot(measured.t[shown], measured[shown] / 1e3, color=BLACK, lw=2, alpha=0.4, label="measured")
    axes[0].plot(measured.t[shown], simulated[shown] / 1e3, color=RED, lw=1, label="simulated, data that were not used")
    axes[0].set(xlabel="time [s]", ylabel="force [kN]")
    above(axes[0])
    force, rate = found["estimate/component/force"], found["estimate/component/rate"]
    axes[1].plot(1e3 * rate, force / 1e3, color=BLUE, lw=0.3)
    axes[1].set(xlabel="velocity [mm/s]", ylabel="force of the law [kN]")
    return figure


@picture
def friction_damper():
    found = run("friction-damper/friction_damper.yaml", "estimate.diagnose=false")
    figure, axes = panels(1, 2, height=3.2, gridspec_kw={"width_ratios": [2, 1]})
    measured, simulated = found["validation/damping_force_N/measured"], found["validation/damping_force_N/simulated"]
    axes[0].plot(measured.t, measured / 1e3, color=BLACK, lw=2, alpha=0.4, label="measured")
    axes[0].plot(measured.t, simulated / 1e3, color=RED, lw=1, label="simulated, data that were not used")
    axes[0].set(xlabel="time [s]", ylabel="force [kN]")
    above(axes[0])
    deformation = 1e3 * found["estimate/component/deformation"]
    axes[1].plot(deformation, found["measurements/damping_force_N"] / 1e3, color=BLACK, lw=2, alpha=0.4)
    axes[1].plot(deformation, found["estimate/component/force"] / 1e3, color=BLUE, lw=0.8)
    axes[1].set(xlabel="displacement [mm]", ylabel="force [kN]")
    title(axes[1], "law with play (blue)")
    return figure


@picture
def painter_street():
    """Stiffness of both embankments over the earthquake, beside the shaking."""
    found = run("painter-street/painter_street.yaml", "estimate.diagnose=false", verb="estimate")
    banks = [f"estimate/parameters/bridge.{name}.stiffness" for name in ("west_bank", "east_bank")]
    sensor = next(path for path in found.keys() if path.startswith("measurements/"))
    figure, axes = panels(2, height=1.9, sharex=True, gridspec_kw={"height_ratios": [1, 2]})
    axes[0].plot(found[sensor].t, found[sensor], color=BLACK, lw=0.5)
    axes[0].set_ylabel(f"{sensor.split('/')[1]} [m/s²]")
    for path, colour in zip(banks, (BLUE, RED)):
        band(axes[1], found[path], colour, path.split("/")[-1], factor=1e-6)
    axes[1].set(xlabel="time [s]", ylabel="stiffness [MN/m]")
    axes[1].set_ylim(0, None)
    axes[1].margins(x=0)
    above(axes[1])
    return figure


@picture
def shake_table():
    """A sine that was not used, predicted from an earthquake."""
    found = run("shake-table-frames/three_storeys.yaml", "estimate.diagnose=false")
    names = ("1st", "2nd", "3rd")
    figure, axes = panels(len(names), height=1.5, sharex=True)
    for ax, name in zip(axes, names):
        measured, simulated = found[f"validation/{name}/measured"], found[f"validation/{name}/simulated"]
        ax.plot(measured.t, measured, color=BLACK, lw=2, alpha=0.4, label="measured")
        ax.plot(measured.t, simulated, color=RED, lw=0.9, label="simulated, from the estimates alone")
        middle = 0.5 * (measured.t[0] + measured.t[-1])
        ax.set(xlim=(middle, middle + 3), ylabel=f"{name} [m/s²]")
    axes[-1].set_xlabel("time [s]")
    above(axes[0])
    return figure


@picture
def silverbox():
    """Another realisation, simulated; the error a hundred times enlarged."""
    found = run("sysid-benchmarks/silverbox.yaml", "estimate.diagnose=false")
    measured, simulated = found["validation/V2/measured"], found["validation/V2/simulated"]
    figure, ax = panels(height=2.8)
    ax.plot(measured.t, 1e3 * measured, color=BLACK, lw=2, alpha=0.4, label="measured")
    ax.plot(measured.t, 1e3 * simulated, color=BLUE, lw=0.9, label="simulated")
    ax.plot(measured.t, 1e5 * (measured - simulated), color=RED, lw=0.6, label="difference x 100")
    middle = 0.5 * (measured.t[0] + measured.t[-1])
    ax.set(xlim=(middle, middle + 0.3), ylim=(-150, 150), xlabel="time [s]", ylabel="V2 [mV]")
    above(ax)
    return figure


@picture
def halfcar():
    """Simulated from the estimates alone, beside what the bench measured after the release."""
    found = run("halfcar/halfcar.yaml", "estimate.diagnose=false", verb="estimate")
    figure, axes = panels(2, 2, height=1.6, sharex=True, sharey="row")
    for ax, name in zip(axes.flat, ("sprung_LH", "sprung_RH", "unsprung_LH", "unsprung_RH")):
        measured, simulated = found[f"measurements/{name}"], found[f"open_loop/{name}"]
        ax.plot(measured.t, 1e3 * measured, color=BLACK, lw=2, alpha=0.4, label="measured")
        ax.plot(simulated.t, 1e3 * simulated, color=RED, lw=0.9, label="simulated")
        title(ax, name)
        ax.margins(x=0)
    for ax in axes[:, 0]:
        ax.set_ylabel("motion [mm]")
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    above(axes[0, 1])
    return figure


@picture
def vehicle():
    """Rotation in the middle of the frame, where no sensor tells it, predicted and simulated; one unknown."""
    found = run("start/vehicle/case.yaml", "estimate.diagnose=false")
    figure, axes = panels(1, 2, height=2.8, gridspec_kw={"width_ratios": [1.6, 1]})
    predicted, truth = (found[f"{group}/frame.middle.ry/displacement"] for group in ("prediction", "truth"))
    axes[0].plot(truth.t, 1e3 * truth, color=BLACK, lw=2, alpha=0.4, label="simulated truth")
    axes[0].plot(predicted.t, 1e3 * predicted, color=RED, lw=0.9, label="predicted, no sensor there")
    axes[0].set(xlim=(2, 3), xlabel="time [s]", ylabel="frame.middle.ry [mrad]")
    above(axes[0])
    band(axes[1], found["estimate/parameters/suspension_2.mu_k1"], label="estimate ± 2 std")
    axes[1].axhline(30, color=BLACK, ls="--", lw=1, label="truth")
    axes[1].set(xlabel="time [s]", ylabel="suspension_2.mu_k1 [N]")
    axes[1].margins(x=0)
    axes[1].legend(loc="lower right")
    return figure


@picture
def filters():
    """Errors of five filters over 40 records, in the deviations that each states."""
    names = ["partially_linear_ukf", "ukf", "ukf_square_root", "ekf"]
    grid = {"estimate.filter": names}
    changed = {"simulate.duration": "4 s", "estimate.settle": "1 s", "estimate.diagnose": False}
    found = kf.sweep(str(EXAMPLES / "chain/chain.yaml"), grid, seeds=40, set=changed, progress=False)
    figure, axes = panels(1, 2, height=2.2, sharey=True)
    for ax, name in zip(axes, ("suspension.mu_k1", "suspension.mu_c1")):
        path = f"parameters/{name}"
        errors = (found[f"{path}/estimate"] - found[f"{path}/true"]) / found[f"{path}/std"]
        ax.boxplot(list(errors.reshape(found.shape)), vert=False, labels=names)
        ax.axvspan(-2, 2, color=GREEN, alpha=0.15, lw=0)
        ax.set_xlabel(f"error of {name} [std]")
    return figure
