from dataclasses import replace

import jaxtyping
import numpy as np
import pytest

from orbident.errors import InputError
from orbident.robot.description import Coupling, Joint, Robot, Wheel
from orbident.trajectories.trajectory import InitialState, Trajectory

# Table 2
A = [[0.0411, -0.0622, 0.0002], [0.0435, -0.0407, -0.1253], [0.0516, -0.0423, 0.1343]]
B = [[0.0533, -0.1269, 0.0171], [-0.0393, 0.0596, -0.0444], [-0.0153, 0.0449, 0.0463]]
NAMES = ("joint1", "joint2", "joint3")


@pytest.fixture
def as_installed(monkeypatch):
    """Users run without the shape checks that these tests switch on."""
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)


def table_2(**changes):
    fields = {
        "duration": 80.0,
        "joints": NAMES,
        "a": np.array(A),
        "b": np.array(B),
        "start": np.zeros((3, 3)),
        "end": np.zeros((3, 3)),
    }
    return Trajectory(**(fields | changes))


def robot(joints, wheels=("rw_x",)):
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


def test_table_2_reaches_its_rate_limit():
    q, qd, qdd = table_2().at(np.linspace(0.0, 80.0, 1601))
    # Printed amplitudes have four digits; the limit is 0.36 rad/s.
    assert np.abs(qd).max() == pytest.approx(0.36, abs=0.005)
    for history in (q, qd, qdd):
        assert history.shape == (1601, 3)
        assert history.dtype == np.float64
        np.testing.assert_allclose(history[[0, -1]], 0.0, atol=1e-12)


def test_rates_against_finite_differences():
    t, h = np.linspace(1.0, 79.0, 50), 1e-4
    before, at, after = (table_2().at(t + k * h) for k in (-1, 0, 1))
    for order in (0, 1):
        difference = (after[order] - before[order]) / (2 * h)
        # h^2/6 of the third derivative, and 1e-15/h of rounding.
        np.testing.assert_allclose(difference, at[order + 1], atol=1e-9)


def test_no_joints():
    none = np.zeros((0, 0))
    ends = np.zeros((0, 3))
    trajectory = table_2(joints=(), a=none, b=none, start=ends, end=ends)
    assert trajectory.at(np.linspace(0, 80, 4))[0].shape == (4, 0)


@pytest.mark.parametrize("t", [-0.1, 80.1, np.nan])
def test_times_outside_refused(t):
    with pytest.raises(InputError, match=r"asked for t = .* from 0 to 80"):
        table_2().at(np.array([0.0, t]))


def test_rounding_of_the_last_time_accepted():
    table_2().at(np.array([np.nextafter(80.0, 81.0)]))


def test_a_robots_order():
    reordered = table_2().for_robot(robot(NAMES[::-1]))
    assert reordered.joints == NAMES[::-1]
    t = np.linspace(0, 80, 5)
    for new, old in zip(reordered.at(t), table_2().at(t), strict=True):
        np.testing.assert_allclose(new, old[:, ::-1], rtol=0, atol=1e-14)


def test_a_joint_that_follows_another_need_not_be_named():
    coupling = Coupling("finger", "joint2", -2.0, 0.1)
    led = replace(robot((*NAMES, "finger")), couplings=(coupling,))
    whole = table_2().for_robot(led)
    t = np.linspace(0, 80, 5)
    for new, old, offset in zip(whole.at(t), table_2().at(t), (0.1, 0, 0), strict=True):
        np.testing.assert_array_equal(new[:, :3], old)
        # Rounding of the quintic's coefficients.
        np.testing.assert_allclose(new[:, 3], offset - 2 * old[:, 1], atol=1e-13)
    # One that is named moves as it says.
    assert whole.for_robot(led).a.tolist() == whole.a.tolist()


@pytest.mark.parametrize("joints", [NAMES[:2], (*NAMES, "joint4"), ()])
def test_other_joints_refused(joints):
    expected = ", ".join(map(repr, joints)) or "none"
    with pytest.raises(
        InputError, match=f"found 'joint1', 'joint2', 'joint3', but .* has {expected};"
    ):
        table_2().for_robot(robot(joints))


