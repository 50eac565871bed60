"""Data frames and short words of results, recordings and robots."""

import sys

import numpy as np
import pytest
from made_results import exact_result, without

from orbident.extras import MissingLibraryError
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot

NAN = float("nan")

RECORDING = Recording(
    np.array([0.0, 0.5, 1.5]),
    {
        "gyro.x": np.array([1.0, 2.0, 3.0]),
        "gyro.y": np.array([4.0, 5.0, 6.0]),
        "joint.elbow.position": np.array([0.1, NAN, 0.2]),
        "note": np.zeros(3),
    },
    source="flight.csv",
)


def test_a_result_as_a_frame():
    pytest.importorskip("pandas")
    result = without(exact_result(load_robot("cepheus-like")), "iota_2")
    frame = result.to_frame()
    assert list(frame.index) == list(result.base.names)
    assert frame.index.name == "parameter"
    assert list(frame.columns) == [
        *("value", "std", "nominal", "sigmas", "percent", "unit", "formula"),
    ]
    M = frame.loc["M"]
    assert M["value"] == result.base.values[0]
    assert M["unit"] == "kg"
    assert M["sigmas"] == pytest.approx(0.0, abs=1e-3)
    assert frame.loc["iota_2", ["value", "std"]].isna().all()
    assert len(result.pi.to_frame()) == 0


def test_a_recording_as_a_frame():
    pytest.importorskip("pandas")
    frame = RECORDING.to_frame()
    assert frame.index.name == "t"
    assert list(frame.index) == [0.0, 0.5, 1.5]
    assert list(frame.columns) == list(RECORDING.columns)
    assert frame["joint.elbow.position"].isna().sum() == 1
    # The frame is the reader's own: the recording cannot be changed through it.
    frame.loc[0.5, "gyro.x"] = 7.0
    assert RECORDING.columns["gyro.x"][1] == 2.0


def test_without_pandas(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    words = r'^to_frame\(\) needs pandas: pip install "orbident\[pandas\]"$'
    with pytest.raises(MissingLibraryError, match=words):
        RECORDING.to_frame()
    with pytest.raises(MissingLibraryError, match=words):
        exact_result(load_robot("cepheus-like")).to_frame()


def test_a_recording_in_words():
    assert repr(RECORDING).splitlines() == [
        "flight.csv: 3 rows, t = 0 to 1.5 s",
        "  gyro.x, .y: 3 samples",
        "  joint.elbow.position: 2 samples",
        "  note: 3 samples",
    ]


def test_a_robot_in_words():
    words = "paper-spatial: spatial, 3 joints, 3 wheels, 1110 kg nominal"
    assert repr(load_robot("paper-spatial")) == words
