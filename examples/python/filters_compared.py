# SPDX-License-Identifier: Apache-2.0
# Filters compared on the chain over 40 records, which differ in their noise: how far are the estimates from the truth,
# in the standard deviations that each filter states, and what does a step cost?

# %% Every filter on every record
import numpy as np
import matplotlib.pyplot as plt

import kalfem as kf

filters = ["partially_linear_ukf", "partially_linear_ukf_square_root", "ukf", "ukf_square_root", "ekf"]
grid = {"estimate.filter": filters, "simulate.seed": range(1, 41), "simulate.duration": "4 s", "estimate.settle": "1 s"}
runs = kf.map("examples/chain/chain.yaml", grid)

# %% Errors over stated deviations: of size one if the filter is right about itself
parameters = ["suspension.mu_k1", "suspension.mu_c1"]


def errors(name, parameter):
    found = [run.parameters[parameter] for run in runs if run and run.settings["estimate.filter"] == name]
    return np.array([(each.value - each.truth) / each.std for each in found])


def median_of(name, key):
    return np.median([run.summary["timing"][key] for run in runs if run and run.settings["estimate.filter"] == name])


for name in filters:
    rms = [np.sqrt(np.mean(errors(name, parameter) ** 2)) for parameter in parameters]
    cost = median_of(name, "estimate_us_per_step")
    print(f"{name:33} rms error {rms[0]:.2f} and {rms[1]:.2f} standard deviations, {cost:6.1f} us a step")

# %% A plot
figure, axes = plt.subplots(1, 3, figsize=(13, 4), sharey=True, layout="constrained")
for ax, parameter in zip(axes, parameters):
    ax.boxplot([errors(name, parameter) for name in filters], vert=False, labels=filters)
    ax.axvspan(-2, 2, color="tab:green", alpha=0.15)
    ax.set_xlabel(f"error of {parameter} [std]")
axes[2].barh(range(1, len(filters) + 1), [median_of(name, "estimate_us_per_step") for name in filters])
axes[2].set_xlabel("time of a step [us]")
figure.savefig("filters_compared.png", dpi=120)
