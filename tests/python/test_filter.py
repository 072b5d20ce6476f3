# SPDX-License-Identifier: Apache-2.0
"""The live filter: step by step and by blocks."""

import itertools
import random

import numpy as np
import pytest

import kalfem as kf
from structures import RATE, SENSORS, UNKNOWN, chain, record


def live(**changes):
    return kf.Filter(chain(), RATE, **{**dict(sensors=SENSORS, unknown=UNKNOWN), **changes})


def bits(filter):
    k, x = filter.parameters["suspension.mu_k1"], filter.state("body.3.displacement")
    return k.value, k.std, x.value, x.std, filter.nis


def stepped(samples=400):
    _, u, data = record()
    filter = live()
    filter.begin(u[:1])
    for k in range(samples):
        if k > 0:
            assert filter.predict(u[k : k + 1])
        assert filter.update([data["a3"][k], data["a5"][k]])
    filter.flush()
    return filter


def test_steps_find_the_parameter():
    filter = stepped(1001)
    found = filter.parameters["suspension.mu_k1"]
    assert abs(found.value - 20.0) < 0.1 and found.std < 0.1 and found.unit == "N"
    assert filter.time == pytest.approx(2.0) and filter.usable and filter.running and filter.failure is None
    assert filter.verdict.state == "consistent" and filter.consistency.expected_nis == 2.0
    assert filter.consistency.mean_nis == pytest.approx(2.0, abs=0.3)
    assert filter.innovation.shape == (2,)


def test_a_lag_smooths_and_leaves_the_filter_alone():
    _, u, data = record()
    filter, plain = live(lag=20, input_delay=0), live(input_delay=0)
    for each in (filter, plain):
        assert each.smoothed is None
        each.begin(u[:1])
        for k in range(100):
            if k > 0:
                each.predict(u[k : k + 1])
            each.update([data["a3"][k], data["a5"][k]])
    assert plain.smoothed is None and bits(filter) == bits(plain)
    found = filter.smoothed
    assert found.time == pytest.approx(filter.time - 20 / RATE)
    assert found.states["body.3.displacement"].std > 0.0
    parameter = found.parameters["suspension.mu_k1"]
    assert parameter.value == pytest.approx(filter.parameters["suspension.mu_k1"].value) and parameter.unit == "N"
    with pytest.raises(kf.InvalidInput, match="lag: -1 samples"):
        live(lag=-1)


def test_values_by_name_are_values_by_place():
    _, u, data = record()
    one, other = live(), live()
    for k in range(50):
        if k > 0:
            one.predict([u[k]]), other.predict({"road": u[k]})
        one.update([data["a3"][k], np.nan]), other.update({"a3": data["a3"][k]})
    assert one.time == pytest.approx((49 - 8) / RATE)
    assert bits(one) == bits(other)


def test_many_samples_at_once_are_steps():
    _, u, data = record()
    filter = live()
    filter.begin(u[:1])
    filter.update([data["a3"][0], data["a5"][0]])
    y = np.column_stack([data["a3"], data["a5"]])
    assert filter.advance(u[1:400, None], y[1:400]) == 399
    assert filter.flush() == 8
    assert bits(filter) == bits(stepped(400))
    with pytest.raises(kf.InvalidInput, match=r"\(samples, 1\) and \(samples, 2\)"):
        filter.advance(u, y)


def test_inputs_may_come_with_their_rates():
    _, u, data = record()
    filter = live()
    filter.update([data["a3"][0], data["a5"][0]])
    rate = np.gradient(u, 1 / RATE)
    for k in range(1, 300):
        filter.predict(np.array([[u[k], rate[k], 0.0]]))
        filter.update([data["a3"][k], data["a5"][k]])
    expected = stepped(300).parameters["suspension.mu_k1"]
    assert filter.parameters["suspension.mu_k1"].value == pytest.approx(expected.value, rel=1e-2)


def pushed(order, length, horizon=2.0, samples=400):
    """The filter after blocks of every channel, in an order of (first sample, channel)."""
    _, u, data = record()
    channels = {"road": u, "a3": data["a3"], "a5": data["a5"]}
    filter = live(horizon=horizon)
    for first, name in order:
        block = slice(first, min(first + length, samples))
        filter.push(name, block.start / RATE, channels[name][block])
    filter.flush()
    return filter


