# SPDX-License-Identifier: Apache-2.0
"""The pictures of the guides, from examples that ship and from records that are made here."""

import contextlib
import json
import os
import re
import subprocess

import matplotlib.pyplot as plt
import numpy as np
from drawing import (
    BLACK,
    BLUE,
    EXAMPLES,
    GREEN,
    GREY,
    KALFEM,
    PROJECT,
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

MEASURED = "start/measured/case.yaml"
SMALL = (("MESH", "small.msh"),)


@picture
def verdict():
    """Innovations of a right model and of one with a sensor turned around, and what the diagnosis tries."""
    right, wrong = run(MEASURED), run(MEASURED, "sensors.wheel.gain=-1")
    places = [["right", "causes"], ["wrong", "causes"]]
    figure, axes = plt.subplot_mosaic(places, figsize=(8, 3.6), layout="constrained")
    for name, found, words, limit in (("right", right, "as stated", 6), ("wrong", wrong, "'wheel' turned around", 400)):
        innovation, ax = found.residuals["wheel"], axes[name]
        normal = np.asarray(innovation) / innovation.std
        used = np.isfinite(normal)
        ax.plot(innovation.t[used], normal[used], ".", ms=1.5, color=BLUE if name == "right" else RED)
        ax.axhspan(-2, 2, color=GREY, alpha=0.4, lw=0)
        title(ax, f"{words}: {100 * np.mean(np.abs(normal[used]) < 1.96):.0f} % in the 95 % band")
        ax.set(ylabel="innovation / expected", ylim=(-limit, limit))
        ax.margins(x=0)
    axes["wrong"].set_xlabel("time [s]")
    tried = {}
    for each in filter(lambda each: each["mean_nis"], wrong.summary["diagnosis"]["tested"]):
        tried.setdefault(f"{each['code'].replace('_', ' ')}: {each['subject']}", each["mean_nis"])
    names = list(tried)[:8]  # the likeliest first
    ax = axes["causes"]
    ax.barh(range(len(names)), [tried[name] for name in names], color=[RED, *[GREY] * (len(names) - 1)])
    ax.set_yticks(range(len(names)), names)
    ax.set_xscale("log")
    ax.invert_yaxis()
    ax.set_xlabel("mean NIS with it undone")
    title(ax, "What the diagnosis tries")
    return figure


@picture
def fixed_numbers():
    """What 1 % of a fixed number moves, in standard deviations of the estimate."""
    found = run("chain/chain.yaml")
    unknown = list(found.parameters)
    numbers = [each for each in found.summary["sensitivity"]["numbers"] if each["value"] and each["group"] != "delays"]

    def moves(number, name):
        return 0.01 * number["value"] * number["shift"][name] / found.parameters[name].std

    numbers = sorted(numbers, key=lambda number: -max(abs(moves(number, name)) for name in unknown))[:8]
    figure, ax = panels(height=3.2)
    for i, (name, colour) in enumerate(zip(unknown, (BLUE, RED))):
        places = np.arange(len(numbers)) + 0.4 * i - 0.2
        ax.barh(places, [moves(number, name) for number in numbers], 0.4, color=colour, label=name)
    ax.set_yticks(range(len(numbers)), [number["name"] for number in numbers])
    ax.invert_yaxis()
    ax.axvline(0, color=BLACK, lw=0.8)
    ax.set_xlabel("shift of the estimate when the number is 1 % larger [standard deviations of the estimate]")
    above(ax)
    return figure


@picture
def records():
    """The record of `kalfem new measured`: 'wheel' has a gap, 'body' an offset and a delay."""
    record = kf.read(str(EXAMPLES / "start/measured/quarter_car.csv"))
    figure, axes = panels(3, height=1.3, sharex=True)
    words = {"color": RED, "bbox": {"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 1}}
    for ax, (name, values), unit in zip(axes, record.items(), ("mm", "m/s²", "m/s²")):
        values = np.asarray(values)
        ax.plot(record.t, values, color=BLUE, lw=0.6)
        missing = ~np.isfinite(values)
        if missing.any():
            first, last = record.t[missing][[0, -1]]
            ax.axvspan(first, last, color=RED, alpha=0.2, lw=0)
            ax.annotate(f"no samples from {first:g} to {last:.3g} s", (last + 0.1, 0.85 * np.nanmax(values)), **words)
        if name == "body_m_s2":
            ax.axhline(np.nanmean(values), color=RED, lw=1.0)
            ax.annotate(f"mean {np.nanmean(values):.2f} m/s²: an offset", (14, 0.75 * np.nanmax(values)), **words)
        ax.set_ylabel(f"{name.partition('_')[0]} [{unit}]")
        ax.margins(x=0)
    axes[-1].set_xlabel("time [s]")
    return figure


def frame_record():
    """The record of the page on modes: a frame of four storeys under white forces."""
    page = (PROJECT / "docs/modal.md").read_text()
    program = re.search(r"```python\n(import numpy.*?)```", page, re.DOTALL)[1]
    exec(program.replace("ambient.csv", str(scratch("ambient.csv"))), {})
    return scratch("ambient.csv")


@picture
def modal():
    """Stabilisation diagram over the spectrum, and the shapes."""
    record = frame_record()
    found, y = kf.modal(str(record), progress=False), kf.read(str(record))
    figure, axes = panels(1, 2, height=3.2, gridspec_kw={"width_ratios": [2.2, 1]})
    diagram, ax = found.diagram, axes[0]
    ax.plot(diagram["frequency"], diagram["order"], ".", color=BLACK, ms=4)
    for mode in found:
        ax.axvline(mode.frequency, color=RED, lw=1, zorder=0)
    spectrum = ax.twinx()
    blocks = np.hanning(1024) * np.asarray(y["v1"])[:19456].reshape(-1, 1024)
    density = np.mean(np.abs(np.fft.rfft(blocks)) ** 2, axis=0)
    spectrum.semilogy(np.fft.rfftfreq(1024, 1 / 64), density, color=BLUE, lw=0.8, alpha=0.6)
    spectrum.yaxis.set_visible(False)
    ax.set(xlabel="frequency [Hz]", ylabel="order of the model", xlim=(0, 25))
    title(ax, "Poles (dots), spectrum of v1 (blue), modes (red)")
    for mode in found:
        shape = np.concatenate([[0], np.real(mode.shape)])
        axes[1].plot(shape / np.abs(shape).max(), range(5), "o-", ms=4, label=f"{mode.frequency:.2f} Hz")
    axes[1].axvline(0, color=BLACK, lw=0.6)
    axes[1].set(xlabel="shape", ylabel="floor", yticks=range(5))
    axes[1].legend(fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
    return figure


@picture
def deck_modes():
    """Shapes of the plate as the deck describes it, from the file for ParaView."""
    mesh = read_vtu(results("start/plate/case.yaml", verb="modes") / "plate_modes.vtu")
    figure = plt.figure(figsize=(8, 2.6), layout="constrained")
    for i, name in enumerate([name for name in mesh if name.startswith("mode")][:4], 1):
        ax = figure.add_subplot(1, 4, i, projection="3d", box_aspect=(4, 3, 1.2))
        shape = mesh[name] / np.abs(mesh[name]).max()
        size = np.ptp(mesh["points"])
        x, y, z = (mesh["points"] + 0.15 * size * shape).T
        ax.plot_trisurf(x, y, z, triangles=mesh.triangles, cmap="coolwarm", lw=0.1, edgecolor="white")
        ax.set_axis_off()
        ax.view_init(25, -60)
        ax.set_title(name.replace("mode 0", "mode "), fontsize="medium", y=0.95)
    return figure


@picture
def delayed_channel():
    """A channel as it was recorded, beside the motion of its place as the filter estimates it."""
    found = run(MEASURED)
    record, motion = kf.read(str(EXAMPLES / "start/measured/quarter_car.csv")), found["estimate/body.m/acceleration"]
    t, body = record.t, np.asarray(record["body_m_s2"])
    offset, delay = found.parameters["sensors.body.offset"], found.parameters["sensors.body.delay"]
    figure, ax = panels(height=2.6)
    ax.plot(t, body, ".-", color=GREY, ms=3, lw=0.8, label="as recorded")
    ax.plot(motion.t, motion, color=BLACK, lw=1.2, label="estimated motion")
    ax.plot(t - delay.value, body - offset.value, ".", color=RED, ms=4, label="recorded, less delay and offset")
    ax.set(xlim=(2.0, 2.6), ylim=(-4.5, 4.5), xlabel="time [s]", ylabel="acceleration of the body [m/s²]")
    above(ax)
    title(ax, f"delay {1e3 * delay.value:.2f} ms, offset {offset.value:.3f} m/s²")
    return figure


@picture
def unknown_inputs():
    """The chain's road as it is found from accelerations and one displacement, by the filter and by the smoother."""
    settings = (
        "excitation.road.unknown={std: 3 mm, correlation_time: 20 ms}",
        "sensors.d1={displacement: body.1, noise: 1 %}",
        "simulate.duration=8 s",
        "estimate.unknown={}",
        "estimate.smooth=true",
    )
    found = run("chain/chain.yaml", *settings, verb="estimate")
    figure, axes = panels(2, height=1.9, sharex=True)
    truth = found["estimate/inputs/road_true"]
    words_of = {"estimate": "filter: from the samples until then", "smoothed": "smoother: from the whole record"}
    for ax, (group, words) in zip(axes, words_of.items()):
        band(ax, found[f"{group}/inputs/road"], factor=1e3, label="estimate ± 2 std")
        ax.plot(truth.t, 1e3 * truth, color=BLACK, lw=0.9, ls="--", label="road of the simulation")
        ax.set(xlim=(5, 7), ylim=(-12, 12), ylabel="road [mm]")
        title(ax, words)
    axes[1].set_xlabel("time [s]")
    above(axes[0])
    return figure


@picture
def posterior():
    """Samples of two unknowns beside the filter's own normal distribution, and the evidence of three laws."""
    found = run("chain/infer.yaml", verb="infer")
    inference = found.summary["inference"]
    x, y = (np.ravel(found[f"posterior/suspension.{name}"]) for name in ("mu_k1", "mu_c1"))
    figure, axes = panels(1, 2, height=3.2, gridspec_kw={"width_ratios": [1.2, 1]})
    ax = axes[0]
    ax.plot(x, y, ".", color=BLUE, ms=3, alpha=0.5, label="posterior")
    beside, turn = inference["beside_filter"], np.linspace(0, 2 * np.pi, 100)
    (x0, x_std), (y0, y_std) = (
        (beside[f"suspension.{name}"]["filter_mean"], beside[f"suspension.{name}"]["filter_std"])
        for name in ("mu_k1", "mu_c1")
    )
    rho = inference["correlation"]["matrix"][0][1]
    a, b = np.linalg.cholesky([[1, rho], [rho, 1]]) @ [np.cos(turn), np.sin(turn)] * 2.45
    ax.plot(x0 + x_std * a, y0 + y_std * b, color=RED, label="filter, 95 %")
    ax.plot(20, 10, "+", color=BLACK, ms=12, mew=1.5, label="truth")
    ax.set(xlabel="mu_k1 [N]", ylabel="mu_c1 [N]")
    above(ax)
    laws = inference["laws"]["ranking"]
    best = laws[0]["log_evidence"]
    axes[1].barh([law["name"] for law in laws], [best - law["log_evidence"] for law in laws], color=BLUE)
    for row, law in enumerate(laws):
        axes[1].annotate(f" {best - law['log_evidence']:,.0f}", (best - law["log_evidence"], row), va="center")
    axes[1].invert_yaxis()
    axes[1].set_xlim(0, 1.25 * (best - laws[-1]["log_evidence"]))
    axes[1].set_xlabel("ln Z behind the best law")
    title(axes[1], "Which law?")
    return figure


@picture
def placement():
    found = run("chain/place.yaml", verb="place").summary["placement"]
    figure, axes = panels(1, 2, height=3.4, gridspec_kw={"width_ratios": [1.6, 1]})
    places = ["wheel.w", *[f"body.{i}" for i in range(1, 11)]]
    sets = [*found["sets"][:12], found["own_set"]]
    for row, each in enumerate(sets):
        own = row == len(sets) - 1
        axes[0].plot([places.index(name) for name in each["sensors"]], [row] * 4, "o", color=RED if own else BLUE, ms=7)
        axes[0].annotate(f"{-100 * each['criterion']:.3f} %", (11, row), va="center", color=RED if own else BLACK)
    axes[0].set_yticks(range(len(sets)), [*[str(i + 1) for i in range(12)], str(found["own_set"]["rank"])])
    axes[0].set_xticks(range(11), places, rotation=60)
    axes[0].set(xlim=(-0.5, 12.5), ylabel="rank of the set")
    axes[0].invert_yaxis()
    axes[0].grid(axis="x", alpha=0.3)
    title(axes[0], "Best sets of four, and the case's own (red)")
    alone = [-100 * found["candidates"][place]["criterion"] for place in places]
    axes[1].barh(places, alone, color=BLUE)
    axes[1].invert_yaxis()
    axes[1].set_xlabel("expected deviation [% of the prior's]")
    title(axes[1], "Each place alone")
    return figure


@picture
def frequency_response():
    found = run("vehicle/frf.yaml", verb="frf", environment=(*SMALL, ("METHOD", "direct"), ("LINES", "150")))
    f = np.asarray(found["frequency_response/frequency"])
    path = "frequency_response/wheel_1.ground/frame.p1.z/acceleration"
    figure, axes = panels(2, height=1.8, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    axes[0].semilogy(f, found[f"{path}/full"], color=BLACK, lw=2.2, alpha=0.4, label="full model")
    axes[0].semilogy(f, found[f"{path}/reduced"], color=RED, lw=0.9, label="superelement")
    axes[0].set_ylabel("frame.p1.z [m/s²]\nper metre of road")
    above(axes[0])
    axes[1].plot(f, np.degrees(found[f"{path}/reduced_phase"]), color=RED, lw=0.9)
    axes[1].set(xlabel="frequency [Hz]", ylabel="phase [°]", yticks=(-180, 0, 180))
    axes[1].margins(x=0)
    return figure


@picture
def virtual_strain():
    """Strain at a place without a gauge."""
    settings = ("simulate.duration=4 s", "estimate.diagnose=false")
    found = run("vehicle/strain.yaml", *settings, verb="estimate", environment=SMALL)
    figure, axes = panels(2, height=1.9, sharex=True)
    for ax, gauge in zip(axes, ("frame.left_belly", "frame.middle_member")):
        strain, truth = found[f"estimate/{gauge}/strain"], found[f"truth/{gauge}/strain"]
        band(ax, strain, factor=1e6, label="estimate ± 2 std")
        ax.plot(truth.t, 1e6 * truth, color=BLACK, lw=0.9, ls="--", label="truth")
        ax.set(xlim=(3, 3.5), ylabel="strain [µm/m]")
        shown = (truth.t > 3) & (truth.t < 3.5)
        limit = 1.25e6 * np.abs(truth[shown]).max()
        ax.set_ylim(-limit, limit)
        title(ax, f"{gauge}, no gauge there")
    axes[1].set_xlabel("time [s]")
    above(axes[0])
    return figure


@picture
def finished_runs():
    """A figure of `kalfem plot`."""
    command("plot", results(MEASURED), "--width", "17", "--out", scratch("figures"))
    file = scratch("figures") / "parameter-suspension.k.svg"
    convert = ["rsvg-convert", "--width=880", "--background-color=white", "--output", scratch("plot.png"), file]
    subprocess.run(convert, check=True)
    return scratch("plot.png")


@picture
def sweep():
    """Estimates of 40 seeds with their intervals: 95 % of these hold the truth."""
    found = kf.sweep(str(EXAMPLES / "start/chain/case.yaml"), seeds=40, progress=False)
    path = "parameters/suspension.k"
    estimate, std, truth = (np.ravel(found[f"{path}/{part}"]) for part in ("estimate", "std", "true"))
    hit = np.abs(estimate - truth) < 1.96 * std
    figure, ax = panels(height=2.6)
    for inside, colour in ((True, BLUE), (False, RED)):
        place = np.flatnonzero(hit == inside) + 1
        values, width = estimate[hit == inside] / 1e3, 1.96e-3 * std[hit == inside]
        ax.errorbar(place, values, width, fmt="o", ms=3, color=colour, lw=1)
    ax.axhline(truth[0] / 1e3, color=BLACK, ls="--", lw=1)
    ax.set(xlabel="seed of the noise", ylabel="suspension.k [kN/m]")
    title(ax, f"{hit.sum()} of {len(hit)} intervals of 95 % hold the truth (dashed)")
    return figure


@picture
def live():
    """The stream of the page on `watch`: a sensor dies at 10 s and comes back at 25 s."""
    page = (PROJECT / "docs/live.md").read_text()
    for name in ("drive", "watch"):
        text = re.search(rf"<!-- file: {name}.yaml -->\n```yaml\n(.*?)```", page, re.DOTALL)[1]
        scratch(f"{name}.yaml").write_text(text.replace("every: 5 s", "every: 0.2 s"))
    stream = command("play", scratch("drive.yaml"), "--speed", "0", "--fault", "dead:body:10:25")
    live, lines = kf.watch(str(scratch("watch.yaml"))), []
    for line in stream.splitlines():
        lines += live.take(line)
    lines = [json.loads(line) if isinstance(line, str) else line for line in lines]
    t = np.array([line["t"] for line in lines])
    k3 = np.array([[line["parameters"]["strut.k3"][part] for part in ("estimate", "std")] for line in lines]).T / 1e6
    events = {event["kind"]: event["t"] for line in lines for event in line["events"] if event["channel"] == "body"}
    figure, ax = panels(height=2.8)
    ax.fill_between(t, k3[0] - 2 * k3[1], k3[0] + 2 * k3[1], color=BLUE, alpha=0.25, lw=0)
    ax.plot(t, k3[0], color=BLUE, label="estimate ± 2 std")
    ax.axhline(3, color=BLACK, ls="--", lw=1, label="truth")
    ax.axvspan(10, 25, color=RED, alpha=0.12, lw=0, label="sensor 'body' is dead")
    for kind in ("stuck", "back"):
        ax.axvline(events[kind], color=RED, lw=1)
        ax.annotate(f" '{kind}' at {events[kind]:.2f} s", (events[kind], 3.024), color=RED)
    ax.set(xlabel="time of the stream [s]", ylabel="strut.k3 [MN/m³]", ylim=(2.97, 3.03))
    ax.margins(x=0)
    ax.legend(loc="lower right", ncol=3, fontsize="small")
    return figure


@picture
def ambient():
    """The tutorial's stiffnesses: stated, updated with their intervals, and those that made the record."""
    page = (PROJECT / "docs/tutorials/ambient.md").read_text()
    record, program = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names = {}
    exec(record.replace("ambient.csv", str(scratch("ambient.csv"))), names)
    exec(program.replace("ambient.csv", str(scratch("ambient.csv"))).replace("print(", "str("), names)
    found = [names["run"].parameters[f"frame.storey_{i}.stiffness"] for i in range(1, 5)]
    figure, axes = panels(1, 2, height=2.8, gridspec_kw={"width_ratios": [1, 1.6]})
    for mode, colour in zip(names["found"], (BLUE, RED, GREEN, BLACK)):
        shape = np.real(mode.shape)[[0, 2, 1, 3]] / np.abs(mode.shape).max()
        axes[0].plot([0, *shape], range(5), "o-", ms=4, color=colour, label=f"{mode.frequency:.2f} Hz")
    axes[0].set(xlabel="identified shape", ylabel="floor", yticks=range(5))
    axes[0].legend(fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
    truth = np.array(names["k"]) / 1e6
    error = 100 * (np.array([1e-6 * each.value for each in found]) / truth - 1)
    width = 1.96e-4 * np.array([each.std for each in found]) / truth
    axes[1].errorbar(range(1, 5), error, width, fmt="o", ms=4, color=BLUE, label="updated, 95 %")
    axes[1].axhline(0, color=BLACK, ls="--", lw=1, label="truth")
    axes[1].set(xlabel="storey", ylabel="error of the stiffness [%]", xticks=range(1, 5), xlim=(0.5, 4.5), ylim=(-1, 1))
    for storey, stated in enumerate(100 * (10 / truth - 1), 1):
        axes[1].annotate(f"before: {stated:+.0f} %", (storey, -0.9), ha="center", fontsize="small", color=GREY)
    above(axes[1])
    return figure


def of_notebook(name):
    """The figure that the last cell of a notebook draws."""
    cells = json.loads((PROJECT / f"docs/notebooks/{name}.ipynb").read_text())["cells"]
    names = {}
    with contextlib.chdir(scratch(".")), contextlib.redirect_stdout(None):
        os.environ["PATH"] = f"{KALFEM.parent}{os.pathsep}{os.environ['PATH']}"
        for cell in cells:
            if cell["cell_type"] == "code":
                exec("".join(cell["source"]), names)
    return names["figure"]


@picture
def notebook_law():
    return of_notebook("measured-record")


@picture
def notebook_filters():
    return of_notebook("filters-and-laws")


def plate_deck(file, n):
    """A free square plate of n x n shells."""
    lines = ["CEND", "BEGIN BULK", "MAT1,1,2.1E11,,0.3,7850.", "PSHELL,1,1,0.002,1,,1"]
    for j in range(n + 1):
        lines += [f"GRID,{j * (n + 1) + i + 1},,{i / n:.6f},{j / n:.6f},0." for i in range(n + 1)]
    for j in range(n):
        corners = ((j * (n + 1) + i + 1, j * n + i + 1) for i in range(n))
        lines += [f"CQUAD4,{number},1,{a},{a + 1},{a + n + 2},{a + n + 1}" for a, number in corners]
    file.write_text("\n".join([*lines, "ENDDATA", ""]))


@picture
def scale():
    """What `kalfem modes` takes on plates of growing meshes, by the times that it states."""
    found = []
    for n in (40, 80, 120, 160, 200):
        plate_deck(scratch("plate.bdf"), n)
        found.append(json.loads(command("modes", scratch("plate.bdf"), "--json")))
    size = np.array([each["dofs"] for each in found])
    figure, ax = panels(height=2.8)
    parts = {"read and assemble": ("read_s", "assemble_s"), "factor": ("factor_s",), "modes": ("modes_s",)}
    for (label, keys), colour in zip(parts.items(), (GREY, BLUE, RED)):
        times = [sum(each["timing"][key] for key in keys) for each in found]
        ax.loglog(size, times, "o-", ms=4, color=colour, label=label)
    whole = np.array([sum(each["timing"].values()) for each in found])
    ax.loglog(size, whole, "o-", ms=4, color=BLACK, label="together")
    ax.loglog(size, whole[0] * size / size[0], ls=":", color=BLACK, label="in proportion")
    ax.set(xlabel="degrees of freedom", ylabel="time [s]")
    ax.legend(ncol=2)
    return figure
