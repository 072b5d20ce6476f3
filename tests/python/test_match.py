# SPDX-License-Identifier: Apache-2.0
"""kf.match_points: sensors at the nodes of a deck, by places and from files."""

from pathlib import Path

import numpy as np
import pytest

import kalfem as kf

FRAME = Path(__file__).parents[2] / "examples" / "cpp" / "frame.bdf"


def turned(places, angle=0.7, shift=(3.0, -2.0, 5.0)):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return {name: (place - np.array(shift)) @ turn for name, place in places.items()}, turn


@pytest.fixture()
def frame():
    elements = kf.read_deck(FRAME)
    places = dict(zip(elements.node_numbers, np.asarray(elements.node_positions).reshape(-1, 3)))
    return elements, places


def test_a_symmetric_frame_says_so(frame):
    elements, places = frame
    points, _ = turned({"left": places[1], "top": places[9], "right": places[17], "knee": places[5]})
    found = kf.match_points(elements, points)
    assert len(found.other_fits) >= 1 and not found.sure
    assert found.fit.rms < 1e-9
    assert {point.name: point.sure for point in found.points}["left"] is False


def test_a_file_gives_places_and_axes(frame, tmp_path):
    elements, places = frame
    points, turn = turned({str(number): place for number, place in places.items()})
    axes = (turn.T).T.ravel()  # the sensors look along the model's axes, in the test's: columns of turn^T
    rows = [",".join([name, *(f"{x:.12g}" for x in 1e3 * place), *(f"{x:.12g}" for x in axes)]) for name, place in points.items()]
    (tmp_path / "points.csv").write_text("\n".join(rows) + "\n")
    found = kf.match_points(elements, tmp_path / "points.csv", unit=1e-3)
    assert found.fit.rms < 1e-9
    for point in found.points:
        assert abs(np.linalg.det(point.axes)) == pytest.approx(1.0)


def test_what_has_no_position_is_refused(frame):
    with pytest.raises(kf.InvalidInput, match="3 points"):
        kf.match_points(frame[0], {"a": (0, 0, 0), "b": (1, 0, 0), "c": (0, 1, 0)})
