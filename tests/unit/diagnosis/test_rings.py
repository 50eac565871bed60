"""A body on a spring under a base that a joint turns by steps: in closed form.

A base of inertia `I`, and a body of inertia `J` that would swing at `f` were the base
held, swing at `f sqrt(1 + J / I)`; SciPy's integration in time is the reference. How a
rigid robot moves is known from MuJoCo.
"""

from dataclasses import replace

import numpy as np
import pytest
from acting_in_mujoco import Torque
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import random_parents, random_robot, random_wheels
from scipy.signal import lsim

from orbident.diagnosis.rings import RigidMotion, rigid_motion, ring_of
from orbident.estimation.signals import Signal, Signals
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.preprocessing.samples import samples_of
from orbident.robot.sensor_schema import declared_sensors

INERTIA = 0.2
"""Of the body over the base's."""
NOISE = {"gyro": 1e-5, "attitude": 1e-5}
T = np.linspace(0, 60, 1501)


def signal(name: str, t: np.ndarray, left: np.ndarray, predicted: np.ndarray) -> Signal:
    axes = tuple("xyz"[: left.shape[1]])
    units = ("rad",) * len(axes)
    return Signal(name, axes, units, t, predicted + left, predicted, 1e-5)


def joint(random: np.random.Generator) -> np.ndarray:
    """A position, rad: slow, with five quick steps."""
    at, size = random.uniform(5, 50, 5), random.uniform(-0.2, 0.2, 5)
    steps = size * (1 + np.tanh((T[:, None] - at) / 0.15)) / 2
    return 0.3 * np.sin(0.5 * T) + steps.sum(axis=1)


def moved(q: np.ndarray, w: np.ndarray) -> RigidMotion:
    """Rates of the base, and those of one joint with its sine and cosine."""
    qd = np.gradient(q, T)
    return RigidMotion(T, np.column_stack([w, qd, np.cos(q) * qd, np.sin(q) * qd]))


def signals(
    seed: int, held: float, zeta: float = 0.005, in_attitude: float = 1.0
) -> tuple[Signals, RigidMotion]:
    """What a fit leaves that takes both for one body, which the joint turns back."""
    random = np.random.default_rng(seed)
    q = joint(random)
    rate = -0.3 * np.gradient(q, T)
    w = 2 * np.pi * held * np.sqrt(1 + INERTIA)
    # The base and the body as one turn by `rate`, and the body swings by `s`:
    # s'' + 2 zeta w s' + w^2 s = -(1 + J / I) rate', of which the base moves by
    # -J / (I + J) s.
    _, swing, _ = lsim(([1, 0], [1, 2 * zeta * w, w**2]), -(1 + INERTIA) * rate, T)
    turn = -INERTIA / (1 + INERTIA) * swing
    axes = random.standard_normal(3)
    every = slice(None, None, 5)
    noise = {
        name: std * random.standard_normal((T.size, 3)) for name, std in NOISE.items()
    }
    of_gyro = np.outer(np.gradient(turn, T), axes) + noise["gyro"]
    of_attitude = in_attitude * np.outer(turn, axes) + noise["attitude"]
    none = np.zeros((T.size, 3))
    left = (
        signal("gyro", T, of_gyro, np.outer(rate, axes)),
        signal("attitude", T[every], of_attitude[every], none[every]),
    )
    return left, moved(q, np.outer(rate, axes))


@pytest.mark.slow
@pytest.mark.parametrize("held", [0.3, 1.0, 3.0])
def test_a_ring_is_found_at_the_frequency_of_the_free_base(held: float):
    for seed in range(4):
        ring = ring_of(*signals(seed, held))
        assert ring is not None
        assert ring.alike
        assert ring.frequency == pytest.approx(held * np.sqrt(1 + INERTIA), rel=0.02)
        assert f"rings at {ring.frequency:.3g} Hz" in ring.reason
        assert f"{{frequency: {ring.frequency:.3g} Hz}}" in ring.remedy


