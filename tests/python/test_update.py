# SPDX-License-Identifier: Apache-2.0
"""kf.update by static deflections, frequency responses, modes with shapes, and records."""

import numpy as np
import pytest

import kalfem as kf
from structures import SENSORS, chain, record

TRUTH = {"t.k1.stiffness": 3e3, "t.k2.stiffness": 1e3}
NAMES = list(TRUTH)


def tower(k1=3e3, k2=1e3):
    t = kf.lumped("t").mass("1", 2.0).mass("2", 1.0).spring("k1", "ground", "1", k1, 4.0).spring("k2", "1", "2", k2, 2.0)
    return kf.Structure().add(t)


def expect_truth(run, rel=1e-6):
    assert run.summary["updating"]["converged"] and run.usable
    for name, value in TRUTH.items():
        assert run.parameters[name].value == pytest.approx(value, rel=rel)


def test_static_deflections():
    pull = kf.MeasuredDeflections({"t.2": "10 N"}, {"t.1": 1e-2 / 3, "t.2": 1e-2 / 3 + 1e-2}, std="0.01 mm")
    run = kf.update(tower(2.5e3, 1.2e3), parameters=NAMES, compare={"pull": pull}, progress=False)
    expect_truth(run)
    assert run.parameters["t.k1.stiffness"].std == pytest.approx(1e-5 * 3e3**2 / 10, rel=1e-3)
    assert run.summary["updating"]["comparisons"]["pull"]["size"] == 2


def test_frequency_responses():
    f = np.linspace(1, 13, 120)
    outputs = {"a1": kf.acceleration("t.1"), "a2": kf.acceleration("t.2")}
    taps = kf.MeasuredResponses("t.2", f, outputs, kf.frf(tower(), f, "t.2", outputs))
    run = kf.update(tower(2.6e3, 1.1e3), parameters=NAMES, compare={"taps": taps}, progress=False)
    expect_truth(run)
    rms = run.summary["updating"]["comparisons"]["taps"]
    assert rms["rms_initial"] > 1 > rms["rms_final"]


def test_modes_with_shapes():
    found = kf.modes(tower())
    given = dict(substructure="t", frequencies=found.frequencies[::-1], std=0.01, points=["t.1", "t.2"])
    measured = kf.MeasuredModes(**given, shapes=-3 * found.shapes[:, ::-1])
    run = kf.update(tower(2.5e3, 1.2e3), parameters=NAMES, compare={"modes": measured}, progress=False)
    expect_truth(run)
    np.testing.assert_allclose(run["updating/frequencies/after"], found.frequencies[::-1], rtol=1e-6)


def test_a_record():
    t, drive, y = record()
    ride = kf.MeasuredRecord(t, y, SENSORS, inputs={"road": drive}, settle=0.1)
    s = chain().at({"body.2-3.stiffness": 2.8e4})
    run = kf.update(s, parameters=["body.2-3.stiffness"], compare={"ride": ride}, progress=False)
    k = run.parameters["body.2-3.stiffness"]
    assert abs(k.value - 3e4) < 3 * k.std < 0.1 * 3e4
    assert run.summary["updating"]["comparisons"]["ride"]["rms_final"] == pytest.approx(1, abs=0.1)


def test_wrong_descriptions_are_named():
    s = tower()
    with pytest.raises(kf.InvalidInput, match=r"compare\['a'\]: 3 is given"):
        kf.update(s, parameters=NAMES, compare={"a": 3})
    pull = kf.MeasuredDeflections({"t.2": 1.0}, {"t.22": 1e-3}, std=1e-5)
    taps = kf.MeasuredResponses("t.1", [1.0], {"a": kf.acceleration("u.1")}, {"a": [1.0]})
    with pytest.raises(kf.InvalidInput) as refused:
        kf.update(s, parameters=NAMES, compare={"pull": pull, "taps": taps})
    assert "'pull': there is no point '22'" in str(refused.value) and "'u.1' is not a point of 't'" in str(refused.value)
    with pytest.raises(kf.InvalidInput, match=r"values\['a'\] is missing"):
        kf.update(s, parameters=NAMES, compare={"x": kf.MeasuredResponses("t.1", [1.0], {"a": kf.acceleration("t.1")}, {})})
    with pytest.raises(kf.InvalidInput, match="frequencies: the list is empty"):
        kf.update(s, "t", parameters=NAMES)


def test_modes_have_a_posterior():
    """With errors this small it is about the normal distribution that the updating states.

    Not so of ``tower()`` itself, whose two frequencies move alike by both springs.
    """
    stiff = tower(6e3)
    found = kf.modes(stiff)
    measured = kf.MeasuredModes("t", found.frequencies, std=0.01, points=["t.1", "t.2"], shapes=found.shapes)
    start = {"t.k1.stiffness": (6.6e3, 1.8e3), "t.k2.stiffness": (1.1e3, 300.0)}
    run = kf.update(stiff, parameters=start, compare={"modes": measured}, progress=False)
    posterior = kf.infer_comparisons(stiff, start, {"modes": measured}, progress=False)
    assert posterior.names == NAMES
    for name, mean, std in zip(NAMES, posterior.mean, posterior.std):
        assert abs(mean - run.parameters[name].value) < 0.5 * std
        assert std == pytest.approx(run.parameters[name].std, rel=0.2)
    with pytest.raises(kf.InvalidInput, match="prior"):
        kf.infer_comparisons(tower(), NAMES, {"modes": measured}, progress=False)
