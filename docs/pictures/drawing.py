# SPDX-License-Identifier: Apache-2.0
"""What the pictures have in common: runs, sizes, colours, and files with few colours."""

import os
import subprocess
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import kalfem as kf

PROJECT = Path(__file__).resolve().parents[2]
PICTURES = PROJECT / "docs/pictures"
EXAMPLES = PROJECT / "examples"
KALFEM = PROJECT / "build/release/bin/kalfem"
DATA = Path(os.environ.get("KALFEM_DATA") or PROJECT.parent / "shared/data").resolve()
CHROMIUM = [
    "chromium",
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--hide-scrollbars",
    "--virtual-time-budget=5000",
]
BLUE, RED, GREEN, GREY, BLACK = "#1f77b4", "#c62828", "#2e7d32", "#9e9e9e", "#222222"
COLOURS = 32

DRAWN = {}  # name -> function(folder) that gives a figure, or the file of a picture
_folder = None


def picture(draw):
    """Registers a picture by the name of its function."""
    DRAWN[draw.__name__] = draw
    return draw


def make(names, folder):
    global _folder
    _folder = folder
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
    for name in names:
        drawn = DRAWN[name]()
        if not isinstance(drawn, Path):
            drawn = saved(drawn, folder / "figure.png")
        with Image.open(drawn) as found:
            found.convert("RGB").quantize(COLOURS).save(PICTURES / f"{name}.png", optimize=True)
        print(f"{name}.png: {(PICTURES / f'{name}.png').stat().st_size // 1024} kB", flush=True)


def saved(figure, file):
    """All of one width, 880 pixels."""
    width, height = figure.get_size_inches()
    figure.set_size_inches(8, height * 8 / width)
    figure.savefig(file, dpi=110, bbox_inches="tight")
    plt.close(figure)
    return file


def panels(rows=1, columns=1, height=2.6, **options):
    return plt.subplots(rows, columns, figsize=(8, height * rows), layout="constrained", **options)


def scratch(name):
    path = _folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def command(*arguments, codes=(0, 3), **environment):
    """What the command prints."""
    done = subprocess.run(
        [KALFEM, *arguments],
        capture_output=True,
        text=True,
        cwd=_folder,
        env={**os.environ, "KALFEM_DATA": str(DATA), **environment},
    )
    if done.returncode not in codes:
        raise SystemExit(f"kalfem {' '.join(map(str, arguments))}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


@cache
def results(case, *settings, verb="run", environment=()):
    """The folder of the results of a case below `examples`, run once."""
    out = scratch(f"runs/{len(list(scratch('runs/x').parent.iterdir()))}")
    changes = [part for setting in settings for part in ("--set", setting)]
    command(verb, EXAMPLES / case, "--out", out, "--quiet", *changes, **dict(environment))
    return out


def run(case, *settings, **options):
    return kf.read_results(results(case, *settings, **options))


def screenshot(page, height):
    """The top of a page."""
    file = scratch("page.png")
    subprocess.run(
        [*CHROMIUM, f"--screenshot={file}", f"--window-size=1100,{height}", page.as_uri()],
        check=True,
        capture_output=True,
    )
    return file


def band(ax, values, colour=BLUE, label=None, factor=1.0, **style):
    """A line over time with two standard deviations about it."""
    y, std = factor * np.asarray(values), factor * np.asarray(values.std)
    ax.fill_between(values.t, y - 2 * std, y + 2 * std, color=colour, alpha=0.25, lw=0)
    ax.plot(values.t, y, color=colour, lw=1.2, label=label, **style)


def above(ax, **options):
    """The legend above the axes."""
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncol=4, borderaxespad=0.2, fontsize="small", **options)


def title(ax, text):
    ax.set_title(text, loc="left", fontsize="medium")
