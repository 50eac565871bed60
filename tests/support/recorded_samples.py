"""Samples one by one, as a loop has them: those of a recording, or random ones."""

from collections.abc import Iterator

import numpy as np
from random_robots import random_quaternion

from orbident.estimation.recursive.filter import Sample
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot


def stream(samples: Samples, w_smooth: np.ndarray | None = None) -> Iterator[Sample]:
    """All samples; NaN where something was not measured.

    Args:
        samples: of a recording.
        w_smooth: the smoothed base rate; the gyro's samples where it is None.
    """
    at, nothing = samples.batch(0, samples.t.size), np.full(3, np.nan)
    for k, t in enumerate(samples.t):
        w = at.w[k] if at.turning[k] else nothing
        yield Sample(
            t=float(t),
            q=at.q[k],
            qd=at.qd[k],
            w=w,
            x_WB=at.x_WB[k],
            qd_rw=at.qd_rw[k],
            v_S=at.v_S[k] if at.moving[k] else nothing,
            w_smooth=w if w_smooth is None else w_smooth[k],
            h_given=np.zeros(3),
        )


def random_samples(robot: Robot, count: int) -> list[Sample]:
    """What no robot does, but the equations are the same."""
    random, joints = np.random.default_rng(1), len(robot.joints)
    samples = []
    for k in range(count):
        w, noise, v_S, h_given = random.standard_normal((4, 3))
        x_WB = random_quaternion(random)
        if robot.motion == "planar":
            w[:2] = noise[:2] = x_WB[:2] = 0.0
            x_WB /= np.linalg.norm(x_WB)
        q, qd = random.standard_normal((2, joints))
        qd_rw = 10.0 * random.standard_normal(len(robot.wheels))
        smooth = w + 0.1 * noise
        samples.append(Sample(0.1 * k, q, qd, w, x_WB, qd_rw, v_S, smooth, h_given))
    return samples
