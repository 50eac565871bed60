"""Noise of attitude and position that lasts, as the core takes it.

Its parts at each boundary are unknowns, and inside an interval samples are whitened by
their filter (`lasting_noise.hpp`), so that intervals stay coupled by boundaries alone.
"""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.output_error.sensors import Sensors
from orbident.model.minimal_sets import conserved_axes
from orbident.robot.description import Robot

TRACKERS = ("attitude", "position")
"""The sensors whose noise may last, in the core's order."""

MARKOV_STD, CORRELATION_TIME, RANDOM_WALK = range(3)

Lasting = Float[np.ndarray, "2 3 3"]
"""The three parameters above by tracker and axis; zero where the noise is white."""

Tables = Mapping[str, Float[np.ndarray, "rows axes"]]


def lasting_noise(robot: Robot, sensors: Sensors) -> Lasting:
    """What lasts of the noise of the axes that count."""
    lasting = np.zeros((2, 3, 3))
    for k, (name, axes) in enumerate(zip(TRACKERS, conserved_axes(robot), strict=True)):
        sensed = sensors.by_name.get(name)
        if sensed is not None:
            lasting[k, axes] = np.transpose(sensed.coloured)[list(axes)]
    return lasting


def first_lasting(lasting: Lasting, dt: float) -> Float[np.ndarray, " parts"]:
    """Standard deviations of the parts at the first row, in the core's order.

    A walk is zero at the first sample; here it begins one sample earlier.
    """
    std = np.stack(
        [lasting[..., MARKOV_STD], lasting[..., RANDOM_WALK] * np.sqrt(dt)], axis=-1
    )
    return std[std > 0]


def at_level(lasting: Lasting, assumed: Tables, weights: Tables) -> Lasting:
    """The lasting noise, at the level of noise that the weights of sensors have.

    All parts of a sensor's noise are as many times as large as assumed as the white
    one; the largest weight is that of samples which are no outliers.
    """
    scaled = lasting.copy()
    for k, name in enumerate(TRACKERS):
        if lasting[k].any():
            level = float(assumed[name].max() / weights[name].max())
            scaled[k][:, [MARKOV_STD, RANDOM_WALK]] *= level
    return scaled


def innovated(
    t: Float[np.ndarray, " rows"],
    lasting: Lasting,
    residuals: Tables,
    plain: Tables,
    used: Tables,
) -> dict[str, Float[np.ndarray, "rows axes"]]:
    """Residuals of all sensors over their noise, white where noise lasts too.

    Those of a tracker whose noise lasts become innovations over the whole recording.

    Args:
        t: of the rows, s.
        lasting: at the level of the weights.
        residuals: over the white noise.
        plain: 1 over the white noise's deviation; zero without a sample.
        used: the same, less for outliers: these say less of what lasts.
    """
    found = dict(residuals)
    for k, name in enumerate(TRACKERS):
        if name not in residuals:
            continue
        for axis in np.flatnonzero(lasting[k].any(axis=1)):
            table = found[name] = np.array(found[name])
            seen = plain[name][:, axis] > 0
            weight, counted = (w[name][seen, axis] for w in (plain, used))
            errors = table[seen, axis] / weight
            variance = counted**-2
            v, S = _core.innovations(
                t[seen], errors[:, None], variance, lasting[k, axis]
            )
            # What is not predicted of an outlier counts in full.
            table[seen, axis] = v[:, 0] / np.sqrt(S - variance + weight**-2)
    return found
