"""One flight, written by every tool's own writer, becomes one recording."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from conversions import HEAD
from log_writers import KINDS, write_log
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.recordings.columns import written_unit
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import ConversionReport, convert_file
from orbident.recordings.topics.survey import survey_file
from orbident.recordings.topics.topic_map import load_topic_map, proposed_map

N = 50
T = np.arange(N) * 0.01
RNG = np.random.default_rng(20)
X_WS = Rotation.random(N, RNG)
GYRO = RNG.normal(size=(N, 3))
SENSOR = Rotation.from_quat([0.5, 0.5, 0.5, 0.5])
"""Rotation from the sensor's axes to the base's."""


def flight() -> dict[str, dict[str, np.ndarray]]:
    """Degrees, millimetres, a quaternion with its scalar first, y with a minus."""
    q = X_WS.as_quat()
    return {
        "imu": {
            "timestamp": np.round(T * 1e6),
            "w": np.degrees(GYRO) * [1, -1, 1],
            "q": q[:, [3, 0, 1, 2]],
            "angle": np.degrees(T),
            "x": 1e3 * T,
        }
    }


MAP = """\
  - topic: {topic}
    type: table
    stamp: {{timestamp: us}}
    take:
      gyro: deg/s
      attitude: quaternion
      joint.joint1.position: deg
      position: mm
    fields:
      gyro: [w.0, -w.1, w.2]
      attitude: [q.1, q.2, q.3, q.0]
      joint.joint1.position: -angle
      position: [x, 0, -x]
    rotation: [0.5, 0.5, 0.5, 0.5]
    point: S
"""


def near(found: np.ndarray, expected: np.ndarray, atol: float = 1e-12) -> None:
    """Whole nanoseconds, and some products and sums of float64."""
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=atol)


def converted(path: Path, entries: str) -> tuple[Recording, ConversionReport]:
    topic_map, out = path.parent / "map.yaml", path.parent / "recording.parquet"
    topic_map.write_text(HEAD + entries)
    report = convert_file(path, topic_map, out)
    return read_recording(out), report


@pytest.mark.parametrize("kind", KINDS)
def test_one_flight_in_every_format(tmp_path: Path, kind: str):
    path = write_log(kind, tmp_path, flight())
    topic = "/" if kind in {"csv", "parquet"} else "/imu"
    entries = MAP.format(topic=topic)
    recording, report = converted(path, entries)
    assert report.samples == N
    assert report.warnings == ()
    (used,) = report.topics
    assert (used.time, used.messages, used.used) == ("stamp", N, N)
    assert used.rate == pytest.approx(100, rel=1e-12)
    near(recording.t, T)
    near(recording.vector("gyro"), SENSOR.apply(GYRO))
    x_WB = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    np.testing.assert_allclose((x_WB * SENSOR * X_WS.inv()).magnitude(), 0, atol=1e-7)
    near(recording.column("joint.joint1.position"), -T)
    place = np.column_stack([T, 0 * T, -T])
    near(recording.vector("position"), place)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_in_it_and_a_proposal(tmp_path: Path, kind: str):
    surveyed = survey_file(write_log(kind, tmp_path, flight()))
    (found,) = [each for each in surveyed if each.topic.count]
    assert (found.topic.type, found.topic.count) == ("table", N)
    proposal = proposed_map(surveyed)
    assert "stamp: {timestamp: " in proposal
    for field in ("angle", "x", "w.0", "q.0"):
        assert field in proposal
    if kind == "ulog":
        assert "stamp: {timestamp: us}" in proposal
        assert found.rate == pytest.approx(100, rel=1e-12)


def test_a_proposal_of_our_own_names_converts(tmp_path: Path):
    path = tmp_path / "r.csv"
    head = "t,joint.a b.position,gyro.x,gyro.y,gyro.z,note\n"
    path.write_text(head + "0,1,2,3,4,start\n1,1,2,3,4,\n")
    proposal = proposed_map(survey_file(path))
    assert "# note holds text: 'start' in row 1" in proposal
    (tmp_path / "map.yaml").write_text(proposal)
    (entry,) = load_topic_map(tmp_path / "map.yaml")
    assert entry.columns == ("gyro.x", "gyro.y", "gyro.z", "joint.a b.position")
    convert_file(path, tmp_path / "map.yaml", tmp_path / "out.csv")
    recording = read_recording(tmp_path / "out.csv")
    np.testing.assert_array_equal(recording.vector("gyro")[0], [2, 3, 4])


def test_a_proposal_of_torques_and_currents_converts(tmp_path: Path):
    path = tmp_path / "r.csv"
    head = "t,joint.a.position,joint.a.velocity,joint.a.torque,joint.b.current"
    path.write_text(f"{head},note\n0,1,2,3,4,start\n1,1,2,3,4,\n")
    (tmp_path / "map.yaml").write_text(proposed_map(survey_file(path)))
    convert_file(path, tmp_path / "map.yaml", tmp_path / "out.csv")
    recording = read_recording(tmp_path / "out.csv")
    assert [column[0] for column in recording.columns.values()] == [1, 2, 3, 4]


def test_units_in_titles_of_currents_and_what_is_not_available(tmp_path: Path):
    path = tmp_path / "r.csv"
    path.write_text("t,joint.a.position,joint.a.current\ns,rad,mA\n0,1,2\n1,1,2\n")
    with pytest.raises(InputError, match=r"column 'joint\.a\.current' is in mA"):
        read_recording(path)
    assert written_unit("N/A") == ""


def test_attitudes_of_every_form(tmp_path: Path):
    """Modified Rodrigues parameters and angles, against SciPy's."""
    angles = X_WS.as_euler("ZYX")[:, ::-1]
    table = {"times": (T * 1e9).astype(np.uint64), "mrp": X_WS.as_mrp(), "rpy": angles}
    path = write_log("npz", tmp_path, {"a": table})
    for unit, field in (("mrp", "mrp"), ("rad", "rpy")):
        recording, _ = converted(
            path,
            "  - {topic: /a, type: table, stamp: {times: ns}, frame: base, "
            f"take: {{attitude: {unit}}}, fields: {{attitude: {field}}}}}\n",
        )
        x = Rotation.from_quat(recording.vector("attitude", "xyzw"))
        np.testing.assert_allclose((x * X_WS.inv()).magnitude(), 0, atol=1e-7)


