# SPDX-License-Identifier: Apache-2.0
"""Decks with the values of an updating: what a run writes, and kf.write_updated_deck."""

import csv
import json
import shutil
from pathlib import Path

import pytest

import kalfem as kf

PLATE = Path(__file__).parents[2] / "examples" / "start" / "plate"


def changed_lines(file, other):
    before, after = other.read_text().splitlines(), file.read_text().splitlines()
    assert len(before) == len(after)
    return [(a, b) for a, b in zip(before, after) if a != b]


def test_a_run_writes_the_deck(tmp_path):
    shutil.copytree(PLATE, tmp_path / "plate")
    kf.run(tmp_path / "plate" / "case.yaml", out=tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    (deck,) = summary["updating"]["decks"]
    written = tmp_path / "out" / deck["file"]
    ((before, after),) = changed_lines(written, PLATE / "plate.bdf")
    (change,) = deck["changes"]
    assert change["card"] == "MAT1 1" and change["before"] == "2.1+11"
    assert after == before.replace("2.1+11", change["after"])
    estimate = summary["updating"]["parameters"]["plate.mat1.youngs_modulus"]["estimate"]
    assert float(change["after"]) == pytest.approx(estimate, rel=1e-12)
    assert [left["parameter"] for left in deck["unwritten"]] == ["plate.tip.mass"]
    rows = list(csv.DictReader((tmp_path / "out" / "updated_decks" / "changes.csv").open()))
    assert [row["parameter"] for row in rows] == ["plate.mat1.youngs_modulus", "plate.tip.mass"]
    assert {"updated_decks/changes.csv", deck["file"]} <= set(summary["files"])


def test_write_updated_deck(tmp_path):
    made = kf.write_updated_deck(
        PLATE / "plate.bdf",
        {"mat1.youngs_modulus": 2.0512345e11, "pshell1.thickness": 4.1e-3, "tip.mass": 1.0},
        tmp_path,
    )
    assert Path(made["file"]) == tmp_path / "plate.bdf"
    assert sorted(change["after"] for change in made["changes"]) == [".0041", "2.0512345+11"]
    assert [left["parameter"] for left in made["unwritten"]] == ["tip.mass"]
    assert len(changed_lines(Path(made["file"]), PLATE / "plate.bdf")) == 2


def test_nothing_to_write(tmp_path):
    made = kf.write_updated_deck(PLATE / "plate.bdf", {"mat1.youngs_modulus": 2.1e11}, tmp_path / "out")
    assert made == {"file": None, "changes": [], "unwritten": []}
    assert not (tmp_path / "out").exists()
