from dataclasses import replace

import numpy as np
import pytest
from burns import OFF, ON, Body, burn, changed, without
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.weigh import weigh
from orbident.recordings.recording import Recording
from orbident.robot.description import Thruster
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors

PLANAR = load_robot("cepheus-like")
SPATIAL = load_robot("paper-spatial")
TABLE = Body(PLANAR.joint_names, mass=12.3)
SPACE = Body(
    SPATIAL.joint_names,
    mass=987.0,
    force=np.array([20.0, -35.0, 11.0]),
    p_S_cm=np.array([0.3, -0.2, 0.4]),
    rate=np.array([0.06, -0.03, 0.05]),
)
CASES = {"planar": (PLANAR, TABLE), "spatial": (SPATIAL, SPACE)}
SIGNALS = ("position", "velocity", "accelerometer")
TABLE_BURN = burn(TABLE)

EXACT = 1e-7
"""Relative: in a step of 0.01 s the base turns by 1e-3 rad, not quite evenly."""
EDGES = 2e-4
"""Relative, of the accelerometer: two edges of a burn of 50 samples, and the spline
across them, which force and specific force have in common."""


def only(signal, recording):
    return without(recording, *(other for other in SIGNALS if other != signal))


def noisy(recording, seed, position=1e-4, attitude=3e-4, velocity=1e-3):
    """White noise of motion capture, m, rad and m/s; without a gyro."""
    random = np.random.default_rng(seed)
    n = recording.t.size
    turned = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    turned = Rotation.from_rotvec(attitude * random.standard_normal((n, 3))) * turned
    point = {
        name: recording.vector(name) + std * random.standard_normal((n, 3))
        for name, std in (("position", position), ("velocity", velocity))
    }
    seen = without(recording, "gyro", "accelerometer")
    return changed(seen, attitude=turned.as_quat(), **point)


@pytest.mark.parametrize("signal", SIGNALS)
@pytest.mark.parametrize("case", CASES)
def test_the_mass_of_a_body_that_turns(case, signal):
    robot, body = CASES[case]
    weighing = weigh(robot, only(signal, burn(body)))
    assert weighing.signal == signal
    assert weighing.status == "ok"
    assert weighing.warnings == ()
    tolerance = EDGES if signal == "accelerometer" else EXACT
    assert weighing.mass.value == pytest.approx(body.mass, rel=tolerance)


def test_eq_40_where_the_attitude_is_held():
    recording = burn(TABLE.turning(0.0), start=0.0)
    v_y = recording.column("velocity.y")
    M = TABLE.force[1] * (OFF - ON) / (v_y[-1] - v_y[0])
    # Two numbers of 1e-2 m/s, whose difference loses two digits.
    assert weigh(PLANAR, recording).mass.value == pytest.approx(M, rel=1e-10)


def test_the_impulse_is_in_inertial_axes():
    weighing = weigh(PLANAR, burn(TABLE.turning(0.0), start=np.pi / 2))
    expected = [-TABLE.force[1] * (OFF - ON), TABLE.force[0] * (OFF - ON), 0.0]
    # Sums of fifty products.
    np.testing.assert_allclose(weighing.impulse, expected, atol=1e-13)
    assert weighing.samples == 401


def test_an_accelerometer_may_have_a_bias():
    recording = only("accelerometer", burn(SPACE))
    biased = recording.vector("accelerometer") + np.array([3e-3, -1e-3, 2e-3])
    weighing = weigh(SPATIAL, changed(recording, accelerometer=biased))
    assert weighing.mass.value == pytest.approx(SPACE.mass, rel=EDGES)


@pytest.mark.parametrize("signal", ["position", "velocity"])
def test_the_deviation_is_what_the_seeds_show(signal):
    runs = [weigh(PLANAR, only(signal, noisy(TABLE_BURN, k))) for k in range(40)]
    masses = np.array([run.mass.value for run in runs])
    claimed = np.mean([run.mass.std for run in runs])
    # The deviation of 40 draws is itself known to 11 %: three times that.
    assert masses.std(ddof=1) == pytest.approx(claimed, rel=0.34)
    # And their mean to 1/sqrt(40) of it.
    assert abs(masses.mean() - TABLE.mass) < 3 * claimed / np.sqrt(40)


def test_the_better_signal_is_used():
    assert weigh(PLANAR, noisy(TABLE_BURN, 0)).signal == "position"
    assert weigh(PLANAR, noisy(TABLE_BURN, 0, position=0.1)).signal == "velocity"


def test_a_force_lasts_until_the_next_one():
    force = TABLE_BURN.vector("force")
    told = np.full_like(force, np.nan)
    edges = np.searchsorted(TABLE_BURN.t, [0.0, ON, OFF])
    told[edges] = force[edges]
    weighing = weigh(PLANAR, changed(TABLE_BURN, force=told))
    assert weighing == replace(weigh(PLANAR, TABLE_BURN), impulse=weighing.impulse)


def test_slow_and_missing_samples():
    rows = np.arange(TABLE_BURN.t.size)
    position = TABLE_BURN.vector("position")
    position[rows % 5 != 0] = np.nan
    attitude = TABLE_BURN.vector("attitude", "xyzw")
    attitude[(rows % 7 == 0) & (rows > 0) & (rows < rows[-1])] = np.nan
    attitude[::2] *= -1
    seen = changed(only("position", TABLE_BURN), position=position, attitude=attitude)
    weighing = weigh(PLANAR, seen)
    assert weighing.samples == 81
    # The spline across gaps of the attitude: (0.1 rad/s 0.02 s)^4.
    assert weighing.mass.value == pytest.approx(TABLE.mass, rel=EXACT)


