# SPDX-License-Identifier: Apache-2.0
# A live loop: predict with the force just applied, update with the samples just measured, use the estimate at once.

# %% Two masses on springs, and a stop that stiffens: F = k x + k3 x^3
import numpy as np

import kalfem as kf


def two_masses(k3):
    s = kf.Structure()
    table = kf.lumped("table").mass("a", 5.0).mass("b", 3.0)
    s.add(table.spring("foot", "ground", "a", 4e4, 20.0).spring("rod", "a", "b", 2e4, 10.0))
    s.connect("stop", "table.b", "ground", law="k*x + k3*x^3", parameters=dict(k=1e3, k3=k3))
    return s.force("shaker", "table.b")


# %% What the converter would deliver: a stop of 4e8 N/m^3 under a sweep
rate = 500.0
t = np.arange(1500) / rate
force = 30 * np.sin(2 * np.pi * (2 + t) * t)
sensors = {"a": kf.acceleration("table.a", noise=0.1), "b": kf.acceleration("table.b", noise=0.1)}
measured = kf.simulate(two_masses(4e8), t, sensors=sensors, inputs={"shaker": force}, seed=5)

# %% The loop: the filter starts from 2e8 N/m^3, known within 100 %, and stays 8 samples behind its force
live = kf.Filter(two_masses(2e8), rate, sensors=sensors, unknown={"stop.k3": (2e8, "100 %")})
for k, sample in enumerate(np.column_stack([measured["a"], measured["b"]])):
    if k > 0:
        live.predict({"shaker": force[k]})
    live.update(sample)
    if k % 300 == 0:
        b, k3 = live.state("table.b.displacement"), live.parameters["stop.k3"]
        print(f"{live.time:4.1f} s: b at {1e3 * b.value:6.3f} +- {1e3 * b.std:.3f} mm, k3 = {1e-8 * k3.value:.3f}e8 N/m^3")

live.flush()  # the last samples, which wait for the force after them

# %% The same from blocks that come late and out of order, as from a network
late = kf.Filter(two_masses(2e8), rate, sensors=sensors, unknown={"stop.k3": (2e8, "100 %")}, horizon=1.0)
for first in range(0, len(t), 100):
    block = slice(first, first + 100)
    for name, values in [("b", measured["b"]), ("shaker", force), ("a", measured["a"])]:
        late.push(name, t[block], values[block])
late.flush()
same = np.isclose(late.parameters["stop.k3"].value, live.parameters["stop.k3"].value, rtol=1e-9)
print("same estimate:", same)
