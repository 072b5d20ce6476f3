# SPDX-License-Identifier: Apache-2.0
"""The bar in terminals and notebooks."""

import io
import sys
from types import SimpleNamespace

import pytest
from kalfem.progress import Bar, NotebookView, Silent, TerminalView, reporter


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_a_bar_waits_and_draws_ten_times_a_second():
    clock, stream = Clock(), io.StringIO()
    with Bar(TerminalView(stream), clock=clock) as bar:
        for step in range(200):
            clock.now = 0.01 * step
            bar(step / 200, "estimate")
    drawn = stream.getvalue().split("\r\033[K")[1:]
    assert drawn[0] == "[########......................]  25 % estimate" and drawn[-1] == ""
    assert 14 <= len(drawn) - 1 <= 16


def test_a_short_call_shows_nothing():
    stream = io.StringIO()
    with Bar(TerminalView(stream), clock=Clock()) as bar:
        bar(0.5, "estimate")
    assert stream.getvalue() == ""


def test_a_notebook_replaces_its_output():
    shown = []

    def display(content, display_id):
        shown.append(content._repr_html_())
        return SimpleNamespace(update=lambda content: shown.append(content._repr_html_()))

    view = NotebookView(display)
    view.show(0.25, "estimate <1>")
    view.show(0.5, "estimate <1>")
    view.clear()
    assert shown[0] == "<progress max='1' value='0.250'></progress> 25 % estimate &lt;1&gt;"
    assert "50 %" in shown[1] and shown[2] == "" and len(shown) == 3


def test_a_function_takes_the_place_of_the_bar():
    calls = []
    with reporter(lambda *call: calls.append(call)) as report:
        report(0.5, "estimate")
    assert calls == [(0.5, "estimate")]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_bar_is_drawn_where_somebody_sees_it(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert isinstance(reporter(True), Silent)
    monkeypatch.setattr(sys, "stderr", Terminal())
    assert isinstance(reporter(True), Bar) and isinstance(reporter(False), Silent)
    shell = SimpleNamespace(kernel=None)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=print))
    assert isinstance(reporter(True)._view, NotebookView)


def test_the_bar_goes_away_after_an_error():
    clock, stream = Clock(), io.StringIO()
    with pytest.raises(ValueError):
        with Bar(TerminalView(stream), clock=clock) as bar:
            clock.now = 1.0
            bar(0.5)
            raise ValueError
    assert stream.getvalue().endswith("\r\033[K")
