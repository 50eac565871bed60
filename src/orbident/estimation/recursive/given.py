"""What the filter takes from a recording: its samples, and their noise."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.kept_pieces import Piece
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursive.noise import Noise, noise_of
from orbident.estimation.stretches import scatter, smoothed_rate
from orbident.preprocessing.histories import DERIVED
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.settings import Settings
from orbident.robot.description import Robot
from orbident.threads import ahead

ENDS = 0.5
"""s: so near to the ends of a recording a smoothed rate is ten times as wrong."""


PACKED = 4096
"""Samples that are packed at once: all of them at once take their memory four times."""


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
    settings = Settings()
    t, every = packed(samples, smoothed_rate(samples, settings), trusted(samples))
    noise = noise_of(robot, samples, scatter(samples, settings))
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
    robot, samples, kept = problem.robot, problem.samples, problem.pieces
    if kept is None:
        given = given_of(robot, samples)
        return Pieces(given.noise, lambda: iter([Piece(given.t, given.samples)]))
    noise = noise_of(robot, samples, scatter(samples, Settings()))
    return Pieces(noise, lambda: ahead(kept()))


def packed(
    samples: Samples,
    rate: Float[np.ndarray, "samples 3"],
    times: tuple[float, float],
) -> Piece:
    """The samples that are complete and as good as they are said to be, one a row.

    Args:
        samples: consecutive ones.
        rate: the smoothed base rate, rad/s.
        times: between these they are that good, s.
    """
    good = np.isfinite(rate).all(axis=1)
    good &= (samples.t >= times[0]) & (samples.t <= times[1])
    kept, tables = [], []
    for k, at in enumerate(samples.batches(PACKED)):
        own = slice(k * PACKED, (k + 1) * PACKED)
        complete = at.turning & good[own]
        v_S = np.where(at.moving[:, None], at.v_S, np.nan)
        every = [at.q, at.qd, at.w, at.x_WB, at.qd_rw, v_S, rate[own], at.h_given]
        kept.append(samples.t[own][complete])
        tables.append(np.hstack(every)[complete])
    return Piece(np.concatenate(kept), np.concatenate(tables))


def trusted(samples: Samples) -> tuple[float, float]:
    """First and last time at which rates are as good as they are said to be, s.

    Args:
        samples: of the whole recording, or of a digest of it.
    """
    start, end = float(samples.t[0]), float(samples.t[-1])
    derived = DERIVED in samples.origins["joint_rates"]
    margin = ENDS if derived and end - start > 4 * ENDS else 0.0
    return start + margin, end - margin
