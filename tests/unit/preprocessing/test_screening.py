import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.preprocessing.screening import rejected_in_words, screened
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

ROBOT = load_robot("paper-spatial")
FLIGHT = simulate(ROBOT, random_motion(ROBOT), rate=20.0)
N = FLIGHT.t.size


def changed(**columns):
    named = {name.replace("__", "."): values for name, values in columns.items()}
    return Recording(FLIGHT.t, {**FLIGHT.columns, **named}, source="flight.csv")


def test_a_clean_recording_is_returned_as_it_is():
    found = screened(ROBOT, FLIGHT)
    assert found.recording is FLIGHT
    assert found.rejected == {}


def test_a_spike_is_taken_out_with_the_other_components_and_counted():
    gyro = FLIGHT.columns["gyro.y"].copy()
    gyro[[200, 500]] += 1.0
    found = screened(ROBOT, changed(gyro__y=gyro))
    assert found.rejected == {"gyro.y": {"spike": 2}}
    for k in "xyz":
        column = found.recording.columns[f"gyro.{k}"]
        np.testing.assert_array_equal(np.flatnonzero(np.isnan(column)), [200, 500])
    same = found.recording.columns["attitude.x"]
    assert np.shares_memory(same, FLIGHT.columns["attitude.x"])
    assert rejected_in_words(found.rejected) == ("gyro.y: 2 spikes left out",)


def test_the_recording_given_is_left_alone():
    q = FLIGHT.columns["joint.joint1.position"].copy()
    q[100] += 2.0
    recording = changed(joint__joint1__position=q)
    screened(ROBOT, recording)
    assert np.isfinite(recording.columns["joint.joint1.position"]).all()


@pytest.mark.parametrize("component", "xyz")
def test_a_stuck_gyro_axis_is_named(component):
    recording = changed(**{f"gyro__{component}": np.full(N, 0.0125)})
    with pytest.raises(
        InputError, match=rf"flight.csv: column 'gyro.{component}' is 0.0125 throughout"
    ):
        screened(ROBOT, recording)


@pytest.mark.parametrize("sensor", ["gyro", "attitude", "position", "velocity"])
def test_a_dead_sensor_is_named(sensor):
    dead = {
        f"{sensor}__{k}": np.full(N, float(k == "w"))
        for k in ("xyzw" if sensor == "attitude" else "xyz")
    }
    with pytest.raises(InputError, match=rf"column '{sensor}.x' is 0 throughout"):
        screened(ROBOT, changed(**dead))


def test_where_no_joint_moves_nothing_needs_to_change():
    still = {f"joint__joint{k}__position": np.zeros(N) for k in (1, 2, 3)}
    assert not screened(ROBOT, changed(gyro__x=np.zeros(N), **still)).rejected


def test_in_the_plane_two_axes_rest():
    robot = load_robot("cepheus-like")
    flight = simulate(robot, random_motion(robot, wheel_speed=-170.0), rate=20.0)
    assert not np.ptp(flight.columns["gyro.x"])
    assert not screened(robot, flight).rejected


def test_an_angle_beyond_the_stops_is_warned_of_with_place_and_count():
    q = FLIGHT.columns["joint.joint2.position"].copy()
    q[300:310] = 5.0
    (note,) = screened(ROBOT, changed(joint__joint2__position=q)).notes
    assert note.startswith(
        "column 'joint.joint2.position': 10 of 801 samples beyond the joint's range "
        "-4 to 4, the first 5 at t = 15 s; check the encoder's zero"
    )


def test_degrees_are_refused():
    q = np.degrees(FLIGHT.columns["joint.joint2.position"])
    with pytest.raises(
        InputError, match=r"beyond the joint's range -4 to 4.*in degrees: give rad"
    ):
        screened(ROBOT, changed(joint__joint2__position=q))


def test_forces_may_jump():
    force = np.zeros(N)
    force[300:303] = 5.0
    columns = {"force__x": force, "force__y": 0 * force, "force__z": 0 * force}
    assert not screened(ROBOT, changed(**columns)).rejected


TABLE = load_robot("cepheus-like")
SPUN_UP = simulate(TABLE, random_motion(TABLE, start="spun up"), rate=20.0)


def with_attitude(*order):
    x = dict(zip("xyzw", order, strict=True))
    columns = {f"attitude.{k}": SPUN_UP.columns[f"attitude.{x[k]}"] for k in "xyzw"}
    return Recording(SPUN_UP.t, {**SPUN_UP.columns, **columns}, source="table.csv")


def test_a_quaternion_with_its_scalar_first_is_named():
    words = (
        r"table\.csv: columns 'attitude\.x' to '\.w' tilt the base by up to \d+ deg, "
        r"but 'cepheus-like' moves in a plane .* scalar first: put the first number"
    )
    with pytest.raises(InputError, match=words):
        screened(TABLE, with_attitude(*"wxyz"))


def test_an_attitude_that_leaves_the_plane_is_refused():
    with pytest.raises(InputError, match=r"tilt the base .* z up; or say 'motion: spa"):
        screened(TABLE, with_attitude(*"yzxw"))


def test_single_wrong_attitudes_of_the_plane_are_left_to_others():
    x, w = (SPUN_UP.columns[f"attitude.{k}"].copy() for k in "xw")
    x[100:110], w[100:110] = w[100:110].copy(), x[100:110].copy()
    columns = {**SPUN_UP.columns, "attitude.x": x, "attitude.w": w}
    screened(TABLE, Recording(SPUN_UP.t, columns))