def test_what_the_gyro_alone_shows_is_no_ring_of_the_robot():
    """Nor is a gyro that is shaken evenly."""
    (gyro, attitude), motion = signals(1, 1.0, in_attitude=0.0)
    assert ring_of((gyro, attitude), motion) is None
    shaken = 0.003 * np.sin(6 * np.pi * T)[:, None] * np.ones(3)
    random = np.random.default_rng(0)
    left = 1e-5 * random.standard_normal(attitude.measured.shape)
    still = signal("attitude", attitude.t, left, attitude.predicted)
    shaken_gyro = signal("gyro", T, shaken, gyro.predicted)
    assert ring_of((shaken_gyro, still), motion) is None


def test_of_one_sensor_it_may_be_the_mount():
    """Without an attitude, or without a gyro."""
    left, motion = signals(2, 0.5)
    for one in left:
        ring = ring_of((one,), motion)
        assert ring is not None
        assert not ring.alike
        assert ring.reason.startswith("perhaps")
        assert ring.frequency == pytest.approx(0.5 * np.sqrt(1 + INERTIA), rel=0.02)


def test_what_is_damped_by_half_of_critical_is_no_ring():
    for seed in range(4):
        assert ring_of(*signals(seed, 0.5, zeta=0.5)) is None


@pytest.mark.slow
def test_noise_and_what_moves_with_the_joints_are_no_rings():
    """White noise; encoders of wrong scale or off centre; and a gear with play.

    A motion that repeats itself has lines too.
    """
    for seed in range(5):
        random = np.random.default_rng(seed)
        noise = 1e-5 * random.standard_normal((T.size, 3))
        size, phase = random.standard_normal((2, 5))
        turns = np.outer(T, np.arange(1, 6)) * 2 * np.pi / 12 + phase
        for q in (joint(random), np.sin(turns) @ (size / np.arange(1, 6))):
            motion = moved(q, -0.3 * np.outer(np.gradient(q, T), [0.1, 0.2, 0.3]))
            play = 0.01 * np.sign(np.gradient(q))
            for wrong in (0 * q, 0.05 * q, 0.01 * np.sin(q), play):
                left = np.outer(np.gradient(wrong, T), [0.3, 0.2, 0.1]) + noise
                assert ring_of((signal("gyro", T, left, 0 * left),), motion) is None


def test_few_samples_and_other_sensors_say_nothing():
    (gyro, attitude), motion = signals(3, 1.0)
    few = signal("gyro", T[:16], gyro.measured[:16], 0 * gyro.measured[:16])
    assert ring_of((few,), motion) is None
    assert ring_of((attitude._replace(name="position"),), motion) is None
    assert ring_of((), motion) is None


@pytest.mark.parametrize("seed", range(3))
def test_a_rigid_robot_moves_as_in_mujoco(seed: int):
    """On a robot with a joint that slides, spinning wheels and momentum."""
    parents = random_parents(np.random.default_rng(seed), 3)
    wheels = random_wheels(seed, ["held", "held"])
    robot = random_robot(seed, parents, (1,), wheels, base=10.0)
    exact = {
        "rate": 50.0,
        "gyro": {"angle_random_walk": 1e-10},
        "attitude": {"angle": 1e-10},
        "joints": {"position": 1e-10},
        "wheels": {"position": 1e-10},
    }
    robot = replace(robot, sensors=declared_sensors(exact))
    flight = Flight(robot, random_motion(robot, seed, 10.0), Torque(np.zeros(3)))
    t, true = flight.flown
    found = rigid_motion(robot, samples_of(robot, flight.recorded(0)))
    w, v, _ = np.split(found.rates, [3, 6], axis=1)
    at = np.searchsorted(t, found.t)
    v_S = rotate(quaternion_matrix(true.attitude[at]), v)
    # Where their splines end, rates are wrong by some 1e-6 of themselves.
    assert np.abs(w - true.gyro[at]).max() < 1e-5
    # The CM does not accelerate.
    assert np.ptp(true.velocity[at] - v_S, axis=0).max() < 1e-5