SCALAR = "take: {joint.a.position: rad}, fields: {joint.a.position: %s}}\n"


def test_structs_in_structs_and_arrays_of_them(tmp_path: Path):
    """Simulink's "structure with time": values in a struct array, rows or columns."""
    signals = np.zeros(2, dtype=[("values", object), ("label", object)])
    signals["values"] = [T[:, None], np.tile(T, (3, 1))]
    signals["label"] = ["q", "w"]
    out = {"time": T, "signals": signals, "cells": np.array([T, {"q": T}], object)}
    savemat(tmp_path / "log.mat", {"out": out, "other": {"x": 1.0}, "name": "run"})
    surveyed = survey_file(tmp_path / "log.mat")
    assert [each.topic.name for each in surveyed] == ["/", "/out"]
    for field in ("signals.0.values", "signals.1.values.2", "cells.0", "cells.1.q"):
        recording, _ = converted(
            tmp_path / "log.mat",
            "  - {topic: /out, type: table, stamp: {time: s}, " + SCALAR % field,
        )
        near(recording.column("joint.a.position"), T, atol=0)


def test_hdf5_records_units_and_links(tmp_path: Path):
    rows = np.zeros(N, dtype=[("time", "f8"), ("q", "f8")])
    rows["time"], rows["q"] = T, 2 * T
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["run/rows"] = rows
        file["run/rows"].attrs["units"] = "s"
        file["run/again"] = file["run"]  # a group that contains itself
        file["run/elsewhere"] = h5py.ExternalLink("other.h5", "/x")
    recording, _ = converted(
        tmp_path / "log.h5",
        "  - {topic: /run/rows, type: table, stamp: {time: s}, " + SCALAR % "q",
    )
    np.testing.assert_array_equal(recording.column("joint.a.position"), 2 * T)


def test_numbers_that_are_always_the_same(tmp_path: Path):
    path = write_log("npz", tmp_path, {"a": {"t": T, "x": T}})
    recording, _ = converted(
        path,
        "  - {topic: /a, type: table, stamp: {t: s}, point: S, "
        "take: {position: mm, velocity: m/s},\n"
        "     fields: {position: [x, -2, 0.5], velocity: 0}}\n",
    )
    near(recording.vector("position")[5], np.array([T[5], -2, 0.5]) / 1e3)
    near(recording.vector("velocity")[5], np.zeros(3))


def test_second_instance_of_a_px4_topic(tmp_path: Path):
    stamps = np.arange(N) * 1e4
    tables = {
        "sensor": {"timestamp": stamps, "x": T},
        "sensor.1": {"timestamp": stamps, "x": 3 * T},
    }
    path = write_log("ulog", tmp_path, tables)
    recording, _ = converted(
        path,
        "  - {topic: /sensor.1, type: table, stamp: {timestamp: us}, " + SCALAR % "x",
    )
    near(recording.column("joint.a.position"), 3 * T)


def test_dates_of_parquet_are_times(tmp_path: Path):
    stamps = pa.array((T * 1e6).round().astype("datetime64[us]"))
    parquet.write_table(pa.table({"time": stamps, "q": T}), tmp_path / "log.parquet")
    (found,) = survey_file(tmp_path / "log.parquet")
    assert found.rate == pytest.approx(100, rel=1e-12)
    recording, _ = converted(
        tmp_path / "log.parquet",
        "  - {topic: /, type: table, stamp: {time: ns}, " + SCALAR % "q",
    )
    near(recording.t, T, atol=1e-12)


def test_semicolons_and_empty_cells(tmp_path: Path):
    path = tmp_path / "log.csv"
    path.write_text("time;q\n0;1\n0.5;\n1;nan\n1.5;4\n")
    recording, report = converted(
        path, "  - {topic: /, type: table, stamp: {time: s}, " + SCALAR % "q"
    )
    assert np.isnan(recording.column("joint.a.position")).tolist() == [0, 1, 1, 0]
    assert report.topics[0].not_finite == 2


REST = Path(__file__).parents[5] / "shared" / "data" / "cepheus-vicon-rest.mat"


@pytest.mark.skipif(
    not REST.exists(),
    reason="the laboratory's recording is not ours to copy, and is not here",
)
def test_a_real_file_of_a_laboratory(tmp_path: Path):
    """Beside the same numbers as the laboratory's CSV has them."""
    entries = (
        "  - {topic: /, type: table, stamp: {time: s}, frame: base, point: S,\n"
        "     take: {position: m, attitude: rad},\n"
        "     fields: {position: [x, y, 0], attitude: [0, 0, theta]}}\n"
    )
    tables = []
    for path, time in ((REST, "time"), (REST.with_suffix(".csv"), "t")):
        named = entries.replace("{time:", f"{{{time}:")
        (tmp_path / "map.yaml").write_text(HEAD + named)
        convert_file(path, tmp_path / "map.yaml", tmp_path / "r.parquet")
        tables.append(read_recording(tmp_path / "r.parquet"))
    assert tables[0].t.size == 18505
    for name, column in tables[0].columns.items():
        np.testing.assert_allclose(column, tables[1].columns[name], atol=1e-9)
