# SPDX-License-Identifier: Apache-2.0
"""Functions that workers import by name."""

import os
import time

import numpy as np
from conftest import small_results
from kalfem.results import Run


def square(settings):
    time.sleep(settings.get("sleep", 0.0))
    return settings["x"] ** 2


def fails_at_three(settings):
    if settings["x"] == 3:
        raise ValueError("three is not allowed")
    return settings["x"]


class Stubborn(Exception):
    """An exception that pickle cannot make again."""

    def __init__(self, first, second):
        super().__init__(f"{first} and {second}")


def raises_stubbornly(settings):
    raise Stubborn("one", "two")


def dies(settings):
    os._exit(1)


def small_run(settings):
    """A run whose parameter is the setting."""
    summary, datasets = small_results()
    summary["parameters"]["mount.k"]["estimate"] = settings["k"]
    return Run.from_memory(summary, datasets)


def logged(settings):
    """Leaves a line in a file for each call."""
    with open(settings["log"], "a") as log:
        log.write("called\n")
    return settings["x"]


def mixed(settings):
    """A value of every kind that is kept without a pickle."""
    x = settings["x"]
    return {
        "square": x**2,
        "pair": (x, [None, True, "text", float("inf")]),
        "at": complex(1, x),
        "modes": np.arange(6.0).reshape(2, 3) * (1 + 2j),
        "scalar": np.float32(x),
    }


def as_set(settings):
    return {settings["x"]}
