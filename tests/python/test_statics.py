# SPDX-License-Identifier: Apache-2.0
"""kf.statics beside closed forms and beside the command's `static`."""

import numpy as np
import pytest

import kalfem as kf

AREA, MODULUS, DENSITY = 2e-4, 2.1e11, 7850.0
DECK = """*NODE
1, 0., 0., 0.
2, 0.5, 0., 0.
3, 1., 0., 0.
*NSET, NSET=ends
1, 3
*ELEMENT, TYPE=B31, ELSET=bar
1, 1, 2
2, 2, 3
*MATERIAL, NAME=steel
*ELASTIC
2.1e11, 0.3
*DENSITY
7850.
*BEAM SECTION, SECTION=RECT, ELSET=bar, MATERIAL=steel
0.02, 0.01
0., 1., 0.
*BOUNDARY
1, 1, 6
"""
CASE = """
kalfem: 1
substructures:
  b: {finite_elements: {deck: bar.inp, units: {length: 1 m, mass: 1 kg, time: 1 s}, nodes: {tip: 3}}}
static:
  substructure: b
  cases:
    push: {forces: [{at: tip, force: [0, 0, 10 N]}], gravity: [0, 0, -9.81]}
    spin: {rotation: {axis: [0, 0, 1], speed: 100}}
"""
CASES = {
    "push": {"forces": {"tip": (0, 0, "10 N")}, "gravity": [0, 0, -9.81]},
    "spin": {"rotation": {"axis": (0, 0, 1), "speed": 100}},
}


@pytest.fixture
def bar(tmp_path):
    (tmp_path / "bar.inp").write_text(DECK)
    return kf.read_deck(tmp_path / "bar.inp", name="b", nodes={"tip": 3})


def test_it_gives_what_the_case_gives(bar, tmp_path):
    (tmp_path / "case.yaml").write_text(CASE)
    expected = kf.run(tmp_path / "case.yaml", progress=False).summary["statics"]
    solved = kf.statics(bar, CASES)
    assert list(solved) == list(expected)
    for name, case in expected.items():
        tip = [case["displacements"]["tip"][each] for each in ("x", "y", "z", "rx", "ry", "rz")]
        np.testing.assert_allclose(solved[name].nodes["tip"].displacement, tip, rtol=1e-9, atol=1e-15)
        assert solved[name].peaks[0].stress == pytest.approx(case["stress_max"]["axial"], rel=1e-9)
        assert solved[name].peaks[0].element == case["stress_max"]["element"]
        np.testing.assert_allclose(solved[name].reaction_sum.force, case["reaction_sum"]["force"], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(solved[name].applied.about, case["applied"]["about"], atol=1e-12)


def test_closed_forms(bar):
    solved = kf.statics(
        bar,
        {
            "pull": {"forces": {3: ("1 kN", 0, 0)}},
            "twist": {"moments": {"tip": (0, 0, 5.0)}},
            "moved": {"displacements": {"tip.x": "1 mm"}},
            "weight": {"gravity": (0, 0, -9.81)},
        },
    )
    assert solved["pull"].nodes["tip"].displacement[0] == pytest.approx(1000 / (MODULUS * AREA), rel=1e-9)
    assert solved["pull"].peaks[0].stress == pytest.approx(1000 / AREA, rel=1e-6)
    assert solved["pull"].peaks[0].of_beam
    x, y, z, rx, ry, rz = solved["twist"].nodes["tip"].displacement
    assert y == pytest.approx(rz / 2, rel=1e-9)  # M L^2 / (2 E I) and M L / (E I)
    assert solved["moved"].reactions["imposed motion"].force[0] == pytest.approx(MODULUS * AREA * 1e-3, rel=1e-9)
    weight = DENSITY * AREA * 9.81
    assert solved["weight"].reaction_sum.force[2] == pytest.approx(weight, rel=1e-9)
    assert solved["weight"].imbalance < 1e-9 and solved.warnings == []
    assert solved["pull"].displacements.shape == (3, 6)
    assert "largest displacement" in repr(solved)
    with pytest.raises(KeyError, match="did you mean 'pull'"):
        solved["pul"]


def test_wrong_arguments_are_named(bar):
    with pytest.raises(kf.InvalidInput) as refused:
        kf.statics(bar, {"a": {"forces": {"tp": (0, 0, 1)}}, "b": {"displacements": {"tip": 1.0}}})
    words = str(refused.value)
    assert "cases[0] 'a': forces[0]: there is no node or group 'tp'" in words and "there is no motion 'tip'" in words
    for case, message in [
        ({"force": {}}, "did you mean 'forces'"),
        ({"forces": {"tip": (1, 2)}}, "three numbers are needed"),
        ({"forces": (1, 2, 3)}, "a dictionary is needed"),
        ({"rotation": {"speeed": 1}}, "did you mean 'speed'"),
        ({"gravity": (0, 0, "9.81 N")}, "gravity"),
        (3, "a dictionary is needed"),
    ]:
        with pytest.raises(kf.InvalidInput, match=message):
            kf.statics(bar, {"a": case})
    with pytest.raises(kf.InvalidInput, match="the list is empty"):
        kf.statics(bar, {})
