# SPDX-License-Identifier: Apache-2.0
"""HTML of parameters, verdicts, runs and structures."""

from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
from kalfem.display import rounded, structure_html
from kalfem.parameters import Parameters, Verdict


def cells(html):
    """Rows of the first table, and a check that the HTML is well formed."""
    tree = ElementTree.fromstring(f"<div>{html}</div>")
    table = next(tree.iter("table"))
    return [["".join(cell.itertext()) for cell in row] for row in table.iter("tr")]


@pytest.mark.parametrize(
    "value, std, text",
    [
        (19.97832, 0.0893, "19.978"),
        (20123.0, 300.0, "20120"),
        (2.0713e11, 3.1e9, "2.071e+11"),
        (3.2e-7, None, "3.200e-07"),
        (0.001234, 0.0005, "0.00123"),
        (5.0, 80.0, "5.0"),
        (0.0, 1.0, "0"),
        (float("inf"), None, "inf"),
        (None, None, "-"),
    ],
)
def test_digits_follow_the_deviation(value, std, text):
    assert rounded(value, std) == text


def test_parameters(memory_run):
    head, body_k, mount_k = cells(memory_run.parameters._repr_html_())
    assert head == ["parameter", "value", "std", "robust std", "95 %", "initial", "unit", "truth"]
    assert mount_k == ["mount.k", "19.98", "0.20", "-", "19.60 to 20.40", "10.00", "N/m", "20.00"]
    assert body_k[:4] == ["body.k", "2.000", "-", "-"]
    assert Parameters([])._repr_html_() == "<p>no parameters</p>"


def test_verdict(memory_run):
    html = memory_run.verdict._repr_html_()
    assert cells(html)[1] == ["a3", "2 times as large", "check <its> noise"]
    assert "suspicious" in html and "#b26a00" in html
    assert "table" not in Verdict("consistent")._repr_html_()


def test_run(memory_run):
    html = memory_run._repr_html_()
    cells(html)
    assert "a &lt;small&gt; case" in html and "partially linear UKF: NIS 1.020 (expected 1.000)" in html
    assert repr(memory_run).splitlines()[0] == "a <small> case: suspicious"


def test_structure():
    contents = {
        "substructures": [("body", "lumped", 10)],
        "connectors": [("mount", "body.1", "ground", "linear", {"k": (1e4, "N/m"), "c": (20.0, "N s/m")})],
        "inputs": [],
    }
    html = structure_html(SimpleNamespace(contents=contents))
    assert cells(html) == [["name", "kind", "degrees of freedom"], ["body", "lumped", "10"]]
    assert "k 10000 N/m, c 20.00 N s/m" in html and html.endswith("<p>none</p>")
