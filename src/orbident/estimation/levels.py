"""How often chance alone may look like something: the levels of all tests.

A test compares a fall in chi-square, or a square that is chi-square without an effect,
with what chance exceeds with the probability of its level. What follows from exceeding
it, and what part of good recordings that concerns, is in decision 0028.
"""

from typing import Literal

from scipy.special import chdtri

Rule = Literal[
    "same robot",
    "white residuals",
    "instrument",
    "disturbance",
    "suspicion",
    "other explanation",
    "change",
    "other parameters",
]

LEVELS: dict[Rule, float] = {
    # Recordings of one robot seem to be of several.
    "same robot": 1e-4,
    # Residuals of a sensor have more power at low frequencies than white noise.
    "white residuals": 1e-6,
    # Any instrument of a recording looks wrong.
    "instrument": 1e-3,
    # Any disturbance is seen in noise alone.
    "disturbance": 1e-4,
    # Noise looks as much like any disturbance as what is too faint to be identified.
    "suspicion": 1e-2,
    # The wrong one of two explanations is so much the likelier.
    "other explanation": 1e-4,
    # A recording, or so many samples of a stream, seems to change.
    "change": 1e-4,
    # The parts of a recording have different parameters, as by five deviations.
    "other parameters": 5.7e-7,
}
"""The probability of a false alarm, in one recording if not said otherwise."""


def limit(rule: Rule, numbers: int, among: int = 1) -> float:
    """What chance exceeds with the probability of a rule.

    Args:
        rule: of which test.
        numbers: degrees of freedom of the chi-square.
        among: tests that share the probability (Bonferroni).
    """
    return float(chdtri(numbers, LEVELS[rule] / among))
