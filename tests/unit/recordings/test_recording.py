import pickle
import re
from dataclasses import replace

import jaxtyping
import numpy as np
import pytest

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.robot.description import Coupling, Joint, Robot, Wheel

T = np.array([0.0, 0.1, 0.2])
UNIT = {f"attitude.{k}": np.full(3, float(k == "w")) for k in "xyzw"}


@pytest.fixture
def as_installed(monkeypatch):
    """Users run without the shape checks that these tests switch on."""
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)


def recording(**columns):
    named = {name.replace("__", "."): values for name, values in columns.items()}
    return Recording(T, named, source="flight.csv")


def robot(joints=("arm.1", "arm.2"), wheels=("rw_x",)):
    eye, zero, z = np.eye(3), np.zeros(3), np.array([0.0, 0.0, 1.0])
    return Robot(
        name="servicer",
        motion="spatial",
        bodies=("base", *joints),
        joints=tuple(
            Joint(name, "revolute", k, z, eye, zero) for k, name in enumerate(joints)
        ),
        theta=np.zeros((len(joints) + 1, 10)),
        feature_point=zero,
        wheels=tuple(Wheel(name, z, 0.1) for name in wheels),
    )


def test_holds_views_not_copies():
    x = np.arange(3.0)
    rec = recording(extra=x)
    assert np.shares_memory(rec.columns["extra"], x)
    assert np.shares_memory(rec.column("extra"), x)
    assert not rec.columns["extra"].flags.writeable
    assert x.flags.writeable


@pytest.mark.usefixtures("as_installed")
def test_integers_become_floats():
    rec = Recording(np.arange(3), {"n": np.arange(3, dtype=np.int16)})
    assert rec.t.dtype == rec.columns["n"].dtype == np.float64


def test_vector_keeps_the_order_of_its_components():
    rec = recording(gyro__y=T + 1, gyro__x=T, gyro__z=T + 2, **UNIT)
    np.testing.assert_array_equal(rec.vector("gyro")[0], [0, 1, 2])
    np.testing.assert_array_equal(rec.vector("attitude", "xyzw")[0], [0, 0, 0, 1])


def test_between_has_both_ends():
    cut = recording(gyro__x=np.array([1.0, 2.0, 3.0])).between(0.1, 0.2)
    assert cut.t.tolist() == [0.1, 0.2]
    assert cut.columns["gyro.x"].tolist() == [2.0, 3.0]
    assert cut.source == "flight.csv"
    assert recording().between(end=0.1).t.tolist() == [0.0, 0.1]
    with pytest.raises(InputError, match=r"has 1 row from 0.15 s on; its times"):
        recording().between(0.15)
    with pytest.raises(InputError, match=r"has 1 row to 0.05 s; its times"):
        recording().between(end=0.05)


def test_has_asks_for_all():
    rec = recording(joint__a__position=T, joint__b__position=2 * T)
    assert rec.has("joint.a.position", "joint.b.position")
    assert not rec.has("joint.a.position", "gyro.x")


def test_nan_means_no_sample():
    rec = recording(gyro__x=np.array([1.0, np.nan, 2.0]))
    assert np.isnan(rec.column("gyro.x")[1])


def test_pickles():
    rec = pickle.loads(pickle.dumps(recording(gyro__x=T)))
    np.testing.assert_array_equal(rec.column("gyro.x"), T)


def test_missing_column_says_its_purpose_and_a_close_name():
    rec = recording(gyro_x=T, gyro__y=T)
    with pytest.raises(InputError) as caught:
        rec.vector("gyro")
    message = str(caught.value)
    assert message.startswith("flight.csv: column 'gyro.x' is missing (base angular")
    assert "rad/s" in message
    assert "'gyro_x'" in message


def test_missing_column_does_not_suggest_another_sensors_column():
    with pytest.raises(InputError, match=r"add it$"):
        recording(gyro__y=T).column("gyro.x")


@pytest.mark.parametrize(
    ("name", "purpose"),
    [
        ("joint.a.position", "joint position, rad"),
        ("wheel.a.speed", "relative to the base"),
        ("attitude.w", "scalar last"),
        ("torque.x", "N m"),
    ],
)
def test_purposes(name, purpose):
    with pytest.raises(InputError, match=purpose):
        recording().column(name)


def test_missing_column_without_a_meaning():
    with pytest.raises(InputError, match="'temperature' is missing; add it"):
        recording().column("temperature")


