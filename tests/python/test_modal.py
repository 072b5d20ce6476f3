# SPDX-License-Identifier: Apache-2.0
"""kf.modal on the ambient motion of a shear frame, whose modes are known, and on to kf.update."""

import json

import numpy as np
import pytest

import kalfem as kf

STIFFNESS, STOREYS, RATE = 4000.0, 3, 50.0


def truth():
    angles = (2 * np.arange(STOREYS) + 1) * np.pi / (2 * STOREYS + 1)
    omega = 2 * np.sqrt(STIFFNESS) * np.sin(angles / 2)
    shapes = np.sin(np.outer(np.arange(1, STOREYS + 1), angles))
    return omega / (2 * np.pi), shapes / np.linalg.norm(shapes, axis=0)


@pytest.fixture(scope="module")
def record():
    """Velocities of the floors under white forces: each mode by its own recursion over a quarter of a sample."""
    frequencies, shapes = truth()
    random = np.random.default_rng(3)
    samples, parts = 15000, 4
    mu = 2 * np.pi * frequencies * (-0.01 + 1j * np.sqrt(1 - 1e-4))
    step = np.exp(mu / (RATE * parts))
    z, velocities = np.zeros(STOREYS, complex), np.empty((samples, STOREYS))
    forces = random.normal(size=(samples + 1000, parts, STOREYS)) @ shapes
    for k in range(-1000, samples):
        for force in forces[k + 1000]:
            z = step * z + force
        if k >= 0:
            velocities[k] = z.real + mu.real * z.imag / mu.imag
    y = velocities @ shapes.T
    y += 0.05 * y.std(axis=0) * random.normal(size=y.shape)
    return np.arange(samples) / RATE, {f"floor {i + 1}": y[:, i] for i in range(STOREYS)}


def test_finds_the_modes_with_their_deviations(record):
    t, y = record
    found = kf.modal(y, t, progress=False)
    frequencies, shapes = truth()
    assert len(found) == STOREYS and found.channels == list(y)
    for mode, frequency, shape in zip(found, frequencies, shapes.T):
        assert abs(mode.frequency - frequency) < 4 * mode.frequency_std < 0.01 * frequency
        assert abs(mode.damping - 0.01) < 4 * mode.damping_std < 0.01
        assert mode.frequency_interval[0] < mode.frequency < mode.frequency_interval[1]
        assert mode.phase_collinearity > 0.99 and mode.peak[1] > 0.9
        expected = shape / shape[abs(mode.shape).argmax()]
        assert np.all(abs(mode.shape.real - expected) < 5 * mode.shape_std.real + 1e-12)
        assert mode.covariance[0, 0] == pytest.approx(mode.frequency_std**2)
    assert found["floor 2"] == pytest.approx(found.shapes[1])
    assert set(found.diagram) == {"order", "frequency", "frequency_std", "damping", "stable"}
    assert found.diagram["stable"].sum() == sum(mode.orders for mode in found)


def test_takes_records_in_several_forms(record, tmp_path):
    t, y = record
    found = kf.modal(y, t, progress=False)
    array = kf.modal(np.column_stack(list(y.values())), t, progress=False)
    assert array.frequencies == pytest.approx(found.frequencies) and array.channels == ["1", "2", "3"]
    file = tmp_path / "record.csv"
    np.savetxt(file, np.column_stack([t, *y.values()]), delimiter=",", header="t [s]," + ",".join(y), comments="")
    assert kf.modal(file, progress=False).frequencies == pytest.approx(found.frequencies)
    two = kf.modal(y, t, channels=["floor 3", "floor 1"], references=["floor 3"], progress=False)
    assert two.channels == ["floor 3", "floor 1"] and two.references == ["floor 3"]
    assert two.frequencies == pytest.approx(found.frequencies, rel=5e-3)


def test_modes_update_a_model(record):
    t, y = record
    s = kf.Structure()
    frame = kf.lumped("frame")
    for i in range(1, STOREYS + 1):
        frame.mass(f"{i}", 1.0).spring(f"s{i}", "ground" if i == 1 else f"{i - 1}", f"{i}", 1.2 * STIFFNESS)
    s.add(frame)
    measured = kf.modal(y, t, progress=False).measured("frame", [f"frame.{i}" for i in range(1, STOREYS + 1)])
    assert measured.shapes.shape == (STOREYS, STOREYS)
    names = [f"frame.s{i}.stiffness" for i in range(1, STOREYS + 1)]
    updated = kf.update(s, parameters=names, compare={"ambient": measured}, progress=False)
    for name in names:
        assert updated.parameters[name].value == pytest.approx(STIFFNESS, rel=0.03)


def test_tells_what_is_wrong(record):
    t, y = record
    with pytest.raises(kf.InvalidInput, match="1 channel is given"):
        kf.modal({"a": y["floor 1"]}, t, progress=False)
    with pytest.raises(kf.InvalidInput, match="did you mean 'mac'"):
        kf.modal(y, t, stabilisation={"mak": 0.9}, progress=False)
    with pytest.raises(KeyError, match="floor 9"):
        kf.modal(y, t, channels=["floor 1", "floor 9"], progress=False)
    with pytest.raises(kf.InvalidInput, match="no times"):
        kf.modal(y, progress=False)
    gap = dict(y, **{"floor 2": np.where(np.arange(t.size) == 7, np.nan, y["floor 2"])})
    with pytest.raises(kf.InvalidInput, match="'floor 2' has 1 missing sample"):
        kf.modal(gap, t, progress=False)
    with pytest.raises(kf.InvalidInput, match="samples"):
        kf.modal({name: each[:200] for name, each in y.items()}, t[:200], progress=False)


