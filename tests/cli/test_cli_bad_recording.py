"""Trajectories and recordings that cannot be used."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from random_motions import random_motion
from running import LINEAR, Orbident, written

from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory_file import save_trajectory

IDENTIFY = ("identify", "paper-spatial", *LINEAR)


@pytest.fixture
def refusal(orbident: Orbident) -> Callable[..., str]:
    """The line with which `identify` refuses a recording of `paper-spatial`."""

    def refused(recording: object, *words: object) -> str:
        return orbident("identify", "paper-spatial", recording).refused(*words)

    return refused


Refusal = Callable[..., str]

NEEDED = [
    "joint.joint2.position",
    "gyro.x",
    "gyro.y",
    "gyro.z",
    "attitude.x",
    "attitude.w",
    "wheel.rw_y.speed",
]


@pytest.mark.parametrize("column", NEEDED)
@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_needed_column_is_missing(
    refusal: Refusal, flight: Recording, column: str, suffix: str
):
    path = written(flight, f"r.{suffix}", drop=[column])
    line = refusal(path, f"r.{suffix}: column '{column}' is missing", "add it")
    # What the column is for, with its unit.
    assert "(" in line


def test_validate_needs_the_same_columns(orbident: Orbident, flight: Recording):
    written(flight, "r.csv")
    orbident(*IDENTIFY, "r.csv", "-o", "run", "--quiet").done()
    written(flight, "s.csv", drop=["gyro.x"])
    orbident("validate", "run", "s.csv").refused("s.csv: column 'gyro.x' is missing")


def test_a_misspelt_column_is_recognised(refusal: Refusal, flight: Recording):
    renamed = {"gyroscope.x": flight.columns["gyro.x"]}
    path = written(flight, "r.csv", drop=["gyro.x"], replace=renamed)
    refusal(path, "'gyro.x' is missing", "'gyroscope.x'")


def test_unknown_joint_and_wheel(refusal: Refusal, flight: Recording):
    extra = np.zeros(flight.t.size)
    path = written(flight, "r.csv", replace={"joint.elbow.position": extra})
    refusal(path, "'joint.elbow.position'", "no joint 'elbow'", "joint1")
    path = written(flight, "r.csv", replace={"wheel.rw_w.speed": extra})
    refusal(path, "'wheel.rw_w.speed'", "no wheel 'rw_w'", "rw_x")


def test_too_few_samples(refusal: Refusal, flight: Recording):
    # 19 pi and 3 of momentum: 8 samples have 24 equations.
    path = written(flight, "r.csv", rows=slice(7))
    refusal(path, "r.csv", "7 complete samples", "at least 8 samples")


def test_no_complete_sample(refusal: Refusal, flight: Recording):
    never = {"gyro.x": np.full(flight.t.size, np.nan)}
    path = written(flight, "r.csv", replace=never)
    refusal(path, "r.csv", "gyro")


def test_no_position_at_all(refusal: Refusal, flight: Recording):
    never = {"joint.joint1.position": np.full(flight.t.size, np.nan)}
    path = written(flight, "r.csv", replace=never)
    refusal(path, "r.csv", "'joint.joint1.position'")


def test_no_complete_sample_to_predict(orbident: Orbident, flight: Recording):
    written(flight, "r.csv")
    orbident(*IDENTIFY, "r.csv", "-o", "run", "--quiet").done()
    never = {"gyro.x": np.full(flight.t.size, np.nan)}
    written(flight, "s.csv", replace=never)
    orbident("validate", "run", "s.csv").refused("s.csv: 0 complete samples")


HEADER = "t,joint.joint1.position"

MALFORMED = {
    "time goes back": (
        f"{HEADER}\n0,1\n2,1\n1,1\n",
        "row 3: 1.0 s does not come",
    ),
    "time stands": (f"{HEADER}\n0,1\n0,1\n", "row 2"),
    "NaN time": (f"{HEADER}\n0,1\nnan,1\n2,1\n", "column 't', row 2: found nan"),
    "empty time": (f"{HEADER}\n0,1\n,1\n2,1\n", "column 't', row 2"),
    "no time": ("time,joint.joint1.position\n0,1\n1,1\n", "column 't' is missing"),
    "one sample": (f"{HEADER}\n0,1\n", "samples"),
    "no samples": (f"{HEADER}\n", "r.csv"),
    "no names": ("0,1\n1,1\n2,1\n", "column names"),
    "a word": (f"{HEADER}\n0,1\n1,fast\n", "row 2: found 'fast'"),
    "an infinity": (f"{HEADER}\n0,1\n1,inf\n", "row 2: found inf"),
    "too many cells": (f"{HEADER}\n0,1\n1,1,1\n", "row 2 has 3 cells"),
    "too few cells": (f"{HEADER}\n0,1\n1\n2,1\n", "row 2 has 1 cells"),
    "a column twice": ("t,t\n0,1\n1,2\n", "'t'"),
    "semicolons": ("t;joint.joint1.position\n0;1\n1;1\n", "r.csv"),
    "empty": ("", "is empty"),
    "blank": ("\n\n", "is empty"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_malformed_csv(refusal: Refusal, case: str):
    text, words = MALFORMED[case]
    Path("r.csv").write_text(text)
    refusal("r.csv", "r.csv: ", words)


@pytest.mark.parametrize("content", [b"", b"\x00\xff\x80ELF" * 50, b"t,x\n0,1\n"])
def test_no_parquet(refusal: Refusal, content: bytes):
    Path("r.parquet").write_bytes(content)
    refusal("r.parquet", "r.parquet: ")


def test_binary_csv(refusal: Refusal):
    Path("r.csv").write_bytes(b"\x00\x01\xff\xfe\x80ELF" * 50)
    refusal("r.csv", "r.csv: is not UTF-8 text")


def test_truncated_parquet(refusal: Refusal, flight: Recording):
    path = written(flight, "r.parquet")
    path.write_bytes(path.read_bytes()[:-400])
    refusal(path, "r.parquet: ", "not a readable Parquet file")


def test_no_such_recording(refusal: Refusal):
    refusal("gone.csv", "gone.csv: does not exist")
    refusal("gone.bag", "gone.bag: the name of a recording ends in .csv or .parquet")
    Path("folder.csv").mkdir()
    refusal("folder.csv", "folder.csv: is a folder")


@pytest.mark.parametrize("scale", [0.9, 1e-3, 1e200])
def test_attitudes_must_be_unit_quaternions(
    refusal: Refusal, flight: Recording, scale: float
):
    wrong = {f"attitude.{k}": flight.columns[f"attitude.{k}"].copy() for k in "xyzw"}
    for column in wrong.values():
        column[5] *= scale
    path = written(flight, "r.csv")
    text = path.read_text().splitlines()
    names = text[0].replace('"', "").split(",")
    cells = text[6].split(",")
    for name, column in wrong.items():
        cells[names.index(name)] = repr(float(column[5]))
    path.write_text("\n".join([*text[:6], ",".join(cells), *text[7:]]))
    refusal(path, "columns 'attitude.x' to '.w', row 6: norm", "scalar last")


JOINTS = "joints: {joint1: {}, joint2: {}, joint3: {}}\n"

TRAJECTORIES = {
    "unknown joint": ("joints: {joint1: {}, joint2: {}, elbow: {}}\n", "elbow"),
    "missing joint": ("joints: {joint1: {}, joint2: {}}\n", "joint3"),
    "unknown wheel": (JOINTS + "initial: {wheel_speed: {rw_w: 3}}\n", "rw_w"),
    "unknown key": (JOINTS + "initial: {wheel_speeds: {rw_x: 3}}\n", "wheel_speeds"),
    "no unit quaternion": (
        JOINTS + "initial: {attitude: [0, 0, 1, 1]}\n",
        "initial.attitude",
    ),
    "a without b": ("joints: {joint1: {a: [1]}, joint2: {}, joint3: {}}\n", "joint1"),
    "no numbers": (
        "joints: {joint1: {a: [x], b: [1]}, joint2: {}, joint3: {}}\n",
        "joints.joint1.a",
    ),
    "no joints": ("", "joints"),
}


@pytest.mark.parametrize("case", TRAJECTORIES)
def test_malformed_trajectory(orbident: Orbident, case: str):
    lines, words = TRAJECTORIES[case]
    Path("m.yaml").write_text(f"schema: orbident/trajectory/1\nduration: 4\n{lines}")
    orbident("simulate", "paper-spatial", "m.yaml", "-o", "r.csv").refused(
        "m.yaml:", words
    )
    assert not Path("r.csv").exists()


@pytest.mark.parametrize("duration", ["0", "-1", ".nan", ".inf", "long", "[1]"])
def test_duration_of_a_trajectory(orbident: Orbident, duration: str):
    Path("m.yaml").write_text(
        f"schema: orbident/trajectory/1\nduration: {duration}\n{JOINTS}"
    )
    orbident("simulate", "paper-spatial", "m.yaml", "-o", "r.csv").refused(
        "m.yaml:2: duration"
    )


def test_trajectory_of_another_kind(orbident: Orbident):
    run = ("simulate", "paper-spatial")
    orbident(*run, "gone.yaml", "-o", "r.csv").refused("gone.yaml: ")
    Path("folder").mkdir()
    orbident(*run, "folder", "-o", "r.csv").refused("folder: is a folder")
    Path("binary").write_bytes(b"\x00\xff" * 99)
    orbident(*run, "binary", "-o", "r.csv").refused("binary: ", "UTF-8")
    Path("robot.yaml").write_text("schema: orbident/robot/1\nurdf: x.urdf\n")
    orbident(*run, "robot.yaml", "-o", "r.csv").refused("robot.yaml:2: unknown key")


@pytest.mark.parametrize("rate", ["0", "-5", "nan", "inf", "1e-9", "1e12"])
def test_rate_of_a_simulation(orbident: Orbident, rate: str):
    save_trajectory(random_motion(load_robot("paper-spatial"), duration=4.0), "m.yaml")
    orbident(
        "simulate", "paper-spatial", "m.yaml", "-o", "r.csv", "--rate", rate
    ).refused("rate")
    assert not Path("r.csv").exists()


def test_a_base_that_turns_too_fast(orbident: Orbident):
    Path("m.yaml").write_text(
        "schema: orbident/trajectory/1\nduration: 4\n"
        + JOINTS
        + "initial: {angular_velocity: [1.0e+6, 0, 0]}\n"
    )
    orbident("simulate", "paper-spatial", "m.yaml", "-o", "r.csv").refused("turns")


def test_a_planar_robot_stays_in_its_plane(orbident: Orbident):
    Path("m.yaml").write_text(
        "schema: orbident/trajectory/1\nduration: 4\njoints: {joint1: {}, joint2: {}}\n"
        "initial: {angular_velocity: [0.1, 0, 0]}\n"
    )
    orbident("simulate", "cepheus-like", "m.yaml", "-o", "r.csv").refused(
        "m.yaml", "plane"
    )


def test_a_dead_gyro_is_named(refusal: Refusal, flight: Recording):
    still = {f"gyro.{k}": np.full(flight.t.size, 0.01) for k in "xyz"}
    path = written(flight, "r.csv", replace=still)
    refusal(path, "r.csv: column 'gyro.x' is 0.01 throughout", "joint 'joint1' moves")


def test_a_dead_attitude_is_named(refusal: Refusal, flight: Recording):
    still = {f"attitude.{k}": np.full(flight.t.size, float(k == "w")) for k in "xyzw"}
    path = written(flight, "r.csv", replace=still)
    refusal(path, "column 'attitude.x' is 0 throughout", "is the sensor dead")


def test_spikes_are_left_out_and_counted(orbident: Orbident, flight: Recording):
    spiky = flight.columns["gyro.z"].copy()
    spiky[[100, 300, 301]] += 2.0
    path = written(flight, "r.csv", replace={"gyro.z": spiky})
    ran = orbident(*IDENTIFY, path, "--json", "-")
    assert ran.status == 0
    assert ran.json["rejected"] == {"gyro.z": {"spike": 3}}
    assert "gyro.z: 3 spikes left out" in ran.err