def blocks(length, samples=400):
    return list(itertools.product(range(0, samples, length), ["a3", "road", "a5"]))


def test_blocks_are_steps():
    filter = pushed(blocks(100), 100)
    assert filter.samples == 400 and filter.dropped == 0
    assert bits(filter) == bits(stepped(400))


@pytest.mark.parametrize("length", [1, 7, 100])
def test_the_order_of_arrival_changes_no_bit(length):
    expected = bits(pushed(blocks(100), 100))
    order = blocks(length)
    mixed = random.Random(length)
    order.sort(key=lambda each: each[0] + mixed.uniform(0, 200))  # within 0.4 s
    assert bits(pushed(order, length)) == expected
    assert bits(pushed(reversed(blocks(length)), length)) == expected


def test_times_of_each_value():
    _, u, data = record()
    t = np.arange(400) / RATE
    filter = live()
    for name, values in [("a3", data["a3"]), ("a5", data["a5"]), ("road", u)]:
        filter.push(name, t[:200], values[:200])
        filter.push(name, t[200:400], values[200:400])
    assert filter.time == pytest.approx((399 - 8) / RATE) and filter.flush() == 0
    assert filter.samples == 400 and bits(filter) == bits(stepped(400))


def test_what_comes_too_late_is_dropped():
    _, u, data = record()
    filter = live(horizon=0.1)
    for first in range(0, 400, 20):
        filter.push("a3", first / RATE, data["a3"][first : first + 20])
        filter.push("road", first / RATE, u[first : first + 20])
    assert filter.samples == 400 - 50 - 1
    assert filter.push("a5", 0.0, data["a5"][:20]) == 0 and filter.dropped == 20


def test_it_is_not_usable_while_a_sensor_is_dead():
    _, u, data = record()
    filter = live(window=200)
    for k in range(800):
        if k > 0:
            filter.predict(u[k : k + 1])
        filter.update([data["a3"][k if k < 400 else 400], data["a5"][k]])
        if k == 390:
            assert filter.usable
    assert filter.running and not filter.usable and filter.verdict.state == "unusable"
    assert filter.verdict.reasons[0].subject in ("a3", "all sensors")
    assert filter.consistency.mean_nis > 20.0


def test_without_a_delay_inputs_are_straight():
    _, u, data = record()
    filter = live(input_delay=0)
    filter.begin(u[:1])
    filter.update([data["a3"][0], data["a5"][0]])
    for k in range(1, 1001):
        filter.predict(u[k : k + 1]), filter.update([data["a3"][k], data["a5"][k]])
    assert filter.time == pytest.approx(2.0)
    straight, spline = filter.parameters["suspension.mu_k1"], stepped(1001).parameters["suspension.mu_k1"]
    assert abs(spline.value - 20.0) < 3.0 * spline.std < abs(straight.value - 20.0)


def test_errors_name_the_argument():
    filter = live()
    with pytest.raises(kf.InvalidInput, match="y: 3 values: there are 2: a3, a5"):
        filter.update([1.0, 2.0, 3.0])
    with pytest.raises(kf.InvalidInput, match=r"y\['a4'\]: there is none of that name"):
        filter.update({"a4": 1.0})
    filter.update([0.0, 0.0])
    with pytest.raises(kf.InvalidInput, match="u: 2 values: there are 1: road"):
        filter.predict([1.0, 2.0])
    with pytest.raises(kf.InvalidInput, match="input 'road' has no signal"):
        filter.predict()
    with pytest.raises(kf.InvalidInput, match=r"inputs\[0\] is not finite"):
        filter.predict([np.nan])
    with pytest.raises(kf.InvalidInput, match=r"push\(\) is called after predict"):
        filter.push("a3", 0.0, [1.0])
    with pytest.raises(kf.InvalidInput, match="no state 'body.9.displacement'"):
        filter.state("body.9.displacement")
    blocks = live(start=10.0)
    for arguments, words in [
        (("a4", 10.0, [1.0]), "no channel 'a4'"),
        (("a3", 10.0007, [1.0]), "lies between two samples"),
        (("a3", 10.0, np.zeros(6000)), "longer than the horizon"),
        (("a3", 1.7e9, [1.0]), "count the time from `start`"),
        (("a3", 10.0, np.zeros((2, 2))), "no array of one dimension"),
    ]:
        with pytest.raises(kf.InvalidInput, match=words):
            blocks.push(*arguments)
    with pytest.raises(kf.InvalidInput, match=r"predict\(\) and update\(\) are called after push"):
        blocks.update([0.0, 0.0])
    with pytest.raises(kf.InvalidInput, match="horizon"):
        live(horizon=-1.0)
    with pytest.raises(kf.InvalidInput, match="input_delay: -1 samples"):
        live(input_delay=-1)


