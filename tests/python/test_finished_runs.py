# SPDX-License-Identifier: Apache-2.0
"""Finished runs side by side: the words, numbers and page of the command."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import kalfem as kf

CHAIN = Path(__file__).parents[2] / "examples/start/chain/case.yaml"


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Three short runs: two filters of one record, and another record."""
    place = tmp_path_factory.mktemp("runs")
    settings = {"ukf": {}, "ekf": {"estimate.filter": "ekf"}, "other": {"simulate.seed": 9}}
    for name, set in settings.items():
        kf.run(CHAIN, set={"simulate.duration": "4 s", **set}, out=place / name, progress=False)
    return {name: place / name for name in settings}


def of_command(*words):
    return subprocess.run([sys.executable, "-m", "kalfem", "compare", *words], capture_output=True, text=True)


def test_says_what_the_command_says(folders):
    found = kf.compare_runs([folders["ukf"], folders["ekf"]])
    told = of_command(folders["ukf"], folders["ekf"])
    assert str(found) == repr(found) == told.stdout
    assert "The cases differ in: estimate." in told.stdout
    assert found.warnings == []
    assert found.summary == json.loads(of_command(folders["ukf"], folders["ekf"], "--json").stdout)


def test_warns_where_the_records_differ(folders):
    found = kf.compare_runs(list(folders.values()))
    told = of_command(*folders.values()).stderr.splitlines()
    assert len(found.warnings) == 1 and "do not rest on the same data" in found.warnings[0]
    assert told == [f"warning: {warning}" for warning in found.warnings]


def test_members_of_a_population(folders):
    members = [folders["ukf"], folders["other"]]
    found = kf.compare_runs(members, population=True)
    told = of_command(*members, "--population")
    assert str(found) == told.stdout and found.warnings == []
    assert "the next member" in told.stdout and "Members:" in told.stdout
    for population in found.summary["population"].values():
        low, high = population["next"]["interval"]
        assert low < population["mean"]["interval"][0] < population["mean"]["interval"][1] < high
        assert len(population["runs"]) == 2 and population["spread"]["interval"][0] >= 0
    same = kf.compare_runs([folders["ukf"], folders["ekf"]], population=True)
    assert len(same.warnings) == 1 and "data of their own" in same.warnings[0]


def test_writes_the_page_of_the_command(folders, tmp_path):
    kf.compare_runs([folders["ukf"], folders["ekf"]]).report(tmp_path / "here.html")
    assert of_command(folders["ukf"], folders["ekf"], "--page", tmp_path / "there.html").returncode == 0
    assert (tmp_path / "here.html").read_bytes() == (tmp_path / "there.html").read_bytes()


def test_what_cannot_be_compared_is_refused_together(folders, tmp_path):
    with pytest.raises(kf.InvalidInput, match="at least two"):
        kf.compare_runs(folders["ukf"])
    with pytest.raises(kf.InvalidInput, match="no folder given"):
        kf.compare_runs([])
    with pytest.raises(kf.InvalidInput) as refused:
        kf.compare_runs([tmp_path / "a", folders["ukf"], tmp_path / "b"])
    assert len(refused.value.issues) == 2
