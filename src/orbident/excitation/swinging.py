"""Motions that excite a robot with joints that swing: the best of its stiff twin's.

Nobody drives a joint on a spring, and nothing is proven of how it swings. So motions
are searched for the robot whose springs do not give way, of one number of harmonics
after another: with more of them more rings. Each is flown with its springs as they are
declared, and made smaller until it keeps to the limits. The one is taken whose
Cramer-Rao bound is smallest, with frequencies and dampings unknown.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.bound import log_deviation
from orbident.excitation.conditions import BaseExtremes, Conditions
from orbident.excitation.floating import was_at_rest
from orbident.excitation.guarantee import (
    SHARES,
    Extremes,
    broken_by_base,
    broken_by_joints,
    extremes_of,
)
from orbident.excitation.search import Effort, MotionSearch, Progress
from orbident.excitation.table_points import points_on_table, size_of_table
from orbident.files.json_parts import nulled
from orbident.model.rotations import quaternion_matrix, rotation_angle
from orbident.robot.description import Coupling, Robot
from orbident.simulation.flight import FreeFlying
from orbident.simulation.simulate import fly_along
from orbident.trajectories.trajectory import Trajectory

OF_THE_TWIN = (
    "best_random_start",
    "price_of_random_start",
    "median_random_start",
    "evaluations",
    "scores",
)
"""What a design says of the robot whose springs do not give way."""


class Swinging(NamedTuple):
    """A motion as the robot makes it with its springs, within its limits."""

    motion: Trajectory
    joints: Extremes
    value: float
    """Logarithm of the geometric mean of the least deviations."""
    base: BaseExtremes
    """How far the base goes at the samples of the flight."""
    swings: Float[np.ndarray, " joints"]
    """How far each joint goes, rad or m."""
    share: float
    """Share of the amplitude that was asked for."""


def stiff(robot: Robot) -> Robot:
    """The robot with its passive joints held where their springs rest.

    Raises:
        InputError: it has no other joints.
    """
    driven = [name for name in robot.joint_names if name not in robot.passive]
    if not driven:
        raise InputError(
            f"{robot.name}: joints: all are passive, and a motion is designed for "
            "joints with motors; add one, or fly a motion of the wheels"
        )
    held = (Coupling(name, driven[0], 0.0, 0.0) for name in robot.passive)
    return replace(robot, passive={}, couplings=(*robot.couplings, *held))


@dataclass(eq=False)
class SwingSearch(MotionSearch):
    """Motions that are designed for the stiff twin, flown with springs."""

    robot: Robot
    given: Conditions
    harmonics: Sequence[int]
    design: Callable[..., Trajectory]
    """`design_excitation`, which finds the best motion of a robot without springs."""

    def search(self) -> None:
        """Design and fly a motion of each number of harmonics."""
        effort, twin, parts = self.effort, stiff(self.robot), len(self.harmonics)
        for done, number in enumerate(self.harmonics):
            left = (1 - effort.used) / (parts - done)
            if left <= 0:
                return
            motion = self.design(
                twin,
                starts=None if effort.budget else ceil(effort.starts / parts),
                budget=effort.budget and left * effort.budget,
                conditions=replace(self.given, harmonics=number),
                progress=partial(self._report, done),
            )
            made = motion.design or {}
            self.searched.starts += made["starts"]
            self._fly(motion)
            if made["interrupted"]:
                raise KeyboardInterrupt

    def _report(self, done: int, found: Progress) -> None:
        fraction = (done + found.fraction) / len(self.harmonics)
        starts = self.searched.starts + found.starts
        self.report(found._replace(fraction=fraction, starts=starts))

    def _fly(self, motion: Trajectory) -> None:
        """Keeps the motion, made smaller where it does not keep to its limits."""
        robot, given, limits = self.robot, self.given, self.given.limits
        still = was_at_rest(robot, given.initial, given.start)
        for share in SHARES:
            smaller = replace(motion, a=share * motion.a, b=share * motion.b)
            joints = extremes_of(smaller)
            flight = fly_along(robot, smaller, robot.sensors.rows_per_second)
            base = _extremes(robot, flight)
            if not (broken_by_joints(joints, limits) or broken_by_base(base, limits)):
                momentum = "at-rest" if still else "unknown"
                value = log_deviation(robot, smaller, momentum)
                swings = np.abs(flight.q).max(axis=0)
                self.searched.random.append(
                    Swinging(smaller, joints, value, base, swings, share)
                )
                return
        self.searched.refused += 1


def design_swinging(
    robot: Robot,
    given: Conditions,
    effort: Effort,
    harmonics: Sequence[int],
    design: Callable[..., Trajectory],
    progress: Callable[[Progress], object] = lambda _: None,
) -> Trajectory:
    """The best motion of a robot with passive joints, on springs as they are declared.

    Of each number of harmonics the best motion of the stiff twin is flown. An interrupt
    ends the search, and the best that was flown until then is kept. `design` is that of
    robots whose joints have motors, and `progress` is called as it does.

    Raises:
        InputError: all joints are passive, no sensor has a noise, no motion keeps to
            the limits, or as of `design`.
    """
    search = SwingSearch(effort, progress, robot, given, harmonics, design)
    searched = search.run()
    if not searched.random:
        raise InputError(
            f"{robot.name}: limits: as its joints swing, none of "
            f"{searched.refused} motions keeps to those of the base, however small; "
            "raise a limit, or give less momentum"
        )
    best = min(searched.random, key=lambda each: each.value)
    value = _mean(best)
    names, of_base = robot.joint_names, best.base._asdict()
    joints = best.joints.beside(given.limits, names)
    swings = dict(zip(names, best.swings.tolist(), strict=True))
    made = {
        **(best.motion.design or {}),
        "value": value,
        "searched_value": value,
        "starts": searched.starts,
        "beyond_limits": searched.refused,
        "interrupted": searched.interrupted,
        "by_harmonics": [
            {"harmonics": each.motion.a.shape[1], "value": _mean(each)}
            for each in searched.random
        ],
        "amplitude_kept": best.share,
        "proven": {
            "joints": {k: x for k, x in joints.items() if k not in robot.passive}
        },
        "extremes": {
            **{key: of_base[key] for key in ("rate", "excursion", "wheel_speed")},
            "table": best.base.table and list(best.base.table),
            "swings": {name: swings[name] for name in robot.passive},
        },
    }
    for key in OF_THE_TWIN:
        made.pop(key, None)
    return replace(_of_driven(best.motion, robot), design=made)


def _mean(found: Swinging) -> float | None:
    """The geometric mean of the deviations."""
    return nulled(float(np.exp(found.value)))


def _of_driven(motion: Trajectory, robot: Robot) -> Trajectory:
    """The motion of the joints that are driven."""
    kept = [k for k, name in enumerate(motion.joints) if name not in robot.passive]
    return replace(
        motion,
        joints=tuple(motion.joints[k] for k in kept),
        a=motion.a[kept],
        b=motion.b[kept],
        start=motion.start[kept],
        end=motion.end[kept],
    )


def _extremes(robot: Robot, flight: FreeFlying) -> BaseExtremes:
    """How far the base goes at the samples of a flight."""
    x, table = flight.attitude, None
    if robot.motion == "planar":
        R = quaternion_matrix(x)
        table = size_of_table(points_on_table(robot, flight.q, R, flight.r_S))
    return BaseExtremes(
        rate=float(np.linalg.norm(flight.w, axis=1).max()),
        excursion=float(rotation_angle(x, x[0]).max()),
        wheel_speed=float(np.abs(flight.qd_rw).max(initial=0.0)),
        table=table,
    )