BAD_TIMES = [
    ([0.0], "1 samples; at least 2"),
    ([], "0 samples"),
    ([0.0, np.nan, 1.0], "'t', row 2: found nan"),
    ([0.0, np.inf, 1.0], "'t', row 2: found inf"),
    ([0.0, 0.2, 0.2], r"row 3: 0\.2 s does not come after 0\.2 s"),
    ([0.0, 0.2, 0.1], r"row 3: 0\.1 s does not come after 0\.2 s"),
]


@pytest.mark.parametrize(("t", "message"), BAD_TIMES)
def test_times_refused(t, message):
    with pytest.raises(InputError, match=message):
        Recording(np.array(t, dtype=float), {}, source="flight.csv")


BAD_COLUMNS = [
    (np.zeros(2), "'x' has 2 rows but 't' has 3"),
    (np.array(["a", "b", "c"]), "'x' holds <U1 values"),
    (np.array([True, False, True]), "'x' holds bool values"),
    (np.zeros((3, 2)), r"'x' has shape \(3, 2\)"),
    (np.array([0.0, 0.0, -np.inf]), "'x', row 3: found -inf"),
]


@pytest.mark.usefixtures("as_installed")
@pytest.mark.parametrize(("values", "message"), BAD_COLUMNS)
def test_columns_refused(values, message):
    with pytest.raises(InputError, match=message):
        recording(x=values)


def test_t_twice_refused():
    with pytest.raises(InputError, match="'t' is given twice"):
        recording(t=T)


def test_quaternions_of_zeros_are_no_samples():
    zeros = {name: np.append(column[:2], 0.0) for name, column in UNIT.items()}
    recording = Recording(T, zeros)
    assert np.isnan(recording.vector("attitude", "xyzw")).all(axis=1).tolist() == [
        *(False, False, True)
    ]
    (note,) = recording.notes
    assert note == (
        f"attitude: 1 quaternion of zeros left out, the first at t = {T[2]:g} s"
    )
    # They are not noted again, nor forgotten.
    assert recording.with_columns({}).between().notes == (note,)


def test_attitude_must_be_a_unit_quaternion():
    good = UNIT | {"attitude.w": np.array([0.991, np.nan, 1.009])}
    assert Recording(T, good).has("attitude.w")
    bad = UNIT | {"attitude.w": np.array([1.0, np.nan, 0.98])}
    with pytest.raises(InputError, match=r"row 3: norm 0\.98; give unit"):
        Recording(T, bad)
    with pytest.raises(InputError, match="all 3 quaternions are zero, as of"):
        Recording(T, UNIT | {"attitude.w": np.zeros(3)})


def arm(**columns):
    return recording(joint__arm__1__position=T, joint__arm__2__position=T, **columns)


def test_check_joints_accepts_the_robots_own():
    arm(gyro__x=T, truth=T).with_joints_of(robot())


def test_check_joints_names_the_robots_joints():
    with pytest.raises(InputError, match=r"no joint 'foo', only 'arm\.1', 'arm\.2'"):
        arm(joint__foo__velocity=T).with_joints_of(robot())


def test_check_joints_needs_every_position():
    with pytest.raises(InputError, match=r"'joint\.arm\.2\.position' is missing"):
        recording(joint__arm__1__position=T).with_joints_of(robot())


def driven(**constants: float) -> Robot:
    names = {name.replace("__", "."): each for name, each in constants.items()}
    return replace(robot(), torque_constants=names)


def test_currents_become_torques():
    missing = np.array([1.0, np.nan, -2.0])
    shown = arm(joint__arm__1__current=missing, joint__arm__2__torque=T)
    whole = shown.with_joints_of(driven(arm__1=2.5, arm__2=4.0))
    np.testing.assert_array_equal(
        whole.column("joint.arm.1.torque"), [2.5, np.nan, -5.0]
    )
    np.testing.assert_array_equal(whole.column("joint.arm.2.torque"), T)
    assert not whole.has("joint.arm.1.current")
    # What is a torque already stays what it is.
    assert whole.with_joints_of(driven(arm__1=2.5)).columns == whole.columns
    nothing = arm(joint__arm__1__current=np.full(3, np.nan))
    torque = nothing.with_joints_of(driven(arm__1=2.5)).column("joint.arm.1.torque")
    assert np.isnan(torque).all()


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (
            {"joint__arm__2__current": T},
            "flight.csv: column 'joint.arm.2.current': without the motor's torque "
            "constant it tells no torque; add 'torque_constants: {arm.2: ... N m/A}' "
            "to the robot file, or remove the column",
        ),
        (
            {"joint__arm__1__current": T, "joint__arm__1__torque": T},
            "flight.csv: columns 'joint.arm.1.current' and 'joint.arm.1.torque' both "
            "tell the torque at one joint; remove one",
        ),
        ({"joint__elbow__current": T}, "has no joint 'elbow', only"),
    ],
)
def test_currents_that_tell_no_torque_are_refused(columns, message):
    with pytest.raises(InputError, match=re.escape(message)) as error:
        arm(**columns).with_joints_of(driven(arm__1=2.5))
    assert "\n" not in str(error.value)