def test_other_wheels_refused():
    trajectory = table_2(initial=InitialState(wheel_speed={"rw": 1.0}))
    with pytest.raises(
        InputError, match=r"initial\.wheel_speed: found 'rw', .* has 'rw_x'"
    ):
        trajectory.for_robot(robot(NAMES))


BAD = {
    "zero duration": ({"duration": 0.0}, "duration: found 0.0"),
    "endless": ({"duration": np.inf}, "duration: found inf"),
    "nan": ({"a": np.full((3, 3), np.nan)}, "trajectory: a: .* finite"),
    "b shorter": ({"b": np.zeros((3, 2))}, r"b: found shape \(3, 2\); give .*\(3, 3\)"),
    "rows": ({"start": np.zeros((2, 3))}, r"start: found shape \(2, 3\)"),
    "joint twice": ({"joints": ("a", "a", "b")}, "name each joint once"),
}


@pytest.mark.usefixtures("as_installed")
@pytest.mark.parametrize(("changes", "message"), BAD.values(), ids=BAD.keys())
def test_refusals(changes, message):
    with pytest.raises(InputError, match=message):
        table_2(**changes)


def test_numbers_are_frozen():
    a = np.array(A)
    trajectory = table_2(a=a)
    a[:] = 0.0
    assert trajectory.a[0, 0] == 0.0411
    assert not trajectory.a.flags.writeable


def test_initial_state_of_table_3_is_normalised():
    state = InitialState(attitude=np.array([0.2, 0.1, 0.3, 0.93]))
    np.testing.assert_allclose(np.linalg.norm(state.attitude), 1.0, atol=1e-15)
    np.testing.assert_allclose(
        state.attitude * np.sqrt(1.0049), [0.2, 0.1, 0.3, 0.93], atol=1e-15
    )
    again = InitialState(attitude=state.attitude)
    np.testing.assert_array_equal(again.attitude, state.attitude)


def test_initial_state_is_rest_by_default():
    state = InitialState(wheel_speed={"b": 2.0})
    assert not state.angular_velocity.any()
    assert not state.velocity.any()
    np.testing.assert_array_equal(state.attitude, [0, 0, 0, 1])
    np.testing.assert_array_equal(state.wheel_speeds(["a", "b"]), [0, 2])


BAD_STATES = {
    "norm": ({"attitude": np.array([0, 0, 0, 1.2])}, "norm 1.2; give a unit"),
    "zero": ({"attitude": np.zeros(4)}, "norm 0;"),
    "nan attitude": ({"attitude": np.array([0, 0, np.nan, 1])}, "attitude: .*finite"),
    "length": ({"velocity": np.zeros(2)}, r"initial\.velocity: found shape \(2,\)"),
    "infinite": ({"angular_velocity": np.full(3, np.inf)}, "give finite numbers"),
    "wheel": ({"wheel_speed": {"rw": np.nan}}, r"initial\.wheel_speed: .* finite"),
}


@pytest.mark.usefixtures("as_installed")
@pytest.mark.parametrize(
    ("fields", "message"), BAD_STATES.values(), ids=BAD_STATES.keys()
)
def test_initial_state_refusals(fields, message):
    with pytest.raises(InputError, match=message):
        InitialState(**fields)


def test_ends_of_which_nothing_is_said_are_zero():
    amplitudes = np.full((2, 3), 0.1)
    short = Trajectory(10.0, ("one", "two"), amplitudes, amplitudes)
    ends = np.zeros((2, 3))
    whole = Trajectory(10.0, ("one", "two"), amplitudes, amplitudes, ends, ends)
    t = np.linspace(0.0, 10.0, 7)
    for found, known in zip(short.at(t), whole.at(t), strict=True):
        np.testing.assert_array_equal(found, known)
    np.testing.assert_array_equal(short.start, ends)
