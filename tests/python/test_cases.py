# SPDX-License-Identifier: Apache-2.0
"""Case files as structures, records and arguments, and back: the numbers stay those of the case, bit for bit."""

from pathlib import Path

import numpy as np
import pytest

import kalfem as kf

EXAMPLES_FOLDER = Path(__file__).parents[2] / "examples"

SHORT = {"estimate.diagnose": False, "estimate.second_thoughts": "none", "estimate.substeps": 1}
EXAMPLES = {
    "start/chain/case.yaml": {"simulate.duration": "1 s", "estimate.settle": "0.1 s", **SHORT},
    "start/measured/case.yaml": {"record.end": "2 s", "validate": None, **SHORT},
    "start/component/case.yaml": {"record.end": "1 s", "validate": None, **SHORT},
}


def assert_same(found, expected):
    """All that both runs have is the same: parameters, and every array by its path."""
    assert list(found.parameters) == list(expected.parameters)
    for name, parameter in found.parameters.items():
        assert (parameter.value, parameter.std) == (expected.parameters[name].value, expected.parameters[name].std)
    common = [path for path in found.keys() if path in expected.keys() and path.startswith(("estimate/", "innovation/"))]
    assert len(common) > 4
    for path in common:
        np.testing.assert_array_equal(found[path], expected[path], err_msg=path)


@pytest.mark.parametrize("example", EXAMPLES)
def test_a_case_is_estimated_as_it_is_run(example, tmp_path):
    path, settings = EXAMPLES_FOLDER / example, EXAMPLES[example]
    expected = kf.run(path, set=settings, progress=False)
    case = kf.read_case(path, set=settings, progress=False)
    assert_same(kf.estimate(case.structure, case.t, case.y, **case.estimate, progress=False), expected)
    text = kf.to_case(case.structure, case.t, case.y, estimate=case.estimate, title=case.title, file=tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == text
    assert_same(kf.run(tmp_path / "again.yaml", progress=False), expected)


def test_an_updating_comes_back_the_same(tmp_path):
    path = EXAMPLES_FOLDER / "start/plate/case.yaml"
    expected = kf.run(path, steps="update", progress=False)
    case = kf.read_case(path, progress=False)
    kf.to_case(case.structure, update=case.update, file=tmp_path / "again.yaml")
    again = kf.run(tmp_path / "again.yaml", steps="update", progress=False)
    found = kf.update(case.structure, **case.update, progress=False)
    for name, parameter in expected.parameters.items():
        assert found.parameters[name].value == again.parameters[name].value == parameter.value


def test_a_read_case_shows_what_it_holds():
    case = kf.read_case(EXAMPLES_FOLDER / "start/measured/case.yaml", set={"record.end": "2 s"}, progress=False)
    assert case.left_out == ["validate"]
    assert case.estimate["settle"] == 1.0
    assert case.estimate["unknown"]["sensors.body.delay"] == {"initial": 0.0, "std": 0.01}
    assert "substeps" not in case.estimate
    assert "Structure(" in repr(case) and "samples" in repr(case)
    assert case.structure.value("suspension.k") == 15000.0


def test_only_a_file_has_samples_beside_it():
    s = kf.Structure().add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0)).force("hammer", "m.1")
    t = np.arange(200) / 250
    sensors = {"a": kf.acceleration("m.1", noise=0.05)}
    push = np.sin(20 * t)
    y = kf.simulate(s, t, sensors=sensors, inputs={"hammer": push}, seed=1, progress=False)
    with pytest.raises(kf.InvalidInput, match="samples in memory go to"):
        kf.to_case(s, t, y, inputs={"hammer": push}, estimate={"sensors": sensors})
    with pytest.raises(kf.InvalidInput, match="input 'hammer' has no signal"):
        kf.to_case(s)
    with pytest.raises(kf.InvalidInput, match="there is no argument 'unknowns'.*did you mean 'unknown'"):
        kf.to_case(s, t, y, estimate={"sensors": sensors, "unknowns": {}})


def test_functions_of_python_are_refused_by_name():
    s = kf.Structure().add(kf.lumped("m").mass("1", 2.0))
    s.connect("own", "ground", "m.1", law=np.arctan2, parameters={})
    with pytest.raises(kf.InvalidInput, match="connector 'own' has the law 'arctan2' of a program"):
        kf.to_case(s)


def test_a_structure_alone_is_a_text():
    s = kf.Structure().add(kf.chain("body", 2, mass=1.5, stiffness=3e4))
    s.connect("mount", "ground", "body.1", law="k*x + k3*x**3", parameters=dict(k=1e4, k3=1e8))
    text = kf.to_case(s, title="two masses")
    assert "title: two masses" in text and "k*x + k3*x^3" in text