def test_gates_name_a_sensor_that_reads_zero():
    _, u, data = record()
    a5 = np.array(data["a5"])
    a5[500:700] = 0.0
    filter = live(gates={"warm_up": 200})
    filter.begin(u[:1])
    for k in range(1001):
        if k > 0:
            filter.predict(u[k : k + 1])
        filter.update([data["a3"][k], a5[k]])
    filter.flush()
    kinds = [event.kind for event in filter.events if event.channel == "a5"]
    assert "stuck" in kinds and "back" in kinds
    assert abs(filter.parameters["suspension.mu_k1"].value - 20.0) < 0.2
    assert filter.condition in ("consistent", "suspicious")
    hour = filter.health["hour"]
    assert hour["seconds"] == pytest.approx(2.0) and sum(hour["shares"].values()) == pytest.approx(1.0)
    assert hour["expected_nis"] == pytest.approx(2.0, abs=0.5)
    with pytest.raises(kf.InvalidInput, match="there is no 'limits'"):
        live(gates={"limits": 3})


def test_alarms_name_a_spring_that_softens():
    rate, k = 200.0, 2e5
    def mass(stiffness):
        s = kf.Structure()
        s.add(kf.lumped("frame").mass("1", 100.0).spring("k", "ground", "1", stiffness, 200.0))
        return s.force("shaker", "frame.1")

    sensors = {"a": kf.acceleration("frame.1", noise=0.02)}
    filter = kf.Filter(
        mass(k), rate, sensors=sensors, unknown={"frame.k.stiffness": (k, "5 %")}, window=400,
        changes={"window": 2.0, "reference": 15, "memory": 15, "level": 0.01, "covariates": {"T": 0.001}},
    )
    t = np.arange(6001) / rate
    random = np.random.default_rng(1)
    for part, stiffness in enumerate([k, k, 0.97 * k]):
        force = np.r_[0.0, random.normal(0.0, 50.0, t.size - 1)]
        shown = kf.simulate(mass(stiffness), t, sensors=sensors, inputs={"shaker": force}, seed=part)
        for first in range(0, 6000, 200):
            at = 30.0 * part + t[first]
            filter.push("T", at, [20.0 + np.sin(at)])
            filter.push("shaker", at, force[first : first + 200])
            filter.push("a", at, np.asarray(shown["a"])[first : first + 200])
    (alarm,) = filter.alarms
    assert alarm.kind == "raised" and alarm.what.parameter == "frame.k.stiffness"
    assert abs(alarm.what.change + 0.03) < 4 * alarm.what.std
    assert filter.changes[0].parameter == "frame.k.stiffness"
    assert filter.trend[-1].windows > 20 and abs(filter.trend[-1].mean / k - 0.99) < 0.02
    with pytest.raises(kf.InvalidInput, match="there is no 'levels'"):
        kf.Filter(mass(k), rate, sensors=sensors, unknown=["frame.k.stiffness"], changes={"levels": 0.01})


def test_a_state_gives_the_same_bits(tmp_path):
    _, u, data = record()
    whole, first, second = live(gates=True), live(gates=True), live(gates=True)
    file = str(tmp_path / "state")

    def move(filter, begin, end):
        for name, values in (("road", u[:, 0] if u.ndim == 2 else u), ("a3", data["a3"]), ("a5", data["a5"])):
            filter.push(name, begin / RATE, values[begin:end])

    move(whole, 0, 200), move(whole, 200, 400)
    move(first, 0, 200)
    first.write_state(file)
    second.read_state(file)
    move(second, 200, 400)
    assert bits(second) == bits(whole)
