"""Is a recording one at rest? Motion is smooth, and no noise explains it.

Gauss-Markov processes and random walks explain much that lasts, motion too, but not
that it goes on: slow motion is a polynomial in time, and faster motion leaves
innovations that are not white.
"""

import numpy as np
from jaxtyping import Float
from scipy.special import chdtri

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.whiteness import LOW
from orbident.noise.noise_model import MARKOV, WALK, NoiseModel
from orbident.recordings.columns import part_of
from orbident.recordings.recording import Recording

DEGREE = 5
"""Degree of the polynomial with which slow motion is looked for."""

CHANCE = 1e-6
"""Probability that the noise of one axis looks like slow motion."""

POWER = 2.0
"""Most power of innovations at rest, at the lowest twentieth of all frequencies, over
white noise: a real motion capture system at rest on its table, which shakes, has 1.5;
flights have 4 to 20."""

MOVED = 5e-3
"""rad or m: the play and the counts of a joint that is held are less."""


def check_joints(recording: Recording) -> None:
    """Refuse a recording in which a joint moves.

    Raises:
        InputError: so.
    """
    for name, values in recording.columns.items():
        if part_of("joint", name) is None or not name.endswith(".position"):
            continue
        seen = values[np.isfinite(values)]
        if seen.size and np.ptp(seen) > MOVED:
            raise InputError(
                f"{recording.source}: {name} moves by {np.ptp(seen):.3g} (rad or m), "
                f"and at rest it would by {MOVED:g} at most; give a recording at rest"
            )


def check_still(
    where: str,
    t: Float[np.ndarray, " n"],
    x: Float[np.ndarray, " n"],
    model: NoiseModel,
) -> None:
    """Refuse samples that move.

    Args:
        where: the recording and the axis, for the message.
        t: of the samples, s.
        x: the samples.
        model: their most likely noise.

    Raises:
        InputError: so.
    """
    found, limit = drift(t, x, model), float(chdtri(DEGREE, CHANCE))
    if found > limit:
        raise InputError(
            f"{where} moves: a polynomial in time lowers chi-square by {found:.3g}, "
            f"where noise does by less than {limit:.3g}; give a recording at rest"
        )
    power = low_power(model)
    if power > POWER:
        raise InputError(
            f"{where} moves: what no noise model predicts has {power:.3g} times the "
            f"power of white noise at low frequencies, where rest has less than "
            f"{POWER:g}; give a recording at rest"
        )


def drift(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], model: NoiseModel
) -> float:
    """How much a polynomial lowers chi-square; at rest this is chi-square distributed.

    A straight line alone lowers it by the square of the slope over its deviation.
    """
    at = 2 * (t - t[0]) / (t[-1] - t[0]) - 1
    rows = np.column_stack([np.polynomial.legendre.legvander(at, DEGREE), x])
    coloured = np.array([model.value(name) for name in MARKOV + WALK])
    variance = np.full(t.size, model.value("white") ** 2)
    innovations, S = _core.innovations(
        np.ascontiguousarray(t), rows, variance, coloured
    )
    white = innovations / np.sqrt(S)[:, None]
    # Below the constant's row, the last column is what each polynomial explains.
    R = np.asarray(np.linalg.qr(white, mode="r"))
    return float(np.sum(R[1:-1, -1] ** 2))


def low_power(model: NoiseModel) -> float:
    """Power of the innovations at low frequencies, over that at all."""
    power = np.abs(np.fft.rfft(model.innovations)[1:]) ** 2
    low = max(int(LOW * power.size), 1)
    return float(np.mean(power[:low]) / np.mean(power))
