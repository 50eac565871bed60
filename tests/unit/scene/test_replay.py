"""A replay shows what was measured, and derives what was not."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import REFUSED
from random_motions import random_motion
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.robot.parameters import FIRST_MOMENT, MASS
from orbident.robot.robot_file import load_robot
from orbident.scene.replay import (
    centroidal_momentum,
    compared_motions,
    motion_residuals,
    predicted_motion,
    recorded_motion,
    with_resting_cm,
)
from orbident.scene.scene import scene_of
from orbident.simulation.simulate import simulate


@pytest.fixture(scope="module")
def robot():
    return load_robot("paper-spatial")


@pytest.fixture(scope="module")
def flight(robot) -> Recording:
    return simulate(robot, random_motion(robot, duration=10.0))


def without(flight: Recording, *starts: str) -> Recording:
    kept = {k: v for k, v in flight.columns.items() if not k.startswith(starts)}
    return Recording(flight.t, kept)


def test_measured_positions_are_shown(robot, flight: Recording):
    replay = recorded_motion(robot, flight)
    assert np.array_equal(replay.measured.r_S, flight.vector("position"))
    assert replay.predicted is None
    assert replay.velocity_known


def test_without_positions_velocities_are_integrated(robot, flight: Recording):
    replay = recorded_motion(robot, without(flight, "position"))
    # Trapezoids of 0.05 s on a motion of a radian in some seconds.
    off = np.abs(replay.measured.r_S - flight.vector("position")).max()
    assert off < 1e-3


def test_without_velocities_the_cm_rests(robot, flight: Recording):
    replay = recorded_motion(robot, without(flight, "position", "velocity"))
    assert not replay.velocity_known
    found = centroidal_momentum(robot, replay.measured)
    assert np.abs(found.r_cm).max() < 1e-12
    # N s, of a robot of 1110 kg.
    assert np.abs(found.p).max() < 1e-9


def test_momentum_is_conserved(robot, flight: Recording):
    found = centroidal_momentum(robot, recorded_motion(robot, flight).measured)
    h = found.h_rs + found.h_rw
    # The simulated attitude is right to 1e-9 rad.
    assert np.abs(h - h[0]).max() < 1e-7 * np.abs(h[0]).max()
    assert np.abs(found.p - found.p[0]).max() < 1e-7 * np.abs(found.p[0]).max()


def test_the_ghost_goes_where_the_robot_went(robot, flight: Recording):
    result = identify(robot, flight, method="least-squares")
    replay = predicted_motion(result, flight)
    assert replay.predicted is not None
    assert replay.warnings == ()
    assert replay.root is not None
    C = replay.root @ replay.root.T
    assert np.allclose(C, result.base_covariance, atol=1e-9 * np.abs(C).max())
    # A least-squares model of noise-free data: 1e-9, times a prediction over 10 s.
    assert np.abs(replay.predicted.x_WB - replay.measured.x_WB).max() < 1e-6
    assert np.abs(replay.predicted.r_S - replay.measured.r_S).max() < 1e-3
    # The identified inertia alone has the same momentum as the true one.
    assert replay.model is not None
    theirs = centroidal_momentum(robot, replay.measured)
    ours = centroidal_momentum(replay.model, replay.measured)
    assert np.abs(ours.h_rs - theirs.h_rs).max() < 1e-6 * np.abs(theirs.h_rs).max()

    rejected = replace(result, checks=(REFUSED,))
    alone = predicted_motion(rejected, flight)
    assert alone.predicted is alone.model is None
    assert "no scale" in alone.warnings[0]


def test_residuals_are_measured_minus_predicted(robot, flight: Recording):
    measured = recorded_motion(robot, flight).measured
    turn, n = Rotation.from_rotvec([0.0, 0.02, 0.0]), measured.t.size
    up = np.array([0.0, 0.0, 3.0])
    turned = Rotation.from_quat(measured.x_WB) * turn
    predicted = measured._replace(
        x_WB=turned.as_quat(), w=measured.w - 0.1, r_S=measured.r_S + up
    )
    w, attitude, r_S = motion_residuals(measured, predicted).values()
    # Rounding.
    assert np.allclose(w, 0.1, atol=1e-15)
    assert np.allclose(attitude, np.tile([0.0, -0.02, 0.0], (n, 1)), atol=1e-12)
    assert np.allclose(r_S, np.tile(-up, (n, 1)), atol=1e-12)


@pytest.mark.slow
def test_cad_goes_elsewhere_unless_it_is_right(robot, flight: Recording):
    """Of a robot that is as CAD has it, and of one whose base is heavier by half."""
    result = identify(robot, flight, method="least-squares")
    replay = compared_motions(result, flight)
    assert replay.by_cad is not None
    # A prediction with the true numbers; the rest is smoothing, as above.
    assert np.abs(replay.by_cad.x_WB - replay.measured.x_WB).max() < 1e-6

    theta = robot.theta.copy()
    theta[0] *= 1.5
    other = simulate(replace(robot, theta=theta), random_motion(robot, duration=10.0))
    found = identify(robot, other, method="least-squares")
    replay = compared_motions(found, other)
    assert replay.predicted is not None
    assert replay.by_cad is not None
    assert np.abs(replay.predicted.x_WB - replay.measured.x_WB).max() < 1e-6
    # Joints turn by a radian, and the base answers with two thirds of what CAD says.
    assert np.abs(replay.by_cad.x_WB - replay.measured.x_WB).max() > 1e-2

    # What cannot exist does not predict.
    theta[0] = -robot.theta[0]
    wrong = replace(robot, theta=theta)
    impossible = compared_motions(
        identify(wrong, flight, method="least-squares"), flight
    )
    assert impossible.by_cad is None
    assert impossible.predicted is not None
    assert impossible.warnings[0].startswith("no prediction by CAD: ")

    blind = compared_motions(replace(found, checks=(REFUSED,)), other)
    assert blind.by_cad is blind.predicted is None


def test_the_cm_stays_where_it_is(robot, flight: Recording):
    """The mean of the CMs of all bodies, by their masses."""
    motion = recorded_motion(robot, flight).measured
    at = with_resting_cm(scene_of(robot), motion, robot)
    bodies = robot.theta
    m = bodies[:, MASS]
    com = bodies[:, FIRST_MOMENT] / m[:, None]
    n = len(bodies)
    r = at.p[:, :n] + np.einsum("nbij,bj->nbi", at.R[:, :n], com)
    r_cm = np.einsum("b,nbi->ni", m, r) / m.sum()
    assert np.abs(r_cm - r_cm[0]).max() < 1e-9
    # It did move.
    assert np.abs(np.diff(motion.r_S, axis=0)).max() > 1e-3


def test_too_little_is_refused(robot, flight: Recording):
    blind = {**flight.columns, "gyro.x": np.full(flight.t.size, np.nan)}
    blind["gyro.x"][3] = 0.0
    with pytest.raises(InputError, match="complete samples"):
        recorded_motion(robot, Recording(flight.t, blind))


def test_thinning_keeps_at_most_so_many(robot, flight: Recording):
    motion = recorded_motion(robot, flight).measured
    thin = motion.thinned(100)
    assert 50 < thin.t.size <= 100
    assert motion.thinned(motion.t.size).t.size == motion.t.size
    # The wheels are held at 200 rad/s.
    assert np.allclose(motion.wheel_angles()[-1], 200.0 * 10.0)
