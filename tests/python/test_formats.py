# SPDX-License-Identifier: Apache-2.0
"""Measured files, read without a case."""

import wave
from pathlib import Path

import numpy as np
import pytest

import kalfem as kf

FORMATS = Path(__file__).parents[1] / "formats"


def test_a_table_has_units_and_exact_times(tmp_path):
    file = tmp_path / "record.csv"
    file.write_text("t [s],a3 [m/s^2],x [mm]\n" + "".join(f"{k / 1000:.3f},{k},{2 * k}\n" for k in range(10)))
    found = kf.read(file)
    assert list(found) == ["a3", "x"] and found["a3"].unit == "m/s^2" and found["x"].unit == "mm"
    assert found["x"].tolist() == [2.0 * k for k in range(10)]
    np.testing.assert_allclose(found["x"].t, np.arange(10) / 1000, rtol=1e-15, atol=1e-18)
    assert found.format and "a3" in repr(found)
    with pytest.raises(KeyError, match="did you mean 'a3'"):
        found["a4"]


def test_a_sound_file(tmp_path):
    file = tmp_path / "blow.wav"
    with wave.open(str(file), "wb") as sound:
        sound.setnchannels(2)
        sound.setsampwidth(2)
        sound.setframerate(8000)
        sound.writeframes(np.array([[0, 16384], [-16384, 8192]], "<i2").tobytes())
    found = kf.read(file)
    assert len(found) == 2
    np.testing.assert_allclose(np.column_stack(list(found.values())), [[0, 0.5], [-0.5, 0.25]])
    assert next(iter(found.values())).t[1] == 1 / 8000


def test_hdf5_and_matlab(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "record.h5", "w") as file:
        file["y"] = np.arange(8.0).reshape(4, 2)
        file["y"].attrs["sample_rate"] = 100.0
        file["y"].attrs["unit"] = "m/s^2"
    found = kf.read(tmp_path / "record.h5")
    assert len(found) == 2 and next(iter(found.values())).unit == "m/s^2"
    io = pytest.importorskip("scipy.io")
    io.savemat(tmp_path / "record.mat", {"fs": 200.0, "acc": np.arange(6.0)})
    found = kf.read(tmp_path / "record.mat")
    assert any(np.array_equal(values, np.arange(6.0)) for values in found.values())


def universal_file(tmp_path):
    """A response function and an acceleration as dataset 58."""
    head = ["test", "NONE", "01-Jan-20 00:00:00", "NONE", "NONE"]
    def dataset(kind, data_type, count, start, step, abscissa, unit, values):
        return [
            "    -1", "    58", *head,
            f"{kind:5d}{0:10d}{0:5d}{0:10d} NONE      {12:10d}{3:4d} NONE      {3:10d}{1:4d}",
            f"{data_type:10d}{count:10d}{1:10d}{start:13.5e}{step:13.5e}{0.0:13.5e}",
            f"{abscissa:10d}{0:5d}{0:5d}{0:5d} NONE                 NONE",
            f"{12:10d}{0:5d}{0:5d}{0:5d} NONE                 {unit}",
            f"{13:10d}{0:5d}{0:5d}{0:5d} NONE                 N",
            f"{0:10d}{0:5d}{0:5d}{0:5d} NONE                 NONE",
            *values, "    -1",
        ]
    function = dataset(4, 5, 2, 10.0, 0.5, 18, "m/s^2", [f"{1.0:13.5e}{2.0:13.5e}{3.0:13.5e}{-4.0:13.5e}"])
    history = dataset(1, 2, 3, 0.0, 0.01, 17, "m/s^2", [f"{1.0:13.5e}{2.0:13.5e}{3.0:13.5e}"])
    file = tmp_path / "test.uff"
    file.write_text("\n".join(function + history) + "\n")
    return file


def test_functions_of_a_universal_file(tmp_path):
    found = kf.read(universal_file(tmp_path))
    (function,) = found.functions
    assert function.kind == "frequency response" and function.frequency.tolist() == [10.0, 10.5]
    assert function.values.tolist() == [1 + 2j, 3 - 4j]
    assert function.response == {"node": 12, "direction": 3} and function.reference["node"] == 3
    (channel,) = found.values()
    assert channel.tolist() == [1.0, 2.0, 3.0] and channel.t.tolist() == [0.0, 0.01, 0.02]


def test_what_is_no_measured_file_is_named(tmp_path):
    picture = tmp_path / "picture.png"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(20))
    with pytest.raises(kf.InvalidInput, match="picture.png"):
        kf.read(picture)
    with pytest.raises(kf.InvalidInput, match="nowhere.csv"):
        kf.read(tmp_path / "nowhere.csv")
