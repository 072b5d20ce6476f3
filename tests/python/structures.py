# SPDX-License-Identifier: Apache-2.0
"""The chain of the examples, built in Python, and a record of it."""

import functools

import numpy as np

import kalfem as kf

RATE = 500.0
LAW = dict(k=5e3, mu_k1=20.0, mu_k2=2e-3, c=10.0, mu_c1=10.0, mu_c2=0.05)
SENSORS = {"a3": kf.acceleration("body.2", noise=0.3), "a5": kf.acceleration("body.4", noise=0.3)}
UNKNOWN = {"suspension.mu_k1": (10.0, 5.0)}


def chain(masses=4, law="saturating", parameters=LAW):
    """A wheel on a moving ground, a suspension, and a body of some masses."""
    s = kf.Structure()
    s.add(kf.lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4))
    s.add(kf.chain("body", masses, mass=1.0, stiffness=3e4).modal_damping(0.01))
    s.connect("suspension", "wheel.w", "body.1", law=law, parameters=parameters)
    return s.base_displacement("road", "wheel.ground")


def road(t):
    """Sines from 0.7 to 20 Hz [m], zero at first."""
    waves = [np.sin(2 * np.pi * f * t + f) - np.sin(f) for f in (0.7, 1.9, 3.1, 5.3, 7.7, 11.3, 19.0)]
    return 1e-3 * np.sum(waves, axis=0) * np.minimum(1, t / 0.2)


@functools.lru_cache(maxsize=None)
def record(samples=1001):
    """Time, road and measurements with noise."""
    t = np.arange(samples) / RATE
    return t, road(t), kf.simulate(chain(), t, sensors=SENSORS, inputs={"road": road(t)}, seed=1, progress=False)
