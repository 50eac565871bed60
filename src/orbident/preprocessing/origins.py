"""How the signals of samples were obtained."""

from enum import Flag, auto


class Origin(Flag):
    """How a signal was obtained; several ways where its columns differ in that."""

    MEASURED = auto()
    SMOOTHED_POSITIONS = auto()
    SMOOTHED_POSITIONS_AND_RATES = auto()
    SMOOTHED_RATES = auto()
    SMOOTHED_ATTITUDE = auto()
    INTEGRATED_GYRO = auto()
    FUSED_ATTITUDE = auto()
    INTEGRATED_ACCELEROMETER = auto()
    SUMMED_INCREMENTS = auto()
    MISSING = auto()


ENCODED = Origin.SMOOTHED_POSITIONS | Origin.SMOOTHED_POSITIONS_AND_RATES
"""Rates that encoders tell, whose errors last from sample to sample."""

SMOOTHED = ENCODED | Origin.SMOOTHED_ATTITUDE
"""What a smoothing spline tells."""

BIASED = Origin.INTEGRATED_ACCELEROMETER | Origin.SUMMED_INCREMENTS
"""Velocities in which the bias of an accelerometer shows."""

RUNNING = BIASED | Origin.INTEGRATED_GYRO | Origin.FUSED_ATTITUDE
"""What depends on all samples before it, or on all that there are."""

WORDS = {
    Origin.MEASURED: "measured",
    Origin.SMOOTHED_POSITIONS: "derived: smoothed positions",
    Origin.SMOOTHED_POSITIONS_AND_RATES: "derived: smoothed positions and rates",
    Origin.SMOOTHED_RATES: "derived: smoothed rates",
    Origin.SMOOTHED_ATTITUDE: "derived: smoothed attitude",
    Origin.INTEGRATED_GYRO: "derived: integrated gyro",
    Origin.FUSED_ATTITUDE: "derived: gyro and attitude fused",
    Origin.INTEGRATED_ACCELEROMETER: (
        "derived: integrated accelerometer, its bias estimated"
    ),
    Origin.SUMMED_INCREMENTS: (
        "derived: summed velocity increments, their bias estimated"
    ),
    Origin.MISSING: "missing",
}
"""What results and reports say."""


def origin_in_words(origin: Origin) -> str:
    """Such as `derived: smoothed positions; measured`."""
    return "; ".join(sorted(WORDS[each] for each in origin)) or "none"
