# SPDX-License-Identifier: Apache-2.0
"""The likelihood of a case in the hands of another sampler."""

import math
import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import kalfem as kf
from programs import output_under_mpi

CASE = """
kalfem: 1
substructures: {body: {masses: {m: 2 kg}}}
connectors: {mount: {from: ground, to: body.m, law: linear, parameters: {k: 800 N/m, c: 4 N s/m}}}
excitation: {push: {force: body.m, random: {rms: 5 N, band: [0.5, 8 Hz], seed: 3}}}
sensors: {a: {acceleration: body.m, noise: 5 %}}
simulate: {duration: 2 s, sample_rate: 100 Hz, seed: 2}
estimate: {substeps: 2, diagnose: false, unknown: {mount.k: {initial: 780 N/m, std: 50 N/m}, mount.c: {initial: 3 N s/m, std: 1 N s/m}}}
infer: {priors: {mount.c: {uniform: [1, 9]}}, predictions: 0}
"""


MPI_PROGRAM = """
import sys
import kalfem as kf
from mpi4py.futures import MPIPoolExecutor

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        print(repr(kf.Likelihood(sys.argv[1]).sample(samples=100, executor=executor, progress=False).log_evidence))
"""


@pytest.fixture(scope="module")
def likelihood(tmp_path_factory):
    file = tmp_path_factory.mktemp("likelihood") / "case.yaml"
    file.write_text(CASE)
    return kf.Likelihood(file)


def test_knows_its_parameters_and_their_prior(likelihood):
    assert likelihood.names == ["mount.k", "mount.c"]
    assert likelihood.units == ["N/m", "N s/m"]
    assert np.array_equal(likelihood.start, [780.0, 3.0])
    expected = math.log(1.0 / 8.0) - 0.5 * math.log(2.0 * math.pi * 50.0**2) - 0.5 * (20.0 / 50.0) ** 2
    assert likelihood.log_prior([800.0, 4.0]) == pytest.approx(expected, abs=1e-12)
    assert likelihood.log_posterior({"mount.c": 4.0, "mount.k": 800.0}) == likelihood([800.0, 4.0]) + expected
    assert likelihood.log_posterior([800.0, 10.0]) == -math.inf
    assert likelihood.prior_transform([0.5, 0.25]) == pytest.approx([780.0, 3.0], abs=1e-9)


def test_its_evidence_is_that_of_infer(likelihood):
    """By the sum over a grid, which knows nothing of samplers."""
    steps = (0.5, 0.04)
    grid = [(k, c) for k in np.arange(785.0, 817.0, steps[0]) for c in np.arange(2.6, 5.4, steps[1])]
    with ThreadPoolExecutor(2) as executor:
        values = likelihood.map(grid, executor) + [likelihood.log_prior(theta) for theta in grid]
    evidence = values.max() + math.log(np.exp(values - values.max()).sum() * steps[0] * steps[1])
    run = kf.run(likelihood._case, steps="infer", progress=False)
    assert evidence == pytest.approx(run.summary["inference"]["log_evidence"], abs=0.1)


def test_goes_to_other_processes(likelihood):
    thetas = [likelihood.start, [800.0, 4.0]]
    here = likelihood.map(thetas)
    with ProcessPoolExecutor(1) as executor:
        assert np.array_equal(likelihood.map(thetas, executor), here)
    assert np.array_equal(pickle.loads(pickle.dumps(likelihood)).map(thetas), here)


@pytest.mark.parametrize("method", ["importance", "laplace", "tempered", "metropolis"])
def test_samples_are_the_same_wherever_they_are_computed(likelihood, method):
    options = dict(method=method, samples=100, seed=3, progress=False)
    here = likelihood.sample(**options)
    with ProcessPoolExecutor(2) as executor:
        there = likelihood.sample(executor=executor, workers=2, **options)
    assert np.array_equal(here.values, there.values) and np.array_equal(here.weights, there.weights)
    assert here.log_evidence == there.log_evidence and here.evaluations == there.evaluations
    assert abs(here.mean[0] - 800.0) < 6 * here.std[0] + 20.0


def test_samples_over_mpi(likelihood, tmp_path):
    here = likelihood.sample(samples=100, progress=False)
    assert output_under_mpi(MPI_PROGRAM, tmp_path, likelihood._case) == repr(here.log_evidence)


def test_a_worker_that_fails_ends_the_sampling(likelihood):
    class Broken:
        def submit(self, function, theta):
            raise OSError("the worker is gone")

    with pytest.raises(Exception, match="the worker is gone"):
        likelihood.sample(executor=Broken(), progress=False)
    with pytest.raises(kf.InvalidInput, match="there is no 'gibbs'"):
        likelihood.sample(method="gibbs", progress=False)


def test_says_what_is_wrong(likelihood):
    with pytest.raises(kf.InvalidInput, match="3 values for 2 parameters"):
        likelihood([1.0, 2.0, 3.0])
    with pytest.raises(kf.UnknownName, match="mount.k"):
        likelihood({"mount.q": 1.0, "mount.c": 1.0})
    with pytest.raises(kf.InvalidInput, match="no `infer`"):
        kf.Likelihood(likelihood._case, set={"infer": None})
