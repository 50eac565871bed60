"""How often chance alone may look like something: the levels of all tests.

A test compares a fall in chi-square, or a square that is chi-square without an effect,
with what chance exceeds with the probability of its level. What follows from exceeding
it, and what part of good recordings that concerns, is in decision 0028.
"""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import chdtrc, chdtri

Rule = Literal[
    "same robot",
    "white residuals",
    "instrument",
    "disturbance",
    "change",
    "other parameters",
    "validation",
    "comparison",
    "ring",
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
    # A recording, or so many samples of a stream, seems to change.
    "change": 1e-4,
    # The parts of a recording have different parameters, as by five deviations.
    "other parameters": 5.7e-7,
    # A result seems not to be that of another recording.
    "validation": 5e-3,
    # A robot seems to differ between two recordings, or by more than one body.
    "comparison": 1e-3,
    # A line in a smooth spectrum seems to ring.
    "ring": 1e-6,
}
"""The probability of a false alarm, in one recording if not said otherwise."""

TIMES_CAD = 3.0
"""So many times the nominal mass is no error of a CAD model."""


def limit(rule: Rule, numbers: int, among: int = 1) -> float:
    """What chance exceeds with the probability of a rule.

    Args:
        rule: of which test.
        numbers: degrees of freedom of the chi-square.
        among: tests that share the probability (Bonferroni).
    """
    return float(chdtri(numbers, LEVELS[rule] / among))


def outstanding(axes: int, frequencies: int) -> float:
    """Times their median by which chance makes the power of no frequency larger.

    The power of noise is chi-square, and its median is known.

    Args:
        axes: whose powers are added up.
        frequencies: of the spectrum.
    """
    return limit("ring", 2 * axes, frequencies) / float(chdtri(2 * axes, 0.5))


def integrated_out(before: float, after: float, numbers: int) -> float:
    """Chi-square with numbers of unknown size integrated out, to compare explanations.

    The least chi-square `after` is at `x` with the covariance `C`. With the covariance
    `P` beforehand, minus twice the logarithm of the evidence is, up to constants,
    `after + x' (P + C)^-1 x + log(det(P + C) / det(C))`. Where samples show `n` numbers
    alike, the most likely `P + C` is `C` times the fall over `n` (MacKay 1992).

    Args:
        before: least chi-square with all of the numbers zero.
        after: the least with them.
        numbers: how many they are.
    """
    each = max((before - after) / numbers, 1.0)
    return after + numbers * (1 + float(np.log(each)))


class ChiSquare(NamedTuple):
    """A sum of squares of white noise, if nothing else is in it."""

    value: float
    dof: int

    @property
    def p(self) -> float:
        """The probability that chance alone gives as much."""
        return float(chdtrc(self.dof, self.value)) if self.dof else 1.0

    def is_no_chance(self, rule: Rule) -> bool:
        """Whether it is beyond the limit of a rule."""
        return self.p < LEVELS[rule]

    def to_json(self) -> dict[str, float]:
        """As in the JSON of `compare`."""
        return {"chi2": self.value, "dof": self.dof, "p": self.p}


ROUNDING = 1e-12
"""Directions of a covariance with less of its largest are rounding and do not count."""


def chi_square(d: Float[np.ndarray, " n"], C: Float[np.ndarray, "n n"]) -> ChiSquare:
    """How far two estimates of the same are apart: `d^T C^-1 d`.

    Args:
        d: the difference.
        C: its covariance; of independent estimates, the sum of theirs.
    """
    # Parameters have units: unit variances while decomposing.
    std = np.sqrt(np.diag(C))
    values, vectors = np.linalg.eigh(C / np.outer(std, std))
    known = values > ROUNDING * values.max(initial=0.0)
    z = vectors.T[known] @ (d / std) / np.sqrt(values[known])
    return ChiSquare(float(z @ z), int(known.sum()))


LOW = 0.05
"""Part of all frequencies that counts as low: below 0.25 to 2.5 Hz at 10 to 100 Hz."""

FEWEST = 8
"""A test of whiteness needs so many low frequencies, at least."""

OUTLYING = 4.0
"""Deviations at which residuals are cut off, as maximum likelihood weighs them."""


class LowFrequencies(NamedTuple):
    """The power of residuals at low frequencies, over that of white noise."""

    ratio: float
    """The power of the axis on which it is largest."""
    limit: float


def low_frequencies(
    residuals: Float[np.ndarray, "n axes"], std: float
) -> LowFrequencies | None:
    """Test whether residuals are white noise at low frequencies.

    Of white noise the periodogram at `m` frequencies is independent from one to the
    next, and twice its sum over the noise's level is chi-square with `2 m` degrees of
    freedom (Priestley 1981, section 6.1). What a sensor's own unknowns take up makes
    it smaller.

    Args:
        residuals: of one sensor, evenly sampled but for gaps.
        std: of its noise, in the same unit.

    Returns:
        The ratio and its limit; None where there are too few samples.
    """
    n, axes = residuals.shape
    count = int(LOW * (n // 2))
    if count < FEWEST or not std > 0:
        return None
    cut = np.clip(residuals, -OUTLYING * std, OUTLYING * std)
    power = np.abs(np.fft.rfft(cut, axis=0)[1:]) ** 2
    level = np.mean(power, axis=0)
    ratio = np.max(np.mean(power[:count], axis=0) / np.where(level > 0, level, 1.0))
    most = limit("white residuals", 2 * count, axes) / (2 * count)
    return LowFrequencies(float(ratio), most)
