# SPDX-License-Identifier: Apache-2.0
"""A progress bar in a terminal or a notebook."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable

_WIDTH = 30


def reporter(progress: bool | Callable[[float, str], None]) -> Bar | Silent:
    """The bar for the argument `progress` of a long call.

    Parameters
    ----------
    progress : bool or callable
        True: a bar, where somebody can see it. False: nothing. A function is called with the fraction done in [0, 1]
        and words, as the bar is; an exception that it raises stops the call.

    Returns
    -------
    context manager
        Call what it gives with (fraction, words); at its end the bar goes away.
    """
    if callable(progress):
        return Silent(progress)
    view = _view() if progress else None
    return Bar(view) if view else Silent()


class Silent:
    """No bar; passes the fraction on to a function, if there is one."""

    def __init__(self, function=None):
        self._function = function

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return None

    def __call__(self, fraction, words=""):
        if self._function:
            self._function(fraction, words)


class Bar:
    """Draws at most `rate` times a second, and nothing in the first `delay` seconds.

    `view` has ``show(fraction, words)`` and ``clear()``.
    """

    def __init__(self, view, rate=10.0, delay=0.5, clock=time.monotonic):
        self._view, self._pause, self._clock = view, 1.0 / rate, clock
        self._due = clock() + delay
        self._shown = False

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self._shown:
            self._view.clear()

    def __call__(self, fraction, words=""):
        now = self._clock()
        if now >= self._due:
            self._view.show(min(max(fraction, 0.0), 1.0), words)
            self._shown, self._due = True, now + self._pause


class TerminalView:
    """One line that is drawn over and over."""

    def __init__(self, stream):
        self._stream = stream

    def show(self, fraction, words):
        done = round(fraction * _WIDTH)
        self._stream.write(f"\r\033[K[{'#' * done}{'.' * (_WIDTH - done)}] {100 * fraction:3.0f} % {words}"[:100])
        self._stream.flush()

    def clear(self):
        self._stream.write("\r\033[K")
        self._stream.flush()


class NotebookView:
    """One output of the cell that is replaced over and over; `display` is IPython's."""

    def __init__(self, display):
        self._display, self._handle = display, None

    def show(self, fraction, words):
        bar = f"<progress max='1' value='{fraction:.3f}'></progress> {100 * fraction:.0f} % {html.escape(words)}"
        self._put(_Html(bar, f"{100 * fraction:.0f} % {words}"))

    def clear(self):
        self._put(_Html("", ""))

    def _put(self, content):
        if self._handle:
            self._handle.update(content)
        else:
            self._handle = self._display(content, display_id=True)


class _Html:
    def __init__(self, rich, plain):
        self._rich, self._plain = rich, plain

    def _repr_html_(self):
        return self._rich

    def __repr__(self):
        return self._plain


def _view():
    """Where a bar can be seen: a notebook, a terminal, or nowhere (None)."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is not None and hasattr(shell, "kernel"):
        return NotebookView(sys.modules["IPython.display"].display)
    return TerminalView(sys.stderr) if sys.stderr is not None and sys.stderr.isatty() else None
