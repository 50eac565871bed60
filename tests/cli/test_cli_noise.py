"""`noise`: what a recording at rest tells of its sensors."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from random_motions import random_motion
from running import Orbident, written
from scipy.spatial.transform import Rotation

from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import AttitudeSpec, PositionSpec, declared_sensors
from orbident.simulation.sensor import read_attitude, read_position
from orbident.simulation.simulate import simulate

RATE = 50.0
POSITION = {"std": 1e-5, "markov_std": 3e-5, "correlation_time": 0.4}
ATTITUDE = {"angle": 6e-5}


@pytest.fixture(scope="module")
def rest() -> Recording:
    """A robot on a table: z does not vary, nor does the tilt."""
    n = 1500
    random = np.random.default_rng(0)
    level = Rotation.from_rotvec([0.0, 0.0, 0.4]).as_quat()
    position = PositionSpec.model_validate(POSITION)
    r = read_position(position, np.ones((n, 3)), 1 / RATE, random)
    attitude = AttitudeSpec.model_validate(ATTITUDE)
    x = read_attitude(attitude, np.tile(level, (n, 1)), 1 / RATE, random)
    r[:, 2] = 0.0
    x[:, :2] = 0.0
    columns = {f"position.{k}": r[:, i] for i, k in enumerate("xyz")}
    columns |= {f"attitude.{k}": x[:, i] for i, k in enumerate("xyzw")}
    return Recording(np.arange(n) / RATE, columns)


def test_the_section_that_is_written_is_one_of_a_robot_file(
    orbident: Orbident, rest: Recording, tmp_path
):
    out, plot = tmp_path / "sensors.yaml", tmp_path / "allan.html"
    file = written(rest, tmp_path / "rest.csv")
    ran = orbident("noise", file, "-o", out, "--plot", plot, "--json", "-").done()
    sensors = yaml.safe_load(out.read_text())["sensors"]
    assert sensors == ran.json["sensors"]
    # 1500 samples: 2 %; 75 independent values of what lasts: 8 % and 20 %.
    assert sensors["position"]["std"] == pytest.approx(1e-5, rel=0.1)
    declared = declared_sensors(sensors).of("position").coloured
    assert declared.markov_std == pytest.approx([3e-5, 3e-5, 0.0], rel=0.35)
    assert declared.correlation_time[:2] == pytest.approx([0.4, 0.4], rel=0.7)
    assert set(sensors["attitude"]) == {"angle"}
    assert sensors["attitude"]["angle"] == pytest.approx(6e-5, rel=0.1)
    assert set(ran.json["axes"]) == {"position.x", "position.y", "attitude.z"}
    x = ran.json["axes"]["position.x"]["markov_std"]
    assert x["interval_95"][0] < x["value"] < x["interval_95"][1]
    assert "Allan deviation" in plot.read_text()
    robot = tmp_path / "robot.yaml"
    urdf = load_robot("cepheus-like")
    assert urdf.motion == "planar"
    robot.write_text(
        yaml.safe_dump(
            {"schema": "orbident/robot/1", "name": "r", "urdf": "r.urdf"}
            | {"sensors": sensors}
        )
    )
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="base"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link></robot>"
    )
    assert load_robot(robot).sensors == declared_sensors(sensors)


def test_the_table_names_each_part(orbident: Orbident, rest: Recording, tmp_path):
    words = orbident("noise", written(rest, tmp_path / "rest.parquet")).done().out
    for part in ("position.x  markov_std", "position.y  white", "attitude.z  white"):
        assert part in words
    assert "position.z" not in words
    assert "sensors:" in words


def test_a_flight_is_refused(orbident: Orbident, tmp_path):
    camera = declared_sensors({"position": {"std": 1e-4}})
    robot = replace(load_robot("cepheus-like"), sensors=camera)
    flight = simulate(robot, random_motion(robot), rate=RATE, noise="sensors")
    file = written(flight, tmp_path / "flight.csv")
    orbident("noise", file).refused("joint.joint1.position moves", "at rest")
    file = written(flight, tmp_path / "flight.csv", drop=("joint",))
    orbident("noise", file).refused("position.x moves", "give a recording at rest")


@pytest.mark.parametrize(
    ("velocity", "swing"), [(3e-5, 0.0), (1e-3, 0.0), (0.0, 1e-2), (0.0, 1e-3)]
)
def test_slow_motion_is_refused(
    orbident: Orbident, rest: Recording, tmp_path, velocity, swing
):
    random = np.random.default_rng(1)
    t = rest.t
    x = velocity * t + swing * np.sin(2 * np.pi * 0.1 * t)
    moving = {"position.x": x + 1e-5 * random.standard_normal(t.size)}
    file = written(rest, tmp_path / "slow.csv", drop=("attitude",), replace=moving)
    orbident("noise", file).refused("position.x moves")


def test_what_says_nothing_is_refused(orbident: Orbident, rest: Recording, tmp_path):
    few = written(rest, tmp_path / "few.csv", rows=slice(100))
    orbident("noise", few).refused("has 100 samples; give at least 200")
    strange = Recording(rest.t, {"x": rest.columns["position.x"]})
    file = written(strange, tmp_path / "strange.csv")
    orbident("noise", file).refused("found no samples that vary", "position.x")
    file = written(rest, tmp_path / "rest.csv")
    orbident("noise", file, "-o", tmp_path / "no" / "s.yaml").refused("does not exist")


def test_spikes_are_left_out_and_jumps_are_refused(
    orbident: Orbident, rest: Recording, tmp_path
):
    x = rest.columns["position.x"].copy()
    x[[100, 700, 701]] += 0.1
    file = written(rest, tmp_path / "s.csv", ("attitude",), {"position.x": x})
    ran = orbident("noise", file, "--json", "-")
    assert "warning: position.x" in ran.err
    found = ran.json["axes"]["position.x"]
    # The filter has taken up some of a spike, so that a neighbour may be left out too.
    assert 3 <= found["left_out"] <= 6
    assert f"{found['left_out']} samples are spikes and left out" in ran.err
    assert found["white"]["value"] == pytest.approx(1e-5, rel=0.1)
    assert found["samples"] + found["left_out"] == x.size
    x[800:] += 0.1
    file = written(rest, tmp_path / "s.csv", ("attitude",), {"position.x": x})
    orbident("noise", file).refused("position.x jumps")


def test_what_the_model_does_not_explain_is_warned_of(orbident: Orbident, tmp_path):
    """A table that sways."""
    t = 0.01 * np.arange(6000)
    x = 1e-5 * np.random.default_rng(2).standard_normal(t.size)
    x += 4e-5 * np.sin(2 * np.pi * 0.5 * t)
    columns = {"position.x": x, "position.y": 0 * t, "position.z": 0 * t}
    ran = orbident("noise", written(Recording(t, columns), tmp_path / "s.csv"))
    assert ran.status == 0
    assert "position.x: at low frequencies it has 1.7 times" in ran.err
    assert ran.err.count("\n") == 1
