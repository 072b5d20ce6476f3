# SPDX-License-Identifier: Apache-2.0
# The chain of examples/chain: two parameters of a nonlinear suspension from four accelerations.
# Run it from the folder of the project.

# %% Simulate, estimate and predict, as the case says
import kalfem as kf

run = kf.run("examples/chain/chain.yaml", set={"simulate.duration": "10 s"})
print(run)

# %% Whether to trust the numbers
print(run.verdict)
for name, found in run.parameters.items():
    error = abs(found.value - found.truth) / found.std
    print(f"{name}: {found.value:.2f} {found.unit}, 95 % from {found.interval[0]:.2f} to {found.interval[1]:.2f}")
    print(f"  the record was made with {found.truth:g} {found.unit}: {error:.1f} standard deviations away")

# %% The motion of a mass without a sensor, beside the truth
y = run["estimate/body.3/displacement"]
truth = run["truth/body.3/displacement"]
late = y.t > 2.0
print(f"error of body.3: {1e6 * (y - truth)[late].std():.1f} um, the filter expects {1e6 * y.std[late].mean():.1f} um")

# %% Plots, tables, a report
run.plot().savefig("chain.png", dpi=120)
run.plot("law").savefig("law.png", dpi=120)
run.report("chain.html")
print(run.parameters.to_pandas())
