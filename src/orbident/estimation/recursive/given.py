"""What the filter takes from a recording: its samples, and their noise."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
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

    noise = noise_of(robot, samples, scatter)
    _core.give_back_memory()

    def packed(part: tuple[Samples, Float[np.ndarray, "n 3"]]) -> Piece:
        return _packed(*part, *ends)

    # Nothing here holds a part while the next one is worked out.
    kept = KeptPieces(lambda: map(packed, stretches.with_rates()))
    return Pieces(noise, lambda: ahead(kept()))


def _packed(
    samples: Samples, rate: Float[np.ndarray, "samples 3"], first: float, last: float
) -> Piece:
    trusted = np.isfinite(rate).all(axis=1)
    trusted &= (samples.t >= first) & (samples.t <= last)
    times, tables = [], []
    for k, at in enumerate(samples.batches(PACKED)):
        own = slice(k * PACKED, (k + 1) * PACKED)
        complete = at.turning & trusted[own]
        v_S = np.where(at.moving[:, None], at.v_S, np.nan)
        every = [at.q, at.qd, at.w, at.x_WB, at.qd_rw, v_S, rate[own], at.h_given]
        times.append(samples.t[own][complete])
        tables.append(np.hstack(every)[complete])
    return Piece(np.concatenate(times), np.concatenate(tables))


def _trusted(samples: Samples, start: float, end: float) -> tuple[float, float]:
    """First and last time at which rates are as good as they are said to be, s."""
    derived = DERIVED in samples.origins["joint_rates"]
    margin = ENDS if derived and end - start > 4 * ENDS else 0.0
    return start + margin, end - margin
