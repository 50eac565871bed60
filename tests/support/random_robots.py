"""Random robots and motions, with nothing special about any of their numbers."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from orbident.robot.description import Joint, Robot, Wheel
from orbident.robot.parameters import PER_BODY, from_mass_com_inertia
from orbident.simulation.free_floating import BaseState

DUAL_ARM = (0, 1, 2, 0, 4, 5)
"""Parents of two arms of three joints."""


def random_rotation(random: np.random.Generator) -> np.ndarray:
    """A rotation matrix, from the QR factors of a random matrix."""
    Q, R = np.linalg.qr(random.standard_normal((3, 3)))
    Q *= np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


def random_unit_vector(random: np.random.Generator) -> np.ndarray:
    v = random.standard_normal(3)
    return v / np.linalg.norm(v)


def random_quaternion(random: np.random.Generator) -> np.ndarray:
    x = random.standard_normal(4)
    return x / np.linalg.norm(x)


def random_body(random: np.random.Generator, heavier: float = 1.0) -> np.ndarray:
    """`theta_i` of a body that can exist: a positive density has a matrix of second
    moments E > 0, and I = tr(E) 1 - E."""
    mass = heavier * random.uniform(1.0, 5.0)
    com = 0.3 * random.standard_normal(3)
    root = 0.3 * random.standard_normal((3, 3))
    E = mass * (root @ root.T + 0.01 * np.eye(3))
    return from_mass_com_inertia(mass, com, np.trace(E) * np.eye(3) - E)


def random_parents(random: np.random.Generator, joints: int) -> tuple[int, ...]:
    """Any tree; the last joint is on the base, so that there are several arms."""
    parents = [int(random.integers(0, k + 1)) for k in range(joints)]
    return (*parents[:-1], 0) if joints else ()


def random_robot(
    seed: int,
    parents: Sequence[int],
    prismatic: Sequence[int] = (),
    wheels: Sequence[Wheel] = (),
    base: float = 1.0,
) -> Robot:
    """A spatial robot of random bodies, axes and placements.

    Args:
        seed: of the random numbers.
        parents: the body that each joint is on.
        prismatic: indices of the joints that slide.
        wheels: the robot's reaction wheels.
        base: so many times heavier the base is than a link.
    """
    random = np.random.default_rng(seed)
    return Robot(
        name=f"random-{seed}",
        motion="spatial",
        bodies=("base", *(f"link{k + 1}" for k in range(len(parents)))),
        joints=tuple(
            Joint(
                name=f"joint{k + 1}",
                kind="prismatic" if k in prismatic else "revolute",
                parent=parent,
                axis=random_unit_vector(random),
                R_PJ=random_rotation(random),
                p_PJ=0.5 * random.standard_normal(3),
            )
            for k, parent in enumerate(parents)
        ),
        theta=np.array(
            [
                random_body(random, heavier=1.0 if k else base)
                for k in range(len(parents) + 1)
            ]
        ).reshape(-1, PER_BODY),
        feature_point=np.zeros(3),
        wheels=tuple(wheels),
    )


def random_planar_robot(
    seed: int,
    parents: Sequence[int],
    prismatic: Sequence[int] = (),
    wheels: Sequence[Wheel] = (),
) -> Robot:
    """The same in the plane: joints turn about base z or slide perpendicular to it."""
    random = np.random.default_rng(seed)
    robot = random_robot(seed, parents, prismatic, wheels)
    joints = []
    for joint in robot.joints:
        turn, slide = random.uniform(-np.pi, np.pi, 2)
        c, s = np.cos(turn), np.sin(turn)
        along = np.array([np.cos(slide), np.sin(slide), 0.0])
        z = np.array([0.0, 0.0, 1.0])
        joints.append(
            replace(
                joint,
                axis=z if joint.kind == "revolute" else along,
                R_PJ=np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]),
            )
        )
    return replace(robot, motion="planar", joints=tuple(joints))


def random_wheels(
    seed: int, modes: Sequence[Literal["held", "free"]]
) -> tuple[Wheel, ...]:
    """Reaction wheels with random axes."""
    random = np.random.default_rng(seed)
    return tuple(
        Wheel(f"rw{k + 1}", random_unit_vector(random), random.uniform(0.02, 0.1), mode)
        for k, mode in enumerate(modes)
    )


class Swing(NamedTuple):
    """Joints that swing as sines: a smooth motion, known at all times."""

    amplitude: np.ndarray
    rate: np.ndarray
    phase: np.ndarray

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, rates and accelerations, time first."""
        angle = np.multiply.outer(t, self.rate) + self.phase
        q = self.amplitude * np.sin(angle)
        return q, self.amplitude * self.rate * np.cos(angle), -(self.rate**2) * q


def random_swing(seed: int, joints: int) -> Swing:
    """Half a radian at about a radian a second."""
    random = np.random.default_rng(seed)
    return Swing(
        amplitude=random.uniform(0.3, 0.7, joints),
        rate=random.uniform(0.5, 1.5, joints),
        phase=random.uniform(0.0, 2 * np.pi, joints),
    )


def random_start(seed: int, robot: Robot, rate: float = 0.3) -> BaseState:
    """A base that tumbles (in its plane, if it is planar) while its wheels spin."""
    random = np.random.default_rng(seed)
    w, v_S = rate * random.standard_normal((2, 3))
    x_WB = random_quaternion(random)
    if robot.motion == "planar":
        w[:2], v_S[2], x_WB[:2] = 0.0, 0.0, 0.0
        x_WB /= np.linalg.norm(x_WB)
    return BaseState(w, x_WB, v_S, 200.0 * random.standard_normal(len(robot.wheels)))


def sensors_in_space(random: np.random.Generator) -> dict:
    """A tactical gyro, a star tracker and a camera, better or worse; SI."""
    worse = float(random.uniform(1.0, 5.0))
    return {
        "rate": 10.0,
        "gyro": {
            "angle_random_walk": worse * math.radians(0.01) / 60,
            "bias_instability": worse * math.radians(0.3) / 3600,
        },
        "joints": {"position": worse * 2.5e-5},
        "wheels": {"position": 2.5e-5},
        "attitude": {"angle": worse * math.radians(0.01)},
        "position": {"std": worse * 1e-4},
    }
