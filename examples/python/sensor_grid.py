# SPDX-License-Identifier: Apache-2.0
# Which accelerometers identify the suspension? Every pair of masses of the chain, each on the same record of motion;
# the stated standard deviations compare the pairs. No measurement is needed for that: the design comes before the test.

# %% Every pair of places
import itertools

import matplotlib.pyplot as plt
import numpy as np

import kalfem as kf

places = [1, 2, 3, 4, 6, 8, 10]
pairs = list(itertools.combinations(places, 2))


def sensors(pair):
    return {f"a{place}": {"acceleration": f"body.{place}", "noise": "0.5 m/s^2"} for place in pair}


fixed = {"simulate.duration": "4 s", "estimate.settle": "1 s"}
runs = kf.map("examples/chain/chain.yaml", [{"sensors": sensors(pair), **fixed} for pair in pairs])

# %% Standard deviation of both parameters, in per cent of their values
parameters = ["suspension.mu_k1", "suspension.mu_c1"]
found = [[run.parameters[name] for name in parameters] for run in runs]
percent = np.array([[100 * each.std / each.truth for each in pair] for pair in found])
order = np.argsort(percent.max(axis=1))
for i in order[:3]:
    print(f"body.{pairs[i][0]} and body.{pairs[i][1]}: {percent[i, 0]:.3f} % and {percent[i, 1]:.3f} %")
print(f"the worst pair is body.{pairs[order[-1]][0]} and body.{pairs[order[-1]][1]}: {percent[order[-1]].max():.3f} %")

# %% A map of the pairs
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for ax, name, column in zip(axes, parameters, percent.T):
    table = np.full((len(places), len(places)), np.nan)
    for (first, second), value in zip(pairs, column):
        table[places.index(first), places.index(second)] = table[places.index(second), places.index(first)] = value
    image = ax.imshow(table, origin="lower", cmap="viridis_r")
    ax.set_xticks(range(len(places)), places)
    ax.set_yticks(range(len(places)), places)
    ax.set(title=f"std of {name} [%]", xlabel="first sensor on body.", ylabel="second sensor on body.")
    figure.colorbar(image, ax=ax)
figure.savefig("sensor_grid.png", dpi=120)
