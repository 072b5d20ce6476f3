# SPDX-License-Identifier: Apache-2.0
"""Estimates: arguments of every form, results, and the errors that name them."""

import pickle
import threading
import time

import numpy as np
import pytest

import kalfem as kf
from structures import RATE, SENSORS, UNKNOWN, chain, record


def estimate(y=None, structure=None, **changes):
    t, u, data = record()
    arguments = dict(sensors=SENSORS, inputs={"road": u}, unknown=UNKNOWN, substeps=4, progress=False)
    return kf.estimate(structure or chain(), t, data if y is None else y, **{**arguments, **changes})


def test_finds_the_parameter_and_says_how_well():
    run = estimate()
    found = run.parameters["suspension.mu_k1"]
    assert abs(found.value - 20.0) < 4 * found.std
    assert found.interval[0] < found.value < found.interval[1] and found.unit == "N"
    assert run.verdict.state == "consistent" and run.usable
    motion = run["estimate/body.3/displacement"]
    assert motion.unit == "m" and len(motion) == 1001 and motion.t[-1] == pytest.approx(2.0)
    assert np.all(motion.std[10:] > 0)
    assert run["estimate/parameters/suspension.mu_k1"][-1] == found.value


def test_residuals_have_their_covariance():
    residuals = estimate().residuals
    assert residuals.covariance.shape == (1001, 2, 2)
    np.testing.assert_allclose(np.sqrt(residuals.covariance[:, 1, 1]), residuals["a5"].std, rtol=1e-14)
    s = residuals.covariance[500]
    e = residuals.value[500]
    assert e @ np.linalg.solve(s, e) == pytest.approx(residuals.nis[500], rel=1e-8)
    np.testing.assert_allclose(s, s.T)


def test_scores_of_the_samples_balance_the_prior():
    run = estimate()
    found, (initial, deviation) = run.parameters["suspension.mu_k1"].value, UNKNOWN["suspension.mu_k1"]
    assert run.residuals.scores.shape == (1001, 1)
    # The gradient of the log posterior is zero at the last estimate.
    assert run.residuals.scores.sum() == pytest.approx((found - initial) / deviation**2, rel=1e-6)


def test_measurements_may_be_a_dictionary_an_array_or_a_table():
    t, u, data = record()
    expected = estimate().parameters["suspension.mu_k1"].value
    table = np.column_stack([data["a3"], data["a5"]])
    for y in (dict(data), table, np.asfortranarray(table), {**data, "more": np.zeros(3)}):
        assert estimate(y).parameters["suspension.mu_k1"].value == expected
    pandas = pytest.importorskip("pandas")
    assert estimate(pandas.DataFrame(dict(data))).parameters["suspension.mu_k1"].value == expected


def test_missing_samples_are_nan():
    _, _, data = record()
    gap = np.array(data["a3"])
    gap[100:200] = np.nan
    run = estimate({"a3": gap, "a5": data["a5"]})
    assert np.isnan(run["innovation/value/a3"][150]) and not run.residuals.used[150, 0]
    assert abs(run.parameters["suspension.mu_k1"].value - 20.0) < 4 * run.parameters["suspension.mu_k1"].std


@pytest.mark.parametrize(
    "prior, initial, std",
    [
        ((10.0, 5.0), 10.0, 5.0),
        ((10.0, "50 %"), 10.0, 5.0),
        (("0.01 kN", "5 N"), 10.0, 5.0),
        (10.0, 10.0, 5.0),
        (None, 20.0, 10.0),
        (dict(initial=10.0, std="50 %", transform="none"), 10.0, 5.0),
    ],
)
def test_priors_of_every_form(prior, initial, std):
    expected = estimate(unknown={"suspension.mu_k1": dict(initial=initial, std=std)})
    found = estimate(unknown={"suspension.mu_k1": prior})
    assert found.parameters["suspension.mu_k1"].value == expected.parameters["suspension.mu_k1"].value


def test_bounds_and_lists_of_names():
    run = estimate(unknown={"suspension.mu_k1": dict(initial=15.0, std=5.0, bounds=(5.0, 18.0))})
    assert 5.0 < run.parameters["suspension.mu_k1"].value < 18.0
    assert list(estimate(unknown=["suspension.mu_k1"]).parameters) == ["suspension.mu_k1"]


def test_outputs_are_virtual_sensors():
    run = estimate(outputs={"pull": kf.force("suspension")})
    assert run["estimate/pull"].unit == "N" and np.ptp(run["estimate/pull"]) > 1.0