def test_a_file_of_modes_is_a_comparison_and_is_correlated(record, tmp_path):
    """modes.json brings what the result in memory does; two exchanged cables are named."""
    t, y = record
    found = kf.modal(y, t, progress=False)
    file = {"channels": found.channels, "modes": []}
    for mode in found:
        shape = {name: {"real": x.real, "imaginary": x.imag} for name, x in zip(found.channels, mode.shape)}
        file["modes"].append({"frequency_hz": mode.frequency, "frequency_std_hz": mode.frequency_std, "shape": shape})
    (tmp_path / "modes.json").write_text(json.dumps(file))
    read = kf.read_modes(tmp_path / "modes.json")
    assert read.points == found.channels and read.shapes == pytest.approx(found.shapes)
    assert read.frequency_std == pytest.approx([mode.frequency_std for mode in found])
    assert np.isnan(read.dampings).all() and read.covariances is None
    points = {f"frame.{i}": f"floor {i}" for i in range(1, STOREYS + 1)}
    measured = found.measured("frame", points, dampings=True)
    assert measured.damping_std == pytest.approx([mode.damping_std for mode in found])
    assert len(measured.shape_covariances) == STOREYS and np.shape(measured.shape_covariances[0]) == (STOREYS, STOREYS)
    frame = kf.lumped("frame")
    for i in range(1, STOREYS + 1):
        frame.mass(f"{i}", 1.0).spring(f"s{i}", "ground" if i == 1 else f"{i - 1}", f"{i}", STIFFNESS)
    s = kf.Structure().add(frame)
    assert not kf.correlate(s, measured).mistakes
    points["frame.1"], points["frame.2"] = points["frame.2"], points["frame.1"]
    exchanged = kf.correlate(s, found.measured("frame", points))
    assert exchanged.mistakes[0].kind == "swapped"
    assert sorted(exchanged.mistakes[0].sensors) == ["floor 1", "floor 2"]
    with pytest.raises(kf.InvalidInput, match="floor 9"):
        found.measured("frame", {"frame.1": "floor 9"})


def forced(noise=0.02):
    """Velocities under a white force at the first floor, and the force."""
    frequencies, shapes = truth()
    random = np.random.default_rng(5)
    step = np.exp(2 * np.pi * frequencies * (-0.01 + 1j) / RATE)
    f, z, y = random.normal(size=30000), np.zeros(STOREYS, complex), []
    for each in f:
        z = step * z + each * shapes[0]
        y.append(shapes @ z.real)
    y = np.array(y)
    y += noise * y.std(axis=0) * random.normal(size=y.shape)
    return np.arange(f.size) / RATE, {"f": f} | {f"floor {i + 1}": y[:, i] for i in range(STOREYS)}


def test_measured_forces_give_the_modes_too():
    t, y = forced()
    found = kf.modal(y, t, inputs=["f"], segment=60, progress=False)
    frequencies, shapes = truth()
    assert len(found) == STOREYS and found.references == ["f"] and "f" not in found.channels
    for mode, frequency, shape in zip(found, frequencies, shapes.T):
        assert abs(mode.frequency / frequency - 1) < 2e-3
        assert abs(mode.damping / 0.01 - 1) < 0.15
        assert abs(np.vdot(mode.shape, shape)) ** 2 > 0.99 * np.vdot(mode.shape, mode.shape).real
    with pytest.raises(kf.InvalidInput, match="estimator"):
        kf.modal(y, t, inputs=["f"], estimator="h4", progress=False)


def test_frequency_responses_give_the_modes():
    frequencies, shapes = truth()
    f = np.linspace(1, 22, 1200)
    s, omega = 2j * np.pi * f[:, None], 2 * np.pi * frequencies
    single = s / (s**2 + 0.02 * omega * s + omega**2)
    random = np.random.default_rng(6)
    responses = {}
    for floor in (0, 2):
        exact = (single * shapes[floor]) @ shapes.T
        size = 0.01 * np.sqrt(np.mean(abs(exact) ** 2, axis=0) / 2)
        responses[f"f{floor + 1}"] = exact + size * (random.normal(size=exact.shape) + 1j * random.normal(size=exact.shape))
    found = kf.modal_of_responses(f, responses, outputs=["a", "b", "c"], progress=False)
    assert found.channels == ["a", "b", "c"] and found.references == ["f1", "f3"]
    assert np.allclose(found.frequencies, frequencies, rtol=2e-4)
    assert np.allclose(found.damping, 0.01, rtol=0.02)
    run = found.measured("frame", ["frame.1", "frame.2", "frame.3"])
    assert run is not None
    with pytest.raises(kf.InvalidInput, match="lines"):
        kf.modal_of_responses(f[:10], {k: v[:10] for k, v in responses.items()}, progress=False)
