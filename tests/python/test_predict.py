# SPDX-License-Identifier: Apache-2.0
"""kf.predict beside the command's `predict`, and beside the simulation that its record is from."""

import numpy as np
import pytest

import kalfem as kf
from structures import SENSORS, UNKNOWN, chain, record
from test_validate import CASE, chain_on, write

PREDICTION = "predict: {substructure: body}\n"


@pytest.fixture(scope="module")
def measured():
    return record()


def test_it_gives_what_the_case_gives(measured, tmp_path):
    t, drive, y = measured
    write(tmp_path, t, drive, y)
    case = CASE.format(validate="")
    case = case.replace("validate: {}\n", PREDICTION).replace(", end: 1.2 s", "")
    (tmp_path / "case.yaml").write_text(case)
    run = kf.run(tmp_path / "case.yaml", progress=False)
    found = kf.predict(chain_on(drive), t, y, "body", sensors=SENSORS, unknown=UNKNOWN, substeps=4, progress=False)
    assert found.parameters["suspension.mu_k1"].value == pytest.approx(run.parameters["suspension.mu_k1"].value, rel=1e-9)
    paths = [path for path in run.keys() if path.startswith("prediction/")]
    assert len(paths) == 8 and set(paths) <= set(found.keys())
    for path in paths:
        np.testing.assert_allclose(found[path], run[path], rtol=1e-7, atol=1e-9 * np.abs(run[path]).max())
        assert found[path].unit == run[path].unit


def test_the_motion_that_was_not_measured(measured):
    t, drive, y = measured
    arguments = dict(sensors=SENSORS, inputs={"road": drive}, progress=False)
    found = kf.predict(chain(), t, y, "body", unknown=UNKNOWN, **arguments)
    wanted = {"x": kf.displacement("body.3"), "a": kf.acceleration("body.3")}
    truth = kf.simulate(chain(), t, sensors=wanted, inputs={"road": drive}, progress=False)
    for name, path in [("x", "prediction/body.3/displacement"), ("a", "prediction/body.3/acceleration")]:
        assert np.linalg.norm(found[path] - truth[name]) < 0.05 * np.linalg.norm(truth[name])
    assert found["prediction/body.3/displacement"].t is not None and found.usable


def test_wrong_arguments_are_named(measured):
    t, drive, y = measured
    with pytest.raises(kf.InvalidInput) as refused:
        kf.predict(chain(), t, y, "bodi", sensors=SENSORS, inputs={"road": drive}, steps=0)
    words = str(refused.value)
    assert "substructure: there is no 'bodi' (did you mean 'body'?)" in words and "steps: 0" in words
    with pytest.raises(kf.InvalidInput, match="substructure: "):
        kf.predict(chain(), t, y, "wheel", sensors=SENSORS, inputs={"road": drive})
