"""What the filter takes from a recording: its samples, and their noise."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursive.kept_pieces import KeptPieces, Piece
from orbident.estimation.recursive.noise import Noise, noise_of
from orbident.estimation.stretches import smoothed_rate
from orbident.preprocessing.histories import DERIVED
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.settings import Settings
from orbident.robot.description import Robot
from orbident.threads import ahead

ENDS = 0.5
"""s: so near to the ends of a recording a smoothed rate is ten times as wrong."""


class Given(NamedTuple):
    """A recording, as the filter takes it: at least one sample, all complete."""

    t: Float[np.ndarray, " n"]
    samples: Float[np.ndarray, "n all"]
    """Packed, one a row."""
    noise: Noise


class Pieces(NamedTuple):
    """The same of a recording that may be long."""

    noise: Noise
    every: Callable[[], Iterator[Piece]]
    """From the first one each time; some may be empty."""


def given_of(robot: Robot, samples: Samples) -> Given:
    """All samples that are as good as they are said to be.

    Raises:
        InputError: there is none, or the noise of the base rate is not known.
    """
    rate, scatter = smoothed_rate(samples, Settings())
    noise = noise_of(robot, samples, scatter)
    ends = float(samples.t[0]), float(samples.t[-1])
    t, every = _packed(samples, rate, *_trusted(samples, *ends))
    if not t.size:
        raise none_complete(samples.source)
    return Given(t, every, noise)


def none_complete(source: str) -> InputError:
    """The error of a recording without a complete sample."""
    return InputError(
        f"{source}: no complete sample; record joints, wheels, gyro and attitude "
        "together"
    )


def pieces_of(problem: MomentumProblem) -> Pieces:
    """The same, stretch by stretch where a recording is read so.

    Raises:
        InputError: as `given_of`.
    """
    robot, samples, stretches = problem.robot, problem.samples, problem.stretches
    if stretches is None or problem.extent is None:
        given = given_of(robot, samples)
        return Pieces(given.noise, lambda: iter([Piece(given.t, given.samples)]))
    _, scatter = smoothed_rate(samples, stretches.settings)
    ends = _trusted(samples, problem.extent.start, problem.extent.end)

    def packed() -> Iterator[Piece]:
        for part, rate in stretches.with_rates():
            yield _packed(part, rate, *ends)

    kept = KeptPieces(packed)
    return Pieces(noise_of(robot, samples, scatter), lambda: ahead(kept()))


def _packed(
    samples: Samples, rate: Float[np.ndarray, "samples 3"], first: float, last: float
) -> Piece:
    at = samples.batch(0, samples.t.size)
    complete = at.turning & np.isfinite(rate).all(axis=1)
    complete &= (samples.t >= first) & (samples.t <= last)
    v_S = np.where(at.moving[:, None], at.v_S, np.nan)
    every = np.hstack([at.q, at.qd, at.w, at.x_WB, at.qd_rw, v_S, rate, at.h_given])
    return Piece(samples.t[complete], every[complete])


def _trusted(samples: Samples, start: float, end: float) -> tuple[float, float]:
    """First and last time at which rates are as good as they are said to be, s."""
    derived = DERIVED in samples.origins["joint_rates"]
    margin = ENDS if derived and end - start > 4 * ENDS else 0.0
    return start + margin, end - margin
