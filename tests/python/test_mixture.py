# SPDX-License-Identifier: Apache-2.0
"""Several models of one record as one."""

import numpy as np
import pytest

import kalfem as kf

T = np.arange(300) / 100.0
NOISE = 1e-3


def body(damping):
    return kf.Structure().add(kf.lumped("body").mass("m", 2.0).spring("k", "ground", "m", 800.0, damping))


def motion(damping):
    """A mass that is let go from 5 mm, without the library."""
    delta = 0.25 * damping
    w = np.sqrt(400.0 - delta**2)
    return 5e-3 * np.exp(-delta * T) * (np.cos(w * T) + delta / w * np.sin(w * T))


Y = motion(4.0) + NOISE * np.random.default_rng(3).normal(size=len(T))


def estimated(damping, y=Y):
    return kf.estimate(
        body(damping),
        T[: len(y)],
        {"x": y},
        sensors={"x": kf.displacement("body.m", noise=NOISE)},
        outputs={"speed": kf.velocity("body.m")},
        unknown={"body.k.stiffness": (780.0, 40.0)},
        initial_state={"body.m": {"displacement": 5e-3, "displacement_std": 1e-4}},
        diagnose=False,
        progress=False,
    )


def test_is_that_by_hand():
    runs = {"light": estimated(3.6), "right": estimated(4.0)}
    mixed = kf.mixture(runs)
    a, b = (run.summary["estimation"]["log_likelihood"] for run in runs.values())
    weight = 1.0 / (1.0 + np.exp(b - a))
    assert 0.01 < weight < 0.99  # both matter
    assert mixed.weights["light"] == pytest.approx(weight, rel=1e-9)
    assert sum(mixed.weights.values()) == pytest.approx(1.0)
    path = "estimate/body.m/velocity"
    light, right = (run[path] for run in runs.values())
    spread = weight * light.std**2 + (1 - weight) * right.std**2 + weight * (1 - weight) * np.asarray(light - right) ** 2
    np.testing.assert_allclose(mixed[path], weight * np.asarray(light) + (1 - weight) * np.asarray(right), rtol=1e-12)
    np.testing.assert_allclose(mixed[path].std, np.sqrt(spread), rtol=1e-9)
    assert mixed[path].unit == light.unit and len(mixed[path].t) == len(T)
    assert "light" in repr(mixed)


def test_of_one_run_is_that_run():
    run = estimated(4.0)
    mixed = kf.mixture({"only": run})
    assert mixed.weights == {"only": 1.0}
    np.testing.assert_allclose(mixed["estimate/body.m/displacement"].std, run["estimate/body.m/displacement"].std)


def test_refuses_what_cannot_be_weighed():
    with pytest.raises(kf.InvalidInput, match="ran to its end"):
        kf.mixture({})
    with pytest.raises(kf.InvalidInput, match="different numbers of samples"):
        kf.mixture({"long": estimated(4.0), "short": estimated(4.0, Y[:299])})
