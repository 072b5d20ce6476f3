# SPDX-License-Identifier: Apache-2.0
"""kf.validate beside the command's `validate`, and beside its definitions."""

import numpy as np
import pytest

import kalfem as kf
from structures import LAW, RATE, SENSORS, UNKNOWN, chain, record, road

CASE = """
kalfem: 1
substructures:
  wheel: {{masses: {{w: 1.5 kg}}, springs: [{{name: k_w, from: ground, to: w, stiffness: 20 kN/m}}]}}
  body:
    masses: {{1: 1 kg, 2: 1 kg, 3: 1 kg, 4: 1 kg}}
    springs:
      - {{name: 1-2, from: 1, to: 2, stiffness: 30 kN/m}}
      - {{name: 2-3, from: 2, to: 3, stiffness: 30 kN/m}}
      - {{name: 3-4, from: 3, to: 4, stiffness: 30 kN/m}}
    damping: {{modal: 1 %}}
connectors:
  suspension:
    from: wheel.w
    to: body.1
    law: saturating
    parameters: {{k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: 10 N, mu_c2: 0.05 m/s}}
excitation:
  road: {{base_displacement: wheel.ground, file: record.csv, channel: road, unit: m}}
sensors:
  a3: {{acceleration: body.2, noise: 0.3 m/s^2}}
  a5: {{acceleration: body.4, noise: 0.3 m/s^2}}
record: {{file: record.csv, end: 1.2 s}}
estimate: {{unknown: {{suspension.mu_k1: {{initial: 10 N, std: 5 N}}}}, substeps: 4}}
validate: {{{validate}}}
"""


def write(folder, t, drive, measured):
    table = np.column_stack([t, drive, measured["a3"], measured["a5"]])
    np.savetxt(folder / "record.csv", table, delimiter=",", header="time,road,a3,a5", comments="", fmt="%.17g")


def chain_on(drive):
    """The chain with its road over the whole record, as the case reads it."""
    s = kf.Structure()
    s.add(kf.lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4))
    s.add(kf.chain("body", 4, mass=1.0, stiffness=3e4).modal_damping(0.01))
    s.connect("suspension", "wheel.w", "body.1", law="saturating", parameters=LAW)
    return s.base_displacement("road", "wheel.ground", drive, sample_rate=RATE)


@pytest.fixture(scope="module")
def measured():
    return record()


def beside_the_case(folder, measured, validate, **options):
    """The case's validation, and that of its estimates on the same part."""
    t, drive, y = measured
    write(folder, t, drive, y)
    (folder / "case.yaml").write_text(CASE.format(validate="start: 1.202 s, " + validate))
    run = kf.run(folder / "case.yaml", progress=False)
    part = t > 1.2
    channels = {name: y[name][part] for name in SENSORS}
    arguments = dict(sensors=SENSORS, values=run.parameters, substeps=4)
    found = kf.validate(chain_on(drive), t[part], channels, **arguments, **options)
    assert found.compared_from == pytest.approx(run.summary["validation_record"]["compared_from_s"], abs=1e-9)
    return run, found


def test_it_gives_what_the_case_gives(measured, tmp_path):
    run, found = beside_the_case(tmp_path, measured, "initial: rest", from_rest=True)
    for sensor, expected in run.summary["validation"].items():
        assert found[sensor].nrmse == pytest.approx(expected["nrmse"], rel=1e-9)
        assert found[sensor].one_step == pytest.approx(expected["one_step_nrmse"], rel=1e-9)
        assert found[sensor].noise == pytest.approx(expected["noise"], rel=1e-9)
        simulated = run[f"validation/{sensor}/simulated"]
        np.testing.assert_allclose(found[sensor].simulated, simulated, rtol=1e-9, atol=1e-9)


def test_from_a_lead_in_it_is_near_the_case(measured, tmp_path):
    """The prior of the initial state is the range of a simulation here, that of the filter's estimate there."""
    run, found = beside_the_case(tmp_path, measured, "lead_in: 0.2 s", lead_in=0.2)
    for sensor, expected in run.summary["validation"].items():
        assert found[sensor].noise == pytest.approx(expected["noise"], rel=1e-9)
        assert found[sensor].one_step == pytest.approx(expected["one_step_nrmse"], rel=0.02)
        assert found[sensor].nrmse == pytest.approx(expected["nrmse"], rel=0.15)
        simulated = run[f"validation/{sensor}/simulated"]
        assert np.abs(found[sensor].simulated - simulated).max() < 0.05 * np.abs(simulated).max()


def test_the_definitions_of_its_errors(measured):
    t, drive, y = measured
    found = kf.validate(chain(), t, y, sensors=SENSORS, inputs={"road": drive}, values={"suspension.mu_k1": "15 N"}, from_rest=True)
    assert found.compared_from == 0.0 and found.usable and found.failure == ""
    truth = kf.simulate(chain().at({"suspension.mu_k1": 15.0}), t, sensors=SENSORS, inputs={"road": drive}, progress=False)
    for name, each in found.items():
        size = np.std(np.asarray(y[name]))
        assert each.nrmse == pytest.approx(np.sqrt(np.mean((each.simulated - y[name]) ** 2)) / size, rel=1e-9)
        assert each.noise == pytest.approx(0.3 / size, rel=1e-9)
        assert np.abs(each.simulated - truth[name]).max() < 0.01 * np.abs(truth[name]).max()
        assert each.measured.unit == "m/s^2" and np.allclose(each.measured.t, t)
    assert "Validation: " in repr(found) and "nrmse=" in repr(found["a3"])
    with pytest.raises(KeyError, match="did you mean 'a3'"):
        found["a33"]


def test_an_estimate_predicts_another_record(measured):
    t, drive, y = measured
    run = kf.estimate(chain(), t, y, sensors=SENSORS, inputs={"road": drive}, unknown=UNKNOWN, progress=False)
    other = 1.5 * road(t + 0.3) - 1.5 * road(np.array([0.3]))
    new = kf.simulate(chain(), t, sensors=SENSORS, inputs={"road": other}, seed=5, progress=False)
    arguments = dict(sensors=SENSORS, inputs={"road": other})
    right = kf.validate(chain(), t, new, values=run.parameters, **arguments)
    wrong = kf.validate(chain(), t, new, values={"body.2-3.stiffness": 3e3}, **arguments)
    assert right.verdict.state == "consistent"
    assert all(each.nrmse < 1.1 * each.noise for each in right.values())
    assert wrong.verdict.reasons[0].code.startswith("validation_error")


def test_wrong_arguments_are_named(measured):
    t, drive, y = measured
    with pytest.raises(kf.InvalidInput) as refused:
        kf.validate(
            chain(), t, y, sensors=SENSORS, inputs={"road": drive}, values={"suspension.mu_k9": 1.0}, lead_in=9.0
        )
    words = str(refused.value)
    assert "values: at 'suspension.mu_k9'" in words and "lead_in: it is 9 s" in words
    with pytest.raises(kf.InvalidInput, match="input 'road' has no signal"):
        kf.validate(chain(), t, y, sensors=SENSORS)
    with pytest.raises(kf.InvalidInput, match="filter: there is no filter 'uk'"):
        kf.validate(chain(), t, y, sensors=SENSORS, inputs={"road": drive}, filter="uk")
