"""Suspects that what encoders of joints show has an error with a course.

One that is not in the middle of its axis is off by `a sin(q) + b cos(q)`, and one
behind a gear by the same of `2 pi k q`, with `k` periods in a radian. On the motor of a
joint that gives way it shows `q_m = q + c tau / I`, with the torque that the motion
takes and the inertia that the joint carries, as fitted, and on that of one whose gear
has play `q_m = q + c sign(qd)`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.optimize import fminbound

from orbident.diagnosis.shifts import less
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.diagnosis.torque_columns import measured_motion
from orbident.estimation.estimate import Estimate
from orbident.estimation.levels import outstanding
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.model.kinematics import carried_inertia

SMALL = 1e-5
"""rad, m, or rad over the unit of a course: far below what would be seen."""

BETWEEN = 0.1
"""Part of a joint's usual rate below which a gear with play is between its sides."""

SMALL_BEND = 1e-4
"""s^2: of a joint that gives way at 16 Hz."""

LEAST_CARRIED = 1e-6
"""kg m^2 or kg: a joint without anything behind it does not give way."""

CYCLES = 8
"""Periods over a joint's motion: fewer of them are no line."""

FINEST = 200.0
"""Periods in a radian, 1300 a turn: more than gears and encoders have."""

PADDED = 4
"""Times the length of a spectrum: a line between two of its frequencies is seen."""


def joint_errors(problem: MomentumProblem, shown: Estimate) -> Iterator[Suspect]:
    """All joints at once: with time, over a turn, with the way, with the load."""
    names, t = problem.robot.joint_names, problem.recording.t
    if not names:
        return
    motion = measured_motion(problem.samples, t)
    theta = problem.sets.theta(shown.parameters.base.values)
    found = replace(problem.robot, theta=theta)
    carried = [carried_inertia(found, k) for k in range(len(names))] @ theta.ravel()
    bend = motion.torques(found) / np.maximum(carried, LEAST_CARRIED)
    q = motion.q
    qd = motion.rates[:, 3 : 3 + len(names)]
    slow = np.maximum(BETWEEN * np.std(qd, axis=0), SMALL)
    elapsed = (t - t[0]) / (t[-1] - t[0])

    def most(c: Numbers) -> tuple[str, float]:
        """The joint whose numbers are the largest, and how large."""
        size = np.linalg.norm(c.reshape(len(names), -1), axis=1)
        return names[int(np.argmax(size))], float(size.max())

    def drifting(c: Numbers) -> str:
        return "joint {}: its position drifts by {:.2g} over the recording".format(
            *most(c)
        )

    def off_centre(c: Numbers) -> str:
        return (
            "the encoder of joint {} is off the centre of its axis (an error of {:.2g} "
            "rad over each turn)".format(*most(c))
        )

    def playing(c: Numbers) -> str:
        name, size = most(c)
        return (
            f"gears have backlash, between an encoder on the motor and the link: joint "
            f"{name} has a play of {2 * size:.2g} rad"
        )

    def soft(c: Numbers) -> str:
        name, bend = most(np.maximum(c, SMALL**2))
        frequency = 1 / (2 * np.pi * bend**0.5)
        return (
            "joints are flexible, between an encoder on the motor and the link: joint "
            f"{name} gives way, as if it swung at {frequency:.3g} Hz ('flexible' in "
            "the robot file says so)"
        )

    one = np.ones(len(names))
    yield _of_joints(names, drifting, SMALL * one, [elapsed[:, None] * one])
    yield _of_joints(
        names, off_centre, SMALL * np.tile(one, 2), [np.sin(q), np.cos(q) - 1]
    )
    # No play is less than none, and no spring pushes the other way.
    yield _of_joints(names, playing, SMALL * one, [qd / np.hypot(qd, slow)], least=0.0)
    yield _of_joints(names, soft, SMALL_BEND * one, [bend], least=0.0)


def _of_joints(
    names: Sequence[str],
    words: Callable[[Numbers], str],
    small: Numbers,
    courses: Sequence[Float[np.ndarray, "n joints"]],
    least: float = -np.inf,
) -> Suspect:
    """An error of each joint by so much of each course; joint by joint."""
    by_joint = np.stack(courses, axis=2)

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        sizes = np.maximum(c, least).reshape(len(names), -1)
        for k, name in enumerate(names):
            error = by_joint[:, k] @ sizes[k]
            recording = less(recording, f"joint.{name}", error[:, None])
        return problem.amended(recording=recording)

    return Suspect(words, small, corrected)


def ripples(problem: MomentumProblem, shown: Estimate) -> Iterator[Suspect]:
    """Encoders whose error is periodic in the joint's angle, as behind a gear."""
    recording = problem.recording
    for signal in shown.signals:
        if signal.sensor != "joints":
            continue
        left = signal.measured - signal.predicted
        of_joints = zip(
            signal.axes, signal.units, signal.predicted.T, left.T, strict=True
        )
        for name, unit, q, error in of_joints:
            k = _line_over(q, error)
            if k is None:
                continue

            often = f"{2 * np.pi * k:.3g} times a turn"
            if unit == "m":
                often = f"{k:.3g} times a metre"

            def words(c: Numbers, name: str = name, often: str = often) -> str:
                return (
                    f"the encoder of joint {name} has a ripple of "
                    f"{np.linalg.norm(c):.2g} (SI), {often}, as from a gear's teeth"
                )

            turned = 2 * np.pi * k * np.interp(recording.t, signal.t, q)[:, None]
            courses = [np.sin(turned), np.cos(turned)]
            yield _of_joints([name], words, np.full(2, SMALL), courses)


def _line_over(
    q: Float[np.ndarray, " n"], error: Float[np.ndarray, " n"]
) -> float | None:
    """Periods in a radian of the line that stands out of `sum(error e^(2 pi i k q))`.

    None where none does.
    """
    width = 1 / (2 * FINEST)
    place = np.floor((q - q.min()) / width).astype(int)
    if not place.max() / 2 > CYCLES or not error.any():
        return None
    size = 2 ** int(np.ceil(np.log2(PADDED * (place.max() + 1))))
    off = error - error.mean()
    power = np.abs(np.fft.rfft(np.bincount(place, off), size)) ** 2
    first = int(np.ceil(CYCLES * size / (place.max() + 1)))
    k = first + int(np.argmax(power[first:]))
    if power[k] < outstanding(1, power.size) * np.median(power[first:]):
        return None
    step = 1 / (size * width)

    def line(k: float) -> float:
        return -abs(off @ np.exp(2j * np.pi * k * q))

    return float(np.array(fminbound(line, (k - 1) * step, (k + 1) * step)))
