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


def within_one_turn(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi


@pytest.mark.parametrize("speed", [-50.0, 900.0])
def test_a_wheel_counted_within_one_turn_is_counted_on_by_its_speed(speed):
    """With 900 rad/s it makes more than one turn from one sample to the next."""
    angle = 0.3 + speed * FLIGHT.t
    columns = {
        "wheel__rw_x__position": within_one_turn(angle),
        "wheel__rw_x__speed": np.full(N, 1.001 * speed),
    }
    found = screened(ROBOT, changed(**columns)).recording
    np.testing.assert_allclose(found.columns["wheel.rw_x.position"], angle, atol=1e-8)


def test_a_wheel_counted_within_one_turn_that_spins_up():
    t = FLIGHT.t - FLIGHT.t[0]
    angle = 0.3 + 100.0 * np.where(t < 1.0, 0.0, (t - 1.0) ** 2 / 2)
    columns = {name: x for name, x in FLIGHT.columns.items() if "rw_x" not in name}
    columns["wheel.rw_x.position"] = within_one_turn(angle)
    found = screened(ROBOT, Recording(FLIGHT.t, columns)).recording
    np.testing.assert_allclose(found.columns["wheel.rw_x.position"], angle, atol=1e-8)


def test_how_often_a_wheel_turned_is_not_guessed():
    """Accepted before, with a mass that was wrong by a factor."""
    columns = {name: x for name, x in FLIGHT.columns.items() if "rw_x" not in name}
    columns["wheel.rw_x.position"] = within_one_turn(0.3 - 50.0 * FLIGHT.t)
    with pytest.raises(InputError, match=r"give 'wheel.rw_x.speed' too"):
        screened(ROBOT, Recording(FLIGHT.t, columns))


@pytest.mark.parametrize("low", [-np.pi, 0.0, -np.pi / 2])
def test_a_joint_shown_within_one_turn_is_counted_on(low):
    q = 3.5 * np.sin(0.2 * FLIGHT.t) + 0.3
    columns = {"joint.joint2.position": (q - low) % (2 * np.pi) + low}
    columns["joint.joint2.velocity"] = 0.7 * np.cos(0.2 * FLIGHT.t)
    found = screened(ROBOT, FLIGHT.with_columns(columns))
    shown = found.recording.columns["joint.joint2.position"]
    np.testing.assert_allclose(shown, q, atol=1e-9)
    (note,) = found.notes
    assert note.startswith(
        "column 'joint.joint2.position' leaps by a turn: whole turns"
    )


def test_a_rate_that_is_none_is_not_used():
    found = screened(ROBOT, changed(joint__joint2__velocity=np.zeros(N)))
    assert found.notes == (
        "column 'joint.joint2.velocity' is not the rate of the joint's position: it is "
        "0 throughout; it is not used",
    )
    assert not found.recording.has("joint.joint2.velocity")
    assert found.recording.has("joint.joint1.velocity")


def test_impossible_values_of_a_lone_gyro_are_taken_out_at_both_ends_too():
    w = FLIGHT.columns["gyro.y"].copy()
    w[[0, 1, 300, N - 1]] = -9999
    found = screened(ROBOT, changed(gyro__y=w))
    assert rejected_in_words(found.rejected) == (
        "gyro: 4 samples with the impossible value -9999 left out",
    )
    assert np.isnan(found.recording.vector("gyro")[[0, 1, 300, N - 1]]).all()


def test_a_saturated_gyro_is_named():
    w = FLIGHT.columns["gyro.y"]
    end = 0.8 * np.abs(w).max()
    found = screened(ROBOT, changed(gyro__y=np.clip(w, -end, end)))
    ((name, (reason,)),) = found.rejected.items()
    assert name == "gyro.y"
    assert reason.startswith("sample saturated at")
    gone = np.isnan(found.recording.columns["gyro.y"])
    np.testing.assert_array_equal(gone, np.abs(w) >= end)


def test_rows_that_repeat_are_found_also_where_wheels_turn_evenly():
    held = {
        name: column[np.arange(N) // 2 * 2] for name, column in FLIGHT.columns.items()
    }
    held["wheel.rw_x.position"] = 50.0 * FLIGHT.t[np.arange(N) // 2 * 2]
    found = screened(ROBOT, FLIGHT.with_columns(held))
    assert found.rejected == {"rows": {"repeat of the sample before": N // 2}}


@pytest.mark.parametrize("seed", range(3))
def test_rows_of_zeros_are_no_samples(seed: int):
    """Some stand where a column goes through zero, some at the end, or in a row; in the
    first second joints and S are still near zero, so that nothing tells."""
    lost = (np.random.default_rng(seed).random(N) < 0.02) & (FLIGHT.t > 1.0)
    lost[[200, 201, 202, -2, -1]] = True
    zeros = {name: np.where(lost, 0.0, x) for name, x in FLIGHT.columns.items()}
    found = screened(ROBOT, FLIGHT.with_columns(zeros))
    assert found.rejected == {"rows": {"sample of zeros alone": lost.sum()}}
    for column in found.recording.columns.values():
        np.testing.assert_array_equal(np.isnan(column), lost)


def test_zeros_that_follow_zeros_are_no_repeats():
    """Each row that is left out is counted once."""
    held = np.arange(N) % 4 == 1
    lost = np.isin(np.arange(N), [201, 202, 203, 204, 300])
    columns = {}
    for name, x in FLIGHT.columns.items():
        again = np.where(held, np.roll(x, 1), x)
        columns[name] = np.where(lost, 0.0, again)
    found = screened(ROBOT, FLIGHT.with_columns(columns))
    assert found.rejected["rows"] == {
        "sample of zeros alone": lost.sum(),
        "repeat of the sample before": (held & ~lost & ~np.roll(lost, 1)).sum(),
    }


@pytest.mark.parametrize("count", [0.0, 1e-3])
@pytest.mark.parametrize("rests", [1, 100])
def test_a_robot_that_rests_at_zero_keeps_its_rows(rests: int, count: float):
    """At first, in between and at last; it leaves smoothly, its rates also at once."""
    t = np.arange(0.0, 10.0, 0.01)
    moving = np.arange(t.size) % 500 - rests
    s = np.clip(moving / (500 - 2 * rests), 0, 1)
    columns = {
        "joint.joint1.position": 0.3 * np.sin(np.pi * s) ** 2,
        "wheel.rw_x.position": 20.0 * np.sin(2 * np.pi * s),
        "gyro.x": -0.05 * (np.sin(np.pi * s) > 0),
        "gyro.y": 0.02 * np.sin(2 * np.pi * s),
        "gyro.z": np.zeros(t.size),
    }
    if count:
        columns = {name: count * np.round(x / count) for name, x in columns.items()}
    assert "rows" not in screened(ROBOT, Recording(t, columns)).rejected


@pytest.mark.parametrize("name", ["attitude.y", "joint.joint1.position", "gyro.x"])
def test_a_column_that_is_empty_is_named(name: str):
    """One attitude beside a gyro is enough, though."""
    first = np.arange(N) < 1
    x = np.where(first, FLIGHT.columns[name], np.nan)
    screened(ROBOT, FLIGHT.with_columns({name: x}))
    x[first] = np.nan
    with pytest.raises(InputError, match=f"column '{name}' has no number in any row"):
        screened(ROBOT, FLIGHT.with_columns({name: x}))


def test_quaternions_of_zeros_are_noted():
    x = {name: FLIGHT.columns[name].copy() for name in FLIGHT.columns if "att" in name}
    for column in x.values():
        column[200:210] = 0.0
    found = screened(ROBOT, FLIGHT.with_columns(x))
    assert found.notes == (
        "attitude: 10 quaternions of zeros left out, the first at t = 10 s",
    )
    assert np.isnan(found.recording.columns["attitude.w"]).sum() == 10