def test_joints_that_follow_others():
    def coupled(factor: float, offset: float):
        coupling = Coupling("arm.2", "arm.1", factor, offset)
        return replace(robot(), couplings=(coupling,))

    led = recording(joint__arm__1__position=T, joint__arm__1__velocity=2 * T)
    whole = led.with_joints_of(coupled(-3.0, 0.5))
    np.testing.assert_array_equal(whole.column("joint.arm.2.position"), 0.5 - 3 * T)
    np.testing.assert_array_equal(whole.column("joint.arm.2.velocity"), -6 * T)
    # What was measured counts, and is not mixed with what was not.
    both = arm(joint__arm__1__velocity=2 * T).with_joints_of(coupled(-3.0, 0.5))
    np.testing.assert_array_equal(both.column("joint.arm.2.position"), T)
    assert not both.has("joint.arm.2.velocity")


def test_check_wheels():
    recording(wheel__rw_x__speed=T).check_wheels(robot())
    recording(wheel__rw_x__position=T).check_wheels(robot())
    recording().check_wheels(robot(wheels=()))
    with pytest.raises(InputError, match="has no wheel 'rw', only 'rw_x'"):
        recording(wheel__rw__speed=T).check_wheels(robot())
    with pytest.raises(InputError, match="has no wheel 'rw', only none"):
        recording(wheel__rw__position=T).check_wheels(robot(wheels=()))
    with pytest.raises(InputError, match=r"'wheel\.rw_x\.speed' is missing"):
        recording().check_wheels(robot())


BEYOND = {
    "a cell": (
        {"gyro.x": [0.0, 2e12]},
        [0.0, 1.0],
        "'gyro.x', row 2: found 2e.12; give",
    ),
    "a faint column": (
        {"gyro.x": [np.nan, 0.0, -2e-204]},
        [0.0, 1.0, 2.0],
        "'gyro.x': nothing in it is above 2e-204",
    ),
    "a time": ({}, [0.0, 1.7e18], "'t', row 2: found 1.7e.18 s; .* in nanoseconds"),
    "a step": ({}, [0.0, 1e-12], "'t', row 2: 1e-12 s after the row before"),
}


@pytest.mark.parametrize(("columns", "t", "words"), BEYOND.values(), ids=BEYOND)
def test_what_no_recording_has(columns, t, words):
    columns = {name: np.array(values) for name, values in columns.items()}
    with pytest.raises(InputError, match=words):
        Recording(np.array(t), columns)


def test_rounding_is_no_fault():
    Recording(np.array([0.0, 1.0]), {"gyro.x": np.array([0.0, 1e-33])})


def test_a_column_without_a_meaning_may_hold_anything_finite():
    Recording(np.array([0.0, 1.0]), {"header.stamp": np.array([1.7e18, 1.7e18])})


def test_times_in_another_unit_are_refused():
    with pytest.raises(InputError, match=r"rows are 1e-07 s apart .* in seconds"):
        Recording(1e-6 * T, {})


def test_two_sensors_may_have_nearly_the_same_times():
    assert Recording(np.sort([*T, *(T + 2e-9)]), {}).t.size == 6


def test_a_part_of_a_sensor_is_named():
    t = np.linspace(0.0, 1.0, 5)
    some = {"position.x": t, "position.y": t, "pos.z": t}
    with pytest.raises(InputError, match=r"position\.z' is missing.*rename 'pos\.z'"):
        Recording(t, some, "r.csv").has_vector("position")
    assert not Recording(t, some, "r.csv").has_vector("velocity")
