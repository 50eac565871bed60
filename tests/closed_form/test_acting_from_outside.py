"""Momentum under what acts from outside, in closed form or by sums over bodies.

dh/dt = sum (tau + (p - r_cm) x F),   M dv_cm/dt = sum F
"""

from dataclasses import replace

import numpy as np
import pytest
from flying_robots import moving_start, random_thrusters
from obvious_momentum import body_motion, quaternion_rotation
from random_robots import (
    random_planar_robot,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)

from orbident.errors import InputError
from orbident.model.equations_of_motion import equations_of_motion
from orbident.model.kinematics import inertia
from orbident.robot.description import Robot
from orbident.simulation import outside
from orbident.simulation.flight import Driven, FreeFlying, Hold, standing
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import thrust_columns
from orbident.simulation.sensor import markov, stream
from orbident.trajectories.environment import Environment

G = 9.80665
T = np.linspace(0.0, 2.0, 41)
SPACE = replace(
    random_robot(3, (0, 1, 0), (2,), random_wheels(1, ("free", "held")), base=10.0),
    thrusters=random_thrusters(4, ("t1",)),
    feature_point=np.array([0.3, -0.2, 0.1]),
)
TABLE = random_planar_robot(5, (0, 1), wheels=())
RAFT = random_planar_robot(6, ())
ORBIT = {
    "altitude": "400 km",
    "inclination": "0.9 rad",
    "node": "0.4 rad",
    "argument": "1.1 rad",
}

CLOSE = 1e-8
"""N m s and N s: ten times the tolerance of motions by masses of some tens of kg."""


def fly(robot: Robot, given: dict, seed: int = 0, rate: float = 0.3) -> FreeFlying:
    """Joints swing as commanded, base and wheels move."""
    swing = random_swing(6, len(robot.joints))
    q, qd, _ = swing.at(T[:1])
    state = standing(random_start(8, robot, rate), q[0])._replace(qd=qd[0])
    return free_flying(
        robot,
        T,
        state,
        swing,
        Driven(),
        tolerance=1e-10,
        environment=Environment.model_validate(given),
        seed=seed,
    )


