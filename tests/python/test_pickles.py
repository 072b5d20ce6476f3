# SPDX-License-Identifier: Apache-2.0
"""What is pickled and copied is the same on the other side: in another process, to the last bit."""

import copy
import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

import kalfem as kf

EXAMPLES_FOLDER = Path(__file__).parents[2] / "examples"

T = np.arange(400) / 400
PUSH = 20 * np.sin(2 * np.pi * (2 + 8 * T) * T)


def stiffening(x, v, k, k3, c):
    """A law of this module: a pickle names it."""
    return k * x + k3 * x**3 + c * v


def machine():
    """All kinds of parts: masses, matrices, laws by name, formula and function, samples of inputs."""
    s = kf.Structure()
    s.add(kf.chain("arm", 3, mass=1.0, stiffness=1e4, damping=2.0).modal_damping([0.01]))
    s.add(kf.lumped("block", M=np.diag([2.0, 1.0]), K=np.array([[2e3, -1e3], [-1e3, 1e3]])))
    s.connect("foot", "ground", "arm.1", law=stiffening, parameters=dict(k=1e4, k3=1e7, c=3.0))
    s.connect("joint", "arm.3", "block.1", law="linear", parameters=dict(k=5e3, c=1.0))
    s.connect("stay", "ground", "block.2", law="k*x + c*v", parameters=dict(k=5e3, c=1.0))
    return s.force("push", "arm.2", PUSH, sample_rate=400.0)


SENSORS = {
    "a": kf.acceleration("arm.3", noise=0.05, chain=[kf.low_pass(150.0, order=2), kf.delay(1e-3), kf.gain(2.0)]),
    "d": kf.displacement({"arm.1": 1.0, "block.1": -1.0}, noise="1 %"),
}


def estimated(structure, sensors, record):
    run = kf.estimate(structure, T, record, sensors=sensors, unknown={"joint.k": (6e3, "20 %")}, substeps=1,
                      diagnose=False, progress=False)
    return {path: np.asarray(run[path]) for path in run.keys()}, run.parameters["joint.k"].value


@pytest.fixture(scope="module")
def record():
    return kf.simulate(machine(), T, sensors=SENSORS, seed=1, progress=False)


def test_an_estimation_in_another_process_is_the_same(record):
    series, value = estimated(machine(), SENSORS, record)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there, value_there = pool.apply(estimated, (machine(), SENSORS, record))
    assert value_there == value
    assert there.keys() == series.keys()
    for path in series:
        np.testing.assert_array_equal(there[path], series[path], err_msg=path)


def test_copies_are_independent():
    s = machine()
    for other in (copy.deepcopy(s), copy.copy(s), s.copy(), pickle.loads(pickle.dumps(s))):
        assert repr(other) == repr(s) == "Structure(2 bodies, 3 connectors, 1 input)"
        assert other.parameters == s.parameters
        other.add(kf.lumped("rider").mass("1", 1.0))
        assert "rider.1.mass" not in s.parameters
        again = pickle.loads(pickle.dumps(other))
        assert again.parameters == other.parameters


def test_parts_and_values_are_kept_as_they_were():
    samples = PUSH.copy()
    part = kf.lumped("m").mass("1", 2.0)
    s = kf.Structure().add(part).force("f", "m.1", samples, sample_rate=400.0)
    samples[:] = 0.0
    part.mass("2", 1.0)
    moved = pickle.loads(pickle.dumps(s.at({"m.1.mass": 3.0})))
    assert moved.value("m.1.mass") == 3.0 and "m.2.mass" not in moved.parameters
    assert pickle.loads(pickle.dumps(part)).name == "m"
    y = kf.simulate(pickle.loads(pickle.dumps(s)), T, sensors={"a": kf.acceleration("m.1")}, progress=False)
    assert np.abs(y["a"]).max() > 1.0


def test_functions_without_a_name_are_refused_as_python_does():
    s = kf.Structure().add(kf.lumped("m").mass("1", 2.0))
    s.connect("own", "ground", "m.1", law=lambda x, v: x, parameters={})
    with pytest.raises((pickle.PicklingError, AttributeError), match="lambda"):
        pickle.dumps(s)


def test_sensors_come_back():
    for sensor in (*SENSORS.values(), kf.force("joint"), kf.strain("frame.g", noise=1e-6), kf.velocity("arm.1", relative=True)):
        again = pickle.loads(pickle.dumps(sensor))
        assert (again.noise, again.unit, again.points, repr(again)) == (sensor.noise, sensor.unit, sensor.points, repr(sensor))
    assert repr(SENSORS["d"]) == "Sensor(displacement of arm.1 + -1 block.1, noise 1 %)"
    pickle.loads(pickle.dumps(kf.resonance(1000.0)))


def test_structures_of_cases_and_decks_read_their_files_again(tmp_path):
    case = kf.read_case(EXAMPLES_FOLDER / "start/chain/case.yaml", set={"simulate.duration": "1 s"}, progress=False)
    again = pickle.loads(pickle.dumps(case))
    assert again.structure.parameters == case.structure.parameters
    run = [kf.estimate(each.structure, each.t, each.y, **{**each.estimate, "diagnose": False}, progress=False) for each in (case, again)]
    assert run[0].parameters["suspension.k"].value == run[1].parameters["suspension.k"].value
    assert copy.deepcopy(case).structure.parameters == case.structure.parameters


def test_results_come_back(record):
    s = machine()
    run = kf.estimate(s, T, record, sensors=SENSORS, unknown={"joint.k": (6e3, "20 %")}, substeps=1, diagnose=False,
                      progress=False)
    for result in (run, run.parameters, run.verdict, run.residuals, record, kf.modes(s, 3),
                   kf.frequency_responses(s, np.linspace(1, 40, 20), ["push"], {"a": kf.acceleration("arm.3")}, progress=False),
                   kf.MeasuredModes("arm", [10.0], std=0.1)):
        assert type(pickle.loads(pickle.dumps(result))) is type(result)
        copy.deepcopy(result)
    again = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(again["estimate/arm.1/displacement"], run["estimate/arm.1/displacement"])
