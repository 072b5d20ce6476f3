# SPDX-License-Identifier: Apache-2.0
"""The posterior in results.h5, as xarray and ArviZ read it: groups with the dimensions chain and draw."""

import h5netcdf
import numpy as np
import pytest
import xarray

import kalfem as kf

CASE = """
kalfem: 1
title: one mass
substructures: {body: {masses: {m: 2 kg}}}
connectors:
  mount: {from: ground, to: body.m, law: linear, parameters: {k: 800 N/m, c: 4 N s/m}}
excitation: {push: {force: body.m, random: {rms: 5 N, band: [0.5, 8 Hz], seed: 3}}}
sensors: {a: {acceleration: body.m, noise: 5 %}}
simulate: {duration: 2 s, sample_rate: 100 Hz, seed: 2}
estimate: {unknown: {mount.k: {initial: 700 N/m, std: 100 N/m}, mount.c: {initial: 3 N s/m, std: 1 N s/m}}}
infer: {method: METHOD, samples: 200, predictions: 10, profile: mount.k}
"""


@pytest.fixture(scope="module", params=["importance", "metropolis"])
def run(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("posterior")
    (folder / "case.yaml").write_text(CASE.replace("METHOD", request.param))
    return kf.run(folder / "case.yaml", out=folder / "out", progress=False), folder / "out"


def test_groups_have_chains_and_draws(run):
    in_memory, folder = run
    for group in ("posterior", "sample_stats"):
        with xarray.open_dataset(folder / "results.h5", group=group, engine="h5netcdf") as data:
            assert all(variable.dims == ("chain", "draw") for variable in data.data_vars.values())
            assert np.array_equal(data.chain, range(data.sizes["chain"]))
            assert np.array_equal(data.draw, range(data.sizes["draw"]))
            for name, variable in data.data_vars.items():
                assert np.array_equal(variable, in_memory[f"{group}/{name}"])


def test_every_group_of_the_file_can_be_opened(run):
    """As ArviZ does to make its InferenceData."""
    _, folder = run
    with h5netcdf.File(folder / "results.h5", "r") as file:
        groups = list(file.groups)
    assert {"posterior", "sample_stats", "measurements", "predictive"} <= set(groups)
    for group in [*groups, "estimate/body.m"]:
        with xarray.open_dataset(folder / "results.h5", group=group, engine="h5netcdf") as data:
            data.load()
            assert group != "measurements" or data["a"].dims == ("time",)


def test_moments_are_those_of_the_summary(run):
    in_memory, folder = run
    stated = in_memory.summary["inference"]["parameters"]
    with xarray.open_dataset(folder / "results.h5", group="posterior", engine="h5netcdf") as data:
        assert set(data.data_vars) == set(stated) == {"mount.k", "mount.c"}
        for name, variable in data.data_vars.items():
            assert abs(float(variable.mean()) - stated[name]["mean"]) < 0.1 * stated[name]["std"]
            assert abs(float(variable.std()) / stated[name]["std"] - 1) < 0.15
            assert variable.attrs["unit"] == stated[name]["unit"]


def test_a_folder_has_what_memory_has(run):
    in_memory, folder = run
    written = kf.read_results(folder)
    groups = ("posterior/", "sample_stats/", "profile/", "predictive/")
    paths = {path for path in written.keys() if path.startswith(groups)}
    assert {"posterior/mount.k", "sample_stats/lp", "profile/mount.k/value", "predictive/a/mean"} <= paths
    for path in paths:
        assert np.array_equal(written[path], in_memory[path], equal_nan=True), path