def test_positions_may_be_late():
    late = 0.03
    rows = round(late * 100)
    position = np.full((TABLE_BURN.t.size, 3), np.nan)
    position[rows:] = TABLE_BURN.vector("position")[:-rows]
    sensors = declared_sensors({"position": {"std": 1e-4, "latency": late}})
    robot = replace(PLANAR, sensors=sensors)
    seen = changed(only("position", TABLE_BURN), position=position)
    # The spline between samples meets a kink of the velocity's slope, 0.05 m/s^2: off
    # by 1e-2 of 0.05 h^2 for a sample or two, of 0.02 m.
    assert weigh(robot, seen).mass.value == pytest.approx(TABLE.mass, rel=1e-5)


def refused(recording, *words, robot=PLANAR):
    with pytest.raises(InputError) as error:
        weigh(robot, recording)
    message = str(error.value)
    assert message.startswith("burn.csv: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_what_is_missing_is_named():
    refused(without(TABLE_BURN, "force"), "'force.x' is missing", "base axes, N")
    refused(without(TABLE_BURN, "attitude"), "'attitude.x' is missing")
    refused(without(TABLE_BURN, "joint.joint2"), "'joint.joint2.position' is missing")
    refused(without(TABLE_BURN, *SIGNALS), "position.x", "velocity.x", "record one")


def test_a_burn_without_a_force():
    nothing = np.zeros_like(TABLE_BURN.vector("force"))
    refused(changed(TABLE_BURN, force=nothing), "zero throughout", "record a burn")
    refused(changed(TABLE_BURN, force=np.nan * nothing), "zero throughout")


def test_a_joint_that_moves():
    columns = dict(TABLE_BURN.columns)
    columns["joint.joint2.position"] = 0.7 + 0.3 * np.sin(TABLE_BURN.t)
    moving = replace(TABLE_BURN, columns=columns)
    refused(moving, "'joint.joint2.position'", "moved by 0.527 rad", "lock all joints")


def test_a_joint_that_nobody_watched():
    columns = dict(TABLE_BURN.columns)
    columns["joint.joint2.position"] = np.full(TABLE_BURN.t.size, np.nan)
    refused(replace(TABLE_BURN, columns=columns), "joint.joint2", "has no sample")


def test_force_and_attitude_never_together():
    force, attitude = (
        TABLE_BURN.vector("force"),
        TABLE_BURN.vector("attitude", "xyzw"),
    )
    force[:390] = np.nan
    force[390:] = TABLE.force
    attitude[200:] = np.nan
    apart = changed(TABLE_BURN, force=force, attitude=attitude)
    refused(without(apart, "gyro"), "must be recorded together")


def test_thrusters_with_gains():
    """Each pushes by what it was recorded to do, and is uncertain by its own gain."""
    one = Thruster("t1", np.zeros(3), np.array([1.0, 0.0, 0.0]), gain=0.05, thrust=0.6)
    other = Thruster("t2", np.zeros(3), np.array([0.0, 1.0, 0.0]), gain=0.0)
    robot = replace(PLANAR, thrusters=(one, other))
    force, kept = TABLE_BURN.vector("force"), without(TABLE_BURN, "force").columns

    def fired(duty: np.ndarray) -> Recording:
        pushes = {"thruster.t1.duty": duty, "thruster.t2.force": force[:, 1]}
        return replace(TABLE_BURN, columns={**kept, **pushes})

    by_thrusters = weigh(robot, fired(force[:, 0] / 0.6))
    assert by_thrusters.mass.value == pytest.approx(
        weigh(PLANAR, TABLE_BURN).mass.value, rel=1e-12
    )
    # The part of t1 in the impulse: 0.3^2 of 0.3^2 + 0.5^2.
    part = 0.05 * 0.3**2 / (0.3**2 + 0.5**2)
    assert by_thrusters.mass.std == pytest.approx(TABLE.mass * part, rel=1e-5)
    refused(fired(force[:, 0] / 0.2), "'thruster.t1.duty'", "between 0", robot=robot)
    lacking = replace(PLANAR, thrusters=(other,))
    refused(fired(force[:, 0]), "no thruster 't1'", robot=lacking)


def rejected(recording, *words):
    weighing = weigh(PLANAR, recording)
    assert weighing.status == "rejected"
    assert np.isnan([weighing.mass.value, weighing.mass.std]).all()
    assert weighing.to_json()["mass"] == {"value": None, "std": None}
    (sentence,) = weighing.warnings
    for word in words:
        assert word in sentence


def test_a_force_of_the_wrong_sign():
    force = -TABLE_BURN.vector("force")
    rejected(changed(TABLE_BURN, force=force), "against the force", "signs")


def test_a_force_in_the_wrong_frame():
    recording = burn(TABLE.turning(0.0), start=0.6)
    turned = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    inertial = turned.apply(recording.vector("force"))
    rejected(changed(recording, force=inertial), "34 deg off", "frames")


def test_a_push_that_does_not_show():
    weak = burn(replace(TABLE, force=1e-5 * TABLE.force))
    rejected(noisy(weak, 0), "does not show")


def test_a_push_after_the_last_position():
    position = TABLE_BURN.vector("position")
    position[90:] = np.nan
    seen = changed(only("position", TABLE_BURN), position=position)
    rejected(seen, "does not show")