def integral(values: np.ndarray) -> np.ndarray:
    """The integral over all samples, by Simpson's rule."""
    weights = np.full(T.size, 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return (T[1] - T[0]) / 3 * weights @ values


def gained(flight: FreeFlying, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Angular and linear momentum since the first sample."""
    h, v = flight.h_cm, flight.v_cm
    return h - h[0], robot.mass * (v - v[0])


def R_WB(flight: FreeFlying) -> np.ndarray:
    return np.array([quaternion_rotation(x) for x in flight.attitude])


def test_driven_joints_do_as_commanded():
    swing = random_swing(6, 3)
    flight = fly(SPACE, {"torque": [0.3, 0, -0.2]})
    q, qd, qdd = swing.at(T)
    np.testing.assert_allclose(flight.q, q, atol=1e-9)
    np.testing.assert_allclose(flight.qd, qd, atol=1e-9)
    np.testing.assert_allclose(flight.qdd, qdd, atol=1e-14)


def test_driving_torque_is_what_the_motion_takes_beyond_what_acts():
    """A force at S does work `F . v_S` with `v_S = v_cm - w x r_cm - J_cm qd`."""
    F = np.array([0.4, -0.3, 0.2])
    flight = fly(SPACE, {"force": list(F)})
    R, at = R_WB(flight), inertia(SPACE, flight.q)
    to_base = np.swapaxes(R, 1, 2)
    v_cm = np.einsum("nij,nj->ni", to_base, flight.v_cm)
    vd_cm = np.einsum("nij,nj->ni", to_base, np.tile(F / SPACE.mass, (T.size, 1)))
    # v' is the derivative of the components in turning axes.
    vd_cm -= np.cross(flight.w, v_cm)
    v = np.hstack([v_cm, flight.w, flight.qd, flight.qd_rw])
    vd = np.hstack([vd_cm, flight.w_dot, flight.qdd, flight.qdd_rw])
    eq = equations_of_motion(SPACE, flight.q, v)
    Q = np.einsum("nij,nj->ni", eq.H, vd) + eq.c
    by_force = -np.einsum("nik,ni->nk", at.J_cm, to_base @ F)
    expected = Q[:, 6:9] - by_force
    np.testing.assert_allclose(flight.tau, expected, atol=1e-8)
    assert np.abs(by_force).max() > 0.01


def test_constant_torque():
    torque = np.array([0.3, -0.1, 0.2])
    h, p = gained(fly(SPACE, {"torque": list(torque)}), SPACE)
    np.testing.assert_allclose(h, np.outer(T, torque), atol=CLOSE)
    np.testing.assert_allclose(p, 0.0, atol=CLOSE)


def test_constant_force_at_S():
    force = np.array([0.3, -0.1, 0.2])
    flight = fly(SPACE, {"force": list(force)})
    h, p = gained(flight, SPACE)
    np.testing.assert_allclose(p, np.outer(T, force), atol=CLOSE)
    torque = np.cross(flight.r_S - flight.r_cm, force)
    # Simpson's rule at 0.05 s: 1e-8 of 0.4 N m s.
    np.testing.assert_allclose(h[-1], integral(torque), atol=1e-7)


def test_slow_torque_is_straight_between_samples():
    given = {"slow_torque": {"std": 0.2, "correlation_time": 1.5}}
    h, _ = gained(fly(SPACE, given, seed=4), SPACE)
    random = stream(4, "environment.slow_torque")
    drawn = markov(random, T, np.full(3, 0.2), np.full(3, 1.5))
    steps = np.diff(T)[:, None] * (drawn[1:] + drawn[:-1]) / 2
    np.testing.assert_allclose(h[1:], np.cumsum(steps, axis=0), atol=CLOSE)
    again, _ = gained(fly(SPACE, given, seed=5), SPACE)
    assert np.abs(again - h).max() > 0.01


def test_a_burst_is_an_impulse_between_samples():
    burst = {"start": 1.013, "duration": 0.021, "force": [3.0, 0.0, -1.0]}
    flight = fly(SPACE, {"bursts": [burst]})
    _, p = gained(flight, SPACE)
    np.testing.assert_allclose(p[T < 1.013], 0.0, atol=CLOSE)
    before, after = R_WB(flight)[[20, 21]]
    impulse = 0.021 * (before + after) / 2 @ [3.0, 0.0, -1.0]
    # The base turns by 0.03 rad from one sample to the next.
    np.testing.assert_allclose(p[-1], impulse, atol=2e-3)


def test_thrust_is_the_recorded_force_times_the_gain():
    pulses = [{"on": 0.52, "off": 0.98, "force": 0.5}, {"on": 1, "off": 2, "force": 1}]
    given = {"thrusters": {"t1": {"gain": 1.1, "pulses": pulses}}}
    flight = fly(SPACE, given)
    column = thrust_columns(Environment.model_validate(given), T)["thruster.t1.force"]
    recorded = np.sum(column[:-1] * np.diff(T))
    assert recorded == pytest.approx(0.46 * 0.5 + 1.0, rel=1e-12)
    direction = SPACE.thrusters[0].direction
    _, p = gained(flight, SPACE)
    along = (R_WB(flight) @ direction)[T.searchsorted(0.75)]
    first = p[T.searchsorted(1.0)]
    np.testing.assert_allclose(first, 1.1 * 0.23 * along, atol=2e-3)


def test_a_tilted_table_pulls_all_parts_alike():
    tilt = np.array([40e-6, -70e-6])
    flight = fly(TABLE, {"tilt": list(tilt)})
    h, p = gained(flight, TABLE)
    pull = G * np.append(tilt, 0.0)
    np.testing.assert_allclose(h[:, 2], 0.0, atol=CLOSE)
    np.testing.assert_allclose(p, TABLE.mass * np.outer(T, pull), atol=CLOSE)


def test_an_accelerometer_does_not_feel_the_pull():
    flight = fly(RAFT, {"tilt": [1e-3, 0]}, rate=0.0)
    assert np.ptp(flight.v_S[:, 0]) == pytest.approx(1e-3 * G * T[-1])
    np.testing.assert_allclose(flight.f_S, 0.0, atol=1e-8)


def test_on_a_bowl_the_centre_of_mass_swings():
    """Each part falls towards the origin as `r'' = -k r`, and so does their CM."""
    k = 0.5
    flight = fly(TABLE, {"uneven": {"xx": -k, "yy": -k}})
    angle = np.sqrt(k) * T[:, None]
    r = flight.r_cm[0] * np.cos(angle) + flight.v_cm[0] * np.sin(angle) / np.sqrt(k)
    np.testing.assert_allclose(flight.r_cm[:, :2], r[:, :2], atol=1e-8)
    h, _ = gained(flight, TABLE)
    np.testing.assert_allclose(h[:, 2], 0.0, atol=CLOSE)


def test_the_slopes_of_an_uneven_table_are_those_of_its_height():
    """Forces of a saddle, `a = A r` with `A` symmetric, on every body."""
    A = np.array([[0.2, 0.3], [0.3, -0.1]])
    flight = fly(TABLE, {"uneven": {"xx": 0.2, "xy": 0.3, "yy": -0.1}})
    h, p = gained(flight, TABLE)
    dh, dp = np.zeros((2, T.size, 3))
    for i, theta_i in enumerate(TABLE.theta):
        r = coms(TABLE, i, flight)
        F = np.zeros((T.size, 3))
        F[:, :2] = theta_i[0] * r[:, :2] @ A
        dh += np.cross(r - flight.r_cm, F)
        dp += F
    np.testing.assert_allclose(h[-1, 2], integral(dh)[2], atol=1e-6)
    np.testing.assert_allclose(p[-1, :2], integral(dp)[:2], atol=1e-6)


def test_film_drag_of_one_body_decays():
    """`v = v_0 e^(-c t / M)`, `w = w_0 e^(-c_r t / I)` with the pads below the CM."""
    c, c_r = 2.0, 0.5
    M, com = RAFT.mass, RAFT.theta[0, 1:4] / RAFT.mass
    raft = replace(RAFT, pads={RAFT.bodies[0]: com})
    flight = fly(raft, {"film_drag": {RAFT.bodies[0]: {"c": c, "c_r": c_r}}})
    I = inertia(RAFT, np.zeros((1, 0))).D[0, 2, 2]
    v = flight.v_cm[0] * np.exp(-c / M * T)[:, None]
    np.testing.assert_allclose(flight.v_cm, v, atol=1e-9)
    w = flight.w[0] * np.exp(-c_r / I * T)[:, None]
    np.testing.assert_allclose(flight.w, w, atol=1e-8)
    assert flight.w[-1, 2] / flight.w[0, 2] < 0.9


def test_film_drag_of_two_bodies():
    """The drag is integrated from the velocity of each pad, link by link."""
    pads = {TABLE.bodies[0]: np.zeros(3), TABLE.bodies[2]: np.array([0.1, -0.2, 0.0])}
    table = replace(TABLE, pads=pads)
    films = {TABLE.bodies[0]: {"c": 0.4, "c_r": 0.1}, TABLE.bodies[2]: {"c": 0.2}}
    flight = fly(table, {"film_drag": films})
    h, p = gained(flight, table)
    dh, dp = np.zeros((2, T.size, 3))
    for n, R in enumerate(R_WB(flight)):
        for body, c, c_r in ((0, 0.4, 0.1), (2, 0.2, 0.0)):
            at = body_motion(table, body, flight.q[n], flight.qd[n], flight.w[n])
            arm = at.R @ pads[table.bodies[body]]
            v = flight.v_S[n] + R @ (at.v + np.cross(at.w, arm))
            place = flight.r_S[n] + R @ (at.d + arm)
            dp[n] -= c * v
            dh[n] -= c * np.cross(place - flight.r_cm[n], v) + c_r * (R @ at.w)
    np.testing.assert_allclose(p[-1, :2], integral(dp)[:2], atol=1e-6)
    np.testing.assert_allclose(h[-1, 2], integral(dh)[2], atol=1e-6)
    assert abs(h[-1, 2]) > 0.05


def coms(robot: Robot, body: int, flight: FreeFlying) -> np.ndarray:
    """Where the CM of a body is, inertial axes, link by link."""
    com = robot.theta[body, 1:4] / robot.theta[body, 0]
    places = []
    for q, r_S, R in zip(flight.q, flight.r_S, R_WB(flight), strict=True):
        at = body_motion(robot, body, q, np.zeros_like(q), np.zeros(3))
        places.append(r_S + R @ (at.d + at.R @ com))
    return np.array(places)


def test_gravity_gradient_is_that_of_the_whole():
    """`tau = 3 mu / R^3 n x D n`, with the inertia summed here."""
    given = {"orbit": ORBIT, "gravity_gradient": True}
    flight = fly(SPACE, given)
    h, p = gained(flight, SPACE)
    R = 6378137.0 + 400e3
    i, node, u_0 = 0.9, 0.4, 1.1
    n_0 = np.sqrt(3.986004418e14 / R**3)
    # What J2 does to the orbit within 2 s is 3 cm.
    u, W = u_0 + n_0 * T, node
    n = np.stack(
        [
            np.cos(W) * np.cos(u) - np.sin(W) * np.sin(u) * np.cos(i),
            np.sin(W) * np.cos(u) + np.cos(W) * np.sin(u) * np.cos(i),
            np.sin(u) * np.sin(i),
        ],
        axis=1,
    )
    D = np.zeros((T.size, 3, 3))
    for body, (m, mx, my, mz, xx, xy, yy, xz, yz, zz) in enumerate(SPACE.theta):
        com = np.array([mx, my, mz]) / m
        I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        I = I - m * (com @ com * np.eye(3) - np.outer(com, com))
        arms = coms(SPACE, body, flight) - flight.r_cm
        for t, (q, R_t, arm) in enumerate(
            zip(flight.q, R_WB(flight), arms, strict=True)
        ):
            R_Wi = R_t @ body_motion(SPACE, body, q, 0 * q, np.zeros(3)).R
            D[t] += R_Wi @ I @ R_Wi.T
            D[t] += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    torque = 3 * n_0**2 * np.cross(n, np.einsum("nij,nj->ni", D, n))
    expected = integral(torque)
    assert np.abs(expected).max() > 1e-5
    # Tolerance of the motion; momentum in the sum is 100 N m s, of 16 digits.
    np.testing.assert_allclose(h[-1], expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_allclose(p, 0.0, atol=1e-10)


def test_what_cannot_act_on_a_robot_is_refused_in_one_line():
    bodies = {TABLE.bodies[0]: {"c": 1.0}}
    for robot, given, words in (
        (SPACE, {"tilt": [1e-6, 0]}, "tilt.* floats in space, and this acts on a"),
        (SPACE, {"gravity_gradient": True}, "gravity_gradient acts in an orbit, and"),
        (SPACE, {"dipole": [1, 0, 0]}, "dipole acts in an orbit, and none is given"),
        (TABLE, {"orbit": ORBIT}, "orbit.* floats on a table, and this acts in sp"),
        (TABLE, {"film_drag": bodies}, "film_drag: body '.*' has no pads; say where"),
        (TABLE, {"film_drag": {"arm": {"c": 1.0}}}, "film_drag: no body 'arm'"),
        (SPACE, {"thrusters": {"x": {"pulses": [PULSE]}}}, "no thruster 'x'"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            fly(robot, given)
        assert "\n" not in str(refused.value)


PULSE = {"on": 1, "off": 2, "force": 1}


def test_what_throws_the_robot_about_is_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(outside, "COARSE", 2**7)
    with pytest.raises(InputError, match=r"no motion is found|does not settle"):
        free_flying(
            RAFT,
            np.array([0.0, 1e3]),
            moving_start(1, RAFT),
            Hold(np.zeros(0)),
            Driven(),
            environment=Environment.model_validate({"uneven": {"xx": 10.0}}),
        )