def test_filters_by_name():
    values = [
        estimate(filter=name).parameters["suspension.mu_k1"].value
        for name in ("partially_linear_ukf", "ukf", "ekf")
    ]
    assert values[1] == pytest.approx(values[0], rel=0.02) and values[2] == pytest.approx(values[0], rel=0.05)


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(unknown={"suspension.mu_k9": 1.0}), r"unknown\['suspension.mu_k9'\]: there is no parameter.*mu_k1"),
        (dict(unknown={"suspension.mu_k1": (1.0, -2.0)}), r"unknown\['suspension.mu_k1'\].std: it is -2"),
        (dict(unknown={"suspension.mu_k1": (1.0, 2.0, 3.0)}), r"unknown\['suspension.mu_k1'\]: 3 values"),
        (dict(unknown={"suspension.mu_k1": ("3 kg", 1.0)}), r"unknown\['suspension.mu_k1'\]: .*3 kg"),
        (dict(unknown={"suspension.mu_k1": dict(mean=1.0)}), r"there is no entry 'mean'"),
        (dict(sensors={"a3": kf.acceleration("body.2")}), r"sensors\['a3'\].noise: it is 0"),
        (dict(sensors={"a4": kf.acceleration("body.2", noise=0.3)}), r"y: there is no channel 'a4'"),
        (dict(sensors={"a3": "body.2"}), r"sensors\['a3'\]: 'body.2' is given"),
        (dict(sensors={}), "sensors: the list is empty"),
        (dict(inputs={}), "input 'road' has no signal"),
        (dict(inputs={"rod": np.zeros(1001)}), r"inputs\['rod'\]: there is no input 'rod' \(did you mean 'road'"),
        (dict(inputs={"road": np.zeros(5)}), r"inputs\['road'\]: 5 samples, t has 1001"),
        (dict(filter=3), "filter: 3 is given: a text is needed"),
        (dict(substeps="many"), "substeps: 'many' is given: a whole number is needed"),
        (dict(passes=None), "passes: None is given"),
        (dict(settle="1 s"), "settle: '1 s' is given: a number is needed"),
        (dict(y={"a3": np.full(1001, np.nan), "a5": np.zeros(1001)}), r"sensors\['a3'\]: its channel has no number"),
        (dict(filter="ufk"), "filter: there is no filter 'ufk'"),
        (dict(y=np.zeros((1001, 3))), r"y: an array of shape \(1001, 3\)"),
        (dict(y={"a3": np.zeros(7), "a5": np.zeros(1001)}), r"y\['a3'\]: 7 samples, t has 1001"),
    ],
)
def test_errors_name_the_argument(change, words):
    with pytest.raises(kf.InvalidInput, match=words) as caught:
        estimate(**change)
    assert caught.value.issues and isinstance(caught.value, ValueError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_errors_come_together():
    with pytest.raises(kf.InvalidInput) as caught:
        estimate(unknown={"suspension.mu_k9": 1.0, "wheel.x": 2.0}, sensors={**SENSORS, "a3": kf.acceleration("body.9", noise=1)})
    assert len(caught.value.issues) == 3


def test_times_must_be_even():
    t, u, data = record()
    uneven = t.copy()
    uneven[500] += 5e-4
    for wrong, words in [(uneven, "t: the times are not even"), (t[:1], "t: 1 times"), (t[:, None], "t: 2 dimensions")]:
        with pytest.raises(kf.InvalidInput, match=words):
            kf.estimate(chain(), wrong, data, sensors=SENSORS, inputs={"road": u})


def test_times_in_milliseconds_are_asked_about():
    t, u, data = record()
    with pytest.raises(kf.InvalidInput, match=r"t: its steps are 2 s, .* t looks like milliseconds; give t in seconds"):
        kf.estimate(chain(), 1e3 * t, data, sensors=SENSORS, inputs={"road": u})


def test_noise_may_be_a_percentage_or_in_g():
    t, u, data = record()
    sensors = {"a3": kf.acceleration("body.2", noise="2 %"), "a5": kf.acceleration("body.4", noise="0.03 g")}
    assert sensors["a3"].noise == "2 %" and sensors["a5"].noise == pytest.approx(0.03 * 9.80665, rel=1e-12)
    rms = np.sqrt(np.mean(np.asarray(data["a3"]) ** 2))
    stated = {"a3": kf.acceleration("body.2", noise=0.02 * rms), "a5": kf.acceleration("body.4", noise=0.03 * 9.80665)}
    one, other = (estimate(sensors=each).parameters["suspension.mu_k1"] for each in (sensors, stated))
    assert one.value == pytest.approx(other.value, rel=1e-9) and one.std == pytest.approx(other.std, rel=1e-9)
    clean = kf.simulate(chain(), t, sensors=sensors, inputs={"road": u}, progress=False)
    noisy = kf.simulate(chain(), t, sensors=sensors, inputs={"road": u}, seed=1, progress=False)
    clean_rms = np.sqrt(np.mean(np.asarray(clean["a3"]) ** 2))
    assert np.std(noisy["a3"] - clean["a3"]) == pytest.approx(0.02 * clean_rms, rel=0.1)
    with pytest.raises(kf.InvalidInput, match=r"sensors\['a3'\]: its noise is a percentage"):
        kf.Filter(chain(), RATE, sensors=sensors)


def test_a_simulation_repeats_itself_and_its_noise_has_a_seed():
    t, u, data = record()
    again = kf.simulate(chain(), t, sensors=SENSORS, inputs={"road": u}, seed=1, progress=False)
    other = kf.simulate(chain(), t, sensors=SENSORS, inputs={"road": u}, seed=2, progress=False)
    clean = kf.simulate(chain(), duration=2.0, sample_rate=RATE, sensors=SENSORS, inputs={"road": u}, progress=False)
    assert np.array_equal(again["a3"], data["a3"])
    assert (other["a3"] - clean["a3"]).std() == pytest.approx(0.3, rel=0.1)
    assert data["a3"].unit == "m/s^2" and np.allclose(data.t, t)
    with pytest.raises(kf.InvalidInput, match="t begins at 1 s"):
        kf.simulate(chain(), t + 1, sensors=SENSORS, inputs={"road": u})


def test_progress_goes_to_a_function():
    seen = []
    estimate(progress=lambda fraction, words: seen.append((fraction, words)))
    assert seen and all(0 <= fraction <= 1 and words.startswith("filter pass") for fraction, words in seen)


def test_an_error_in_the_progress_function_stops_the_call():
    def stop(fraction, words):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        estimate(progress=stop)


def test_two_threads_run_two_filters():
    t = np.arange(6000) / RATE
    u = np.zeros(6000)
    y = {name: np.zeros(6000) for name in SENSORS}

    def work():
        kf.estimate(
            chain(12), t, y, sensors=SENSORS, inputs={"road": u}, substeps=4, threads=1, diagnose=False, progress=False
        )

    def elapsed(threads):
        begin = time.perf_counter()
        for each in threads:
            each.start()
        for each in threads:
            each.join()
        return time.perf_counter() - begin

    counted = 0
    stopped = threading.Event()

    def count():
        nonlocal counted
        while not stopped.is_set():
            counted += 1
            time.sleep(1e-3)

    beside = threading.Thread(target=count)
    beside.start()
    elapsed([threading.Thread(target=work) for _ in range(2)])
    stopped.set()
    beside.join()
    assert counted > 20  # the interpreter was free while both filters ran


def test_sensors_held_out_as_virtual_ones(tmp_path):
    s = kf.Structure()
    s.add(kf.lumped("m").mass("1", 2.0).mass("2", 1.0).spring("k", "ground", "1", 2e3, 4.0).spring("k2", "1", "2", 1e3, 2.0))
    s.force("hammer", "m.1")
    t = np.arange(2000) / 250
    inputs = {"hammer": 10 * np.sin(2 * np.pi * (1 + 1.2 * t) * t)}
    sensors = {"a": kf.acceleration("m.1", noise=0.05), "b": kf.acceleration("m.2", noise=0.05)}
    unknown = {"m.k.stiffness": (2500, "30 %")}
    record = kf.simulate(s, t, sensors=sensors, inputs=inputs, seed=1, progress=False)
    run = kf.estimate(s, t, record, sensors=sensors, inputs=inputs, unknown=unknown, progress=False)
    assert list(run.held_out) == ["a", "b"]
    assert all(each.holds and abs(each.inside - 0.95) < 0.02 for each in run.held_out.values())
    assert run.held_out.adapted is None
    with pytest.raises(KeyError):
        run.held_out["c"]

    adaptive = {"process": True, "sensors": False, "memory": 2.0}
    file = tmp_path / "case.yaml"
    kf.to_case(s, t, record, inputs=inputs, file=file,
               estimate={"sensors": sensors, "unknown": unknown, "process_noise": 0.01, "adaptive_noise": adaptive})
    assert kf.read_case(file).estimate["adaptive_noise"] == adaptive
    with pytest.raises(kf.InvalidInput, match="adaptive_noise"):
        kf.estimate(s, t, record, sensors=sensors, inputs=inputs, adaptive_noise={"proces": True}, progress=False)
