"""Columns of joint velocities that are not the rate of the joint's positions.

Drivers fill them with zeros or with a limit, with the motor's rate, or with one that
was filtered. Integrated, a rate `v` must give the position, but for a bias: over any
span of time, `dq = c dt + integral of v`. Integration adds little noise, and a
derivative much. What `v` is instead shows in `dq = c dt + integral of v / G + T dv`: it
is `G` times the rate, and later by `G T`; exactly so where it is low-passed to first
order.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.gaussian import white_std
from orbident.recordings.recording import Recording

OFF = 0.01
"""Part of the motion, or of the scale: a tachometer's is known to some tenths of a
percent."""

SURE = 5.0
"""Times what noise and integration leave."""

EXPLAINED = 0.1
"""Part of the misfit that a gain and a lag may leave, to be named."""

LATE = 0.1
"""Times the usual step: splines are off by less."""

UNLIKE = 1e-4
"""One over the gain of the fastest motor."""

SPANS = 16
"""Part of the recording over which is compared: long enough for a joint to move far,
short enough for gaps and wrong samples to spoil few. One over it."""

FEWEST = 2 * SPANS
"""Samples with position and velocity, and spans without a gap."""

MOST, ROUNDS = 0.9, 3
"""Part of the spans that counts, the others may have wrong samples; and how often they
are chosen."""

GAP = 10.0
"""Times the usual step: over a longer one rates are not integrated."""


def false_rates(
    recording: Recording, joints: tuple[str, ...]
) -> Iterator[tuple[str, str]]:
    """Columns of velocities that do not belong to the positions, and what they are.

    Args:
        recording: without what is no measurement, angles unwrapped.
        joints: their names.
    """
    for joint in joints:
        position, velocity = (
            f"joint.{joint}.{what}" for what in ("position", "velocity")
        )
        if not recording.has(position, velocity):
            continue
        q, v = recording.column(position), recording.column(velocity)
        both = ~(np.isnan(q) | np.isnan(v))
        if both.sum() >= FEWEST:
            words = _instead(recording.t[both], q[both], v[both])
            if words:
                yield velocity, words


def _instead(
    t: Float[np.ndarray, " n"], q: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> str | None:
    """What `v` is instead of the rate of `q`; None where it is the rate."""
    # Every other one of an odd number of samples is the last.
    t, q, v = (x[: x.size - 1 + x.size % 2] for x in (t, q, v))
    parts = np.cumsum(np.diff(t, prepend=t[0]) > GAP * np.median(np.diff(t)))
    span = t.size // SPANS
    whole = parts[span:] == parts[:-span]
    if whole.sum() < FEWEST:
        return None

    def over(x: np.ndarray) -> np.ndarray:
        return (x[span:] - x[:-span])[whole]

    def left(y: np.ndarray, *columns: np.ndarray) -> tuple[float, np.ndarray]:
        A, b = np.column_stack([over(x) for x in (t, *columns)]), over(y)
        x, off = np.zeros(A.shape[1]), np.zeros(b.size)
        kept = np.ones(b.size, dtype=bool)
        for _ in range(ROUNDS):
            x = np.linalg.lstsq(A[kept], b[kept])[0]
            off = np.abs(b - A @ x)
            kept = off <= np.quantile(off, MOST)
        return float(np.sqrt(np.mean(off[kept] ** 2))), x[1:]

    angle = CubicSpline(t, v).antiderivative()(t)
    by_half = CubicSpline(t[::2], v[::2]).antiderivative()(t)
    unsure, _ = left(angle - by_half)
    moved, _ = left(q)
    misfit, _ = left(q - angle)
    if misfit <= SURE * np.hypot(_noise(q), unsure):
        return None
    if not np.ptp(v):
        return f"is {v[0] + 0.0:g} throughout"
    rest, (inverse, lag) = left(q, angle, v)
    said = ""
    if rest < EXPLAINED * misfit and abs(inverse) > UNLIKE:
        said = _in_words(1 / inverse, lag / inverse, float(np.median(np.diff(t))))
    return said or ("does not follow it" if misfit > OFF * moved else None)


def _in_words(gain: float, late: float, step: float) -> str:
    """What is wrong with a rate; empty where nothing is."""
    said = [f"is {gain:.4g} times that"] if abs(gain - 1) > OFF else []
    if abs(late) > LATE * step:
        said.append(f"is {abs(late):.3g} s {'late' if late > 0 else 'early'}")
    return " and ".join(said)


def _noise(q: Float[np.ndarray, " n"]) -> float:
    """Std of an encoder's samples: fourth differences have 70 times its variance."""
    steps = np.abs(np.diff(q))
    count = steps[steps > 0].min(initial=np.inf)
    bends = float(white_std(q))
    return float(np.hypot(bends, count if np.isfinite(count) else 0.0))
