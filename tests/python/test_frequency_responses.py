# SPDX-License-Identifier: Apache-2.0
"""kf.frequency_responses beside kf.frf, a closed form, and the command's `frf`."""

import numpy as np
import pytest

import kalfem as kf
from test_statics import DECK

CASE = """
kalfem: 1
substructures:
  b:
    finite_elements: {deck: bar.inp, units: {length: 1 m, mass: 1 kg, time: 1 s}, nodes: {tip: 3, middle: 2}}
    damping: {modal: 1 %, modal_up_to: 20 kHz}
    reduction: {up_to: 200 Hz, boundary: [tip.y]}
frequency_response:
  frequencies: {from: 1 Hz, to: 100 Hz, lines: 200}
  inputs: [b.tip.y]
  outputs: [{acceleration: b.middle.y}, {displacement: b.tip.y}]
  model: both
"""
OUTPUTS = {"a": kf.acceleration("b.middle.y"), "x": kf.displacement("b.tip.y")}
LINES = np.linspace(1, 100, 200)


def test_it_gives_what_the_case_gives(tmp_path):
    (tmp_path / "bar.inp").write_text(DECK)
    (tmp_path / "case.yaml").write_text(CASE)
    run = kf.run(tmp_path / "case.yaml", progress=False)
    bar = kf.read_deck(tmp_path / "bar.inp", name="b", nodes={"tip": 3, "middle": 2})
    s = kf.Structure().add(bar.modal_damping(0.01, up_to=2e4).reduce(up_to=200, boundary=["tip.y"]))
    found = kf.frequency_responses(s, LINES, ["b.tip.y"], OUTPUTS, model="both", progress=False)
    for expected, name in zip(run.summary["frequency_response"]["responses"], ["a", "x"]):
        each = found["b.tip.y", name]
        assert each.unit == expected["unit"]
        assert len(each.peaks) == len(expected["peaks"]) > 0
        for peak, other in zip(each.peaks, expected["peaks"]):
            assert peak.frequency == pytest.approx(other["frequency_hz"], rel=1e-9)
            assert peak.damping == pytest.approx(other["damping_ratio"], rel=1e-6)
            assert peak.magnitude == pytest.approx(other["magnitude"], rel=1e-9)
        assert each.difference.at_resonances == pytest.approx(expected["difference"]["at_resonances"], rel=1e-3, abs=1e-9)
        assert each.difference.between == pytest.approx(expected["difference"]["between"], rel=1e-3, abs=1e-9)
        path = f"frequency_response/b.tip.y/{expected['output']}/{expected['quantity']}/full"
        np.testing.assert_allclose(abs(each.full), run[path], rtol=1e-9)
    assert "peaks at" in repr(found)


def test_one_mass_by_both_methods():
    s = kf.Structure().add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0)).force("hammer", "m.1")
    s.base_displacement("road", "m.ground")
    outputs = {"x": kf.displacement("m.1"), "a": kf.acceleration("m.1")}
    found = kf.frequency_responses(s, LINES, ["hammer", "road"], outputs, progress=False)
    direct = kf.frequency_responses(s, LINES, ["hammer", "road"], outputs, method="direct", progress=False)
    w = 2j * np.pi * LINES
    expected = {"hammer": 1 / (2e3 + 4 * w + 2 * w**2), "road": (2e3 + 4 * w) / (2e3 + 4 * w + 2 * w**2)}
    for (place, name), each in found.items():
        h = expected[place] * (w**2 if name == "a" else 1)
        np.testing.assert_allclose(each.values, h, rtol=1e-8)
        np.testing.assert_allclose(direct[place, name].values, h, rtol=1e-8)
        np.testing.assert_allclose(kf.frf(s, LINES, place, outputs)[name], h, rtol=1e-8)
        assert each.reduced is None and each.difference is None
    (peak,) = found["hammer", "x"].peaks
    assert peak.frequency == pytest.approx(np.sqrt(1e3) / 2 / np.pi, rel=2e-3)
    assert peak.damping == pytest.approx(1 / np.sqrt(1e3), rel=1e-2)
    with pytest.raises(KeyError, match="no response"):
        found["hammer", "y"]


def test_wrong_arguments_are_named():
    s = kf.Structure().add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    with pytest.raises(kf.InvalidInput) as refused:
        kf.frequency_responses(s, [2.0, 1.0], ["m.7"], {"x": kf.displacement("m.1")}, model="both", progress=False)
    words = str(refused.value)
    assert "frequencies: they do not ascend" in words and "'m.7'" in words and "no finite elements to reduce" in words
    with pytest.raises(kf.InvalidInput, match="model: there is no 'ful'"):
        kf.frequency_responses(s, LINES, ["m.1"], {"x": kf.displacement("m.1")}, model="ful", progress=False)
    with pytest.raises(kf.InvalidInput, match="outputs: the list is empty"):
        kf.frequency_responses(s, LINES, ["m.1"], {}, progress=False)
