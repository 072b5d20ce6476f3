# SPDX-License-Identifier: Apache-2.0
"""Errors of the package, and the import of optional packages."""

import importlib
from typing import NamedTuple

_PACKAGES = {"matplotlib.pyplot": "matplotlib", "matplotlib.figure": "matplotlib"}


class Issue(NamedTuple):
    """One problem that the user can mend: the fact, the requirement that it breaks, and what to write instead."""

    what: str
    why: str = ""
    fix: str = ""
    file: str = ""
    line: int = 0

    def __str__(self):
        place = f"{self.file}:{self.line}: " if self.line else f"{self.file}: " if self.file else ""
        return place + self.what + (f": {self.why}" if self.why else "") + (f"; {self.fix}" if self.fix else "")


class InvalidInput(ValueError):
    """Input that the user can mend. `issues` holds every problem that was found, one :class:`Issue` each.

    >>> print(InvalidInput([Issue("duration is -1 s", "must be > 0")]))
    duration is -1 s: must be > 0
    """

    def __init__(self, issues, message=None):
        self.issues = [issues] if isinstance(issues, Issue) else list(issues)
        self._message = message or "\n".join(map(str, self.issues))
        super().__init__(self.issues, message)

    def __str__(self):
        return self._message


class UnknownName(KeyError):
    """A name that does not exist, with the nearest one that does."""

    def __str__(self):
        return self.args[0]


class MissingPackage(ImportError):
    """An optional package is not installed."""


def unknown_name(what, name, known):
    """The error for `name`, which is none of `known`."""
    import difflib  # here: importing the package stays quick

    known = list(known)
    near = difflib.get_close_matches(str(name), known, 1, 0.5)
    if near:
        hint = f" (did you mean '{near[0]}'?)"
    else:
        shown = ", ".join(known[:12]) + (f" and {len(known) - 12} more" if len(known) > 12 else "")
        hint = f"; there are {shown}" if known else "; there are none"
    return UnknownName(f"there is no {what} '{name}'{hint}")


def optional(module, purpose):
    """Import an optional package, or say in one message how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = _PACKAGES.get(module, module)
        raise MissingPackage(
            f"{purpose} needs {name}: install python3-{name} (Debian) or '{name}' (pip)", name=module
        ) from error
