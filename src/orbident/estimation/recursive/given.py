"""What the filter takes from a recording: its samples, and their noise."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.recursive.noise import Noise, noise_of
from orbident.preprocessing.base_motion import SMOOTHED
from orbident.preprocessing.histories import DERIVED
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.smoothing import smooth
from orbident.robot.description import Robot

ENDS = 0.5
"""s: so near to the ends of a recording a smoothed rate is ten times as wrong."""


class Given(NamedTuple):
    """A recording, as the filter takes it: at least one sample, all complete."""

    t: Float[np.ndarray, " n"]
    samples: Float[np.ndarray, "n all"]
    """Packed, one a row."""
    noise: Noise


def given_of(robot: Robot, samples: Samples) -> Given:
    """All samples that are as good as they are said to be.

    Raises:
        InputError: there is none, or the noise of the base rate is not known.
    """
    rate, scatter = smoothed_rate(samples)
    noise = noise_of(robot, samples, scatter)
    at = samples.batch(0, samples.t.size)
    first, last = _trusted(samples)
    complete = at.turning & np.isfinite(rate).all(axis=1)
    complete &= (samples.t >= first) & (samples.t <= last)
    if not complete.any():
        raise InputError(
            f"{samples.source}: no complete sample; record joints, wheels, gyro and "
            "attitude together"
        )
    v_S = np.where(at.moving[:, None], at.v_S, np.nan)
    every = np.hstack([at.q, at.qd, at.w, at.x_WB, at.qd_rw, v_S, rate])
    return Given(samples.t[complete], every[complete], noise)


def _trusted(samples: Samples) -> tuple[float, float]:
    """From when to when rates are as good as they are said to be, s."""
    derived = DERIVED in samples.origins["joint_rates"]
    margin = ENDS if derived and np.ptp(samples.t) > 4 * ENDS else 0.0
    return float(samples.t[0]) + margin, float(samples.t[-1]) - margin


def smoothed_rate(samples: Samples) -> tuple[Float[np.ndarray, "samples 3"], float]:
    """The base rate as smooth as joint rates are, and the gyro's scatter, rad/s."""
    w = np.column_stack(samples.w)
    if samples.origins["base_rate"] == SMOOTHED:
        return w, 0.0
    smoothed = smooth(samples.t, w, name=f"{samples.source}: gyro")
    return smoothed.x, float(np.nan_to_num(smoothed.noise_std).max())
