"""An orbit in the robot file, from the command line; what is wrong is one line."""

from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
from ephemeris_files import write_oem
from processes import ORBIDENT, finished
from running import Orbident
from urdf_pieces import robot_file

from orbident.orbits.orbit import Elements
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording, write_recording
from orbident.robot.robot_file import load_robot

MOTION = """\
schema: orbident/trajectory/1
duration: 20
joints:
  joint1: {a: [0.3, -0.2], b: [0.2, 0.3]}
  joint2: {a: [-0.2, 0.3], b: [0.3, -0.1]}
initial: {angular_velocity: [0.02, 0.03, 0.01], wheel_speed: {rw_x: 200, rw_z: 100}}
"""
ROBOT = """\
wheels:
  - {name: rw_x, axis: [1, 0, 0], inertia: 0.05}
  - {name: rw_z, axis: [0, 0, 1], inertia: 0.05}
torquers: [{name: mx, axis: [1, 0, 0]}]
sensors:
  rate: 10
  gyro: {angle_random_walk: 0.01 deg/sqrt(h)}
  joints: {position: 2e-5}
  wheels: {position: 2e-5}
  attitude: {angle: 10 arcsec}
  position: {std: 0.2 mm}
"""
CIRCLE = "altitude: 400 km, inclination: 51.6 deg"
ATTITUDE = [f"attitude.{axis}" for axis in "xyzw"]
DATED = f"{CIRCLE}, epoch: 2026-03-01T12:00:00Z"


def robot(orbit: str) -> Path:
    return robot_file(Path.cwd(), lines=f"{ROBOT}orbit: {{{orbit}}}\n")


def bare(recording: Recording) -> Recording:
    """Without what the orbit tells."""
    told = ("nadir", "flow", "sun", "field")
    kept = {n: x for n, x in recording.columns.items() if not n.startswith(told)}
    return Recording(recording.t, kept, source="bare.csv")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """What the robot's sensors show of 20 s in the tide of its orbit."""
    with chdir(tmp_path_factory.mktemp("flown")):
        Path("m.yaml").write_text(MOTION)
        simulate = ("simulate", robot(DATED), "m.yaml", "--noise", "sensors")
        ran = finished(*ORBIDENT, *simulate, "-o", "r.csv")
        assert (ran.returncode, ran.stderr) == (0, "")
        recording = read_recording("r.csv")
    assert recording.has("nadir.x", "flow.x", "field.x")
    return recording


def test_a_robot_is_identified_in_its_orbit(orbident: Orbident, flown: Recording):
    write_recording(bare(flown), "bare.csv")
    ran = orbident("identify", robot(DATED), "bare.csv", "-o", "run", "--json", "-")
    assert ran.status == 0, ran.err
    assert not ran.json["disturbances"]
    kept = load_robot("run/robot.yaml")
    assert kept.orbit is not None
    assert kept.orbit.epoch is not None


@pytest.mark.parametrize(
    ("orbit", "columns", "words"),
    [
        (DATED, {"torquer.my.dipole": 1.0}, "no torquer 'my', only 'mx'"),
        (CIRCLE, {"torquer.mx.dipole": 1.0}, "without the magnetic field"),
        (DATED, dict.fromkeys(ATTITUDE), "nobody knows where the Earth is"),
        (
            "oem: flight.oem, epoch: 2026-03-01T12:00:00Z",
            {},
            "and the recording is from 0 to 20 s; give an OEM that covers it",
        ),
        (
            "semi_major_axis: 6800 km, eccentricity: 0.1, inclination: 0, perigee: 0",
            {},
            "orbit: the orbit is below the ground",
        ),
        (f"{CIRCLE}, nodes: 0", {}, "orbit: unknown key 'nodes'; did you mean 'node'"),
        ("altitude: 400, inclination: 0", {}, "found 400; it has no unit"),
        (f"{CIRCLE}, epoch: noon", {}, "found 'noon'; give a date and time in UTC"),
    ],
    ids=[
        *("stranger", "no field", "no attitude", "short OEM", "below the ground"),
        *("unknown key", "no unit", "no date"),
    ],
)
def test_what_is_wrong_is_one_line(
    orbident: Orbident, flown: Recording, orbit: str, columns: dict, words: str
):
    t = np.array([0.0, 5.0, 10.0])
    known = load_robot(robot(DATED)).orbit
    assert known is not None
    assert known.epoch is not None
    states = Elements(6.8e6, 0.9).states(t)
    write_oem(Path("flight.oem"), known.epoch, t, states)
    kept = {n: x for n, x in bare(flown).columns.items() if n not in columns}
    more = {n: 0 * flown.t + x for n, x in columns.items() if x is not None}
    write_recording(Recording(flown.t, {**kept, **more}), "wrong.csv")
    orbident("identify", robot(orbit), "wrong.csv").refused(words)
