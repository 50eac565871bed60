"""What an estimate may contain beside the parameters, as it was estimated, as data.

Errors of instruments, what acts from outside, and what either would do if it were among
the unknowns.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.files.json_parts import FiniteNumber

UNSEEN = "unseen"
"""In place of a unit: as large as may act from outside and not be seen."""


class CalibrationFit(NamedTuple):
    """A calibration error; SI or relative."""

    value: FiniteNumber
    std: FiniteNumber
    tolerance: FiniteNumber
    """The standard deviation beforehand, as the robot file declares it."""


class Freed(NamedTuple):
    """A calibration error as it would be if it alone were an unknown."""

    name: str
    value: float
    """SI or relative."""
    std: float
    chi2_drop: float
    """How much chi-square would fall; chi-square of one degree without an error."""


class Sensitivity(NamedTuple):
    """What undeclared calibration errors would do to the base parameters."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    """Units of the errors: mrad, mm, % or ms; or `UNSEEN`."""
    shift: Float[np.ndarray, "beta errors"]
    """Change of the estimated `[M, sigma, iota]` by an error of one unit, SI; the
    largest one, without its sign, by what acts unseen."""
    covariance: Float[np.ndarray, "beta beta"]
    """Covariance of the estimated `[M, sigma, iota]`."""
    freed: tuple[Freed, ...]
    left: Float[np.ndarray, "rows columns"]
    """`[R_c, z]`: the equations of the errors after those of all other unknowns."""

    def falls(self, which: Sequence[int]) -> float:
        """How much chi-square would fall if all of these were unknowns."""
        return explained(self.left[:, list(which)], self.left[:, -1]).fall

    def in_deviations(
        self, derivative: Float[np.ndarray, "parameters beta"]
    ) -> Float[np.ndarray, "parameters errors"]:
        """The shifts of parameters with this derivative, over their own deviations."""
        C = derivative @ self.covariance @ derivative.T
        return derivative @ self.shift / np.sqrt(np.diag(C))[:, None]


class Explained(NamedTuple):
    """What some numbers would be if they were unknowns, to first order."""

    numbers: Float[np.ndarray, " numbers"]
    fall: float
    """How far chi-square would fall."""


def explained(
    R: Float[np.ndarray, "rows numbers"], z: Float[np.ndarray, " rows"]
) -> Explained:
    """The numbers `x` of `R x = z + e` that leave least, `e` white of unit variance.

    This is the one score of whatever may be freed: errors of instruments, what acts
    from outside, and what may be wrong with a recording.
    """
    x = np.linalg.lstsq(R, z)[0]
    after = z - R @ x
    return Explained(x, float(z @ z - after @ after))


class DisturbanceFit(NamedTuple):
    """One number of what acted from outside, identified with the parameters; SI."""

    group: str
    unit: str
    value: FiniteNumber
    std: FiniteNumber
    shift: FiniteNumber
    """How far off the base parameter that it concerns most would be, in its deviations,
    had the group been left out."""


Unit = Literal["rad", "m", "1", "s"]


class Calibration(NamedTuple):
    """One calibration error; it is zero where the instrument is perfect."""

    name: str
    """Such as `joint.elbow.zero` or `gyro.scale.x`."""
    unit: Unit
    acts: bool
    """Whether anything that was recorded depends on it."""
    std: float
    """The tolerance that the robot file declares; zero where the error is zero."""
    place: int = 0
    """Place in the order of the core's `calibration.hpp`."""
