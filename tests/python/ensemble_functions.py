"""Functions that workers import by name."""

import os
import time

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
