"""What an estimate may contain beside the parameters, as it was estimated, as data.

Errors of instruments, what acts from outside, and what either would do if it were among
the unknowns.
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.files.json_parts import FiniteNumber, NullableNumber

TOLD = 0.1
"""A recording says how large a number is if it tells this part of the variance that was
known beforehand, at least. Where it tells less, errors of second order decide too."""


class CalibrationFit(NamedTuple):
    """A calibration error; SI or relative."""

    value: FiniteNumber
    std: FiniteNumber
    tolerance: NullableNumber
    """The standard deviation beforehand, as the robot file declares it; NaN of a gain
    that is further off than that, and so was free."""

    @property
    def beyond_tolerance(self) -> float:
        """How much smaller chi-square would be if the error had no tolerance.

        The estimated error is expected to vary by the tolerance, less the part of it
        that the recording leaves unknown.
        """
        told = 1 - (self.std / self.tolerance) ** 2
        return (self.value / self.tolerance) ** 2 / max(told, TOLD)


SPRING = ("frequency", "damping")
"""The last words of errors of a passive joint, `joint.panel.frequency`."""

DRIVE = ("armature", "viscous", "coulomb", "torque_offset")
"""The last words of what a joint's torque drives beside what the joint moves, such as
`joint.elbow.viscous`."""


class SpringFit(NamedTuple):
    """How a passive joint swings where the body that carries it is held."""

    frequency: FiniteNumber
    """Hz."""
    frequency_std: FiniteNumber
    damping: FiniteNumber
    """Over critical damping."""
    damping_std: FiniteNumber


class DriveFit(NamedTuple):
    """What a joint's torque drives beside what the joint moves; SI.

    It is `armature qdd + viscous qd + coulomb sign(qd) + offset`.
    """

    armature: FiniteNumber
    """`N (N - 1) J` of the motor's rotor, kg m^2 or kg."""
    armature_std: FiniteNumber
    viscous: FiniteNumber
    """N m s or N s/m."""
    viscous_std: FiniteNumber
    coulomb: FiniteNumber
    """N m or N."""
    coulomb_std: FiniteNumber
    offset: FiniteNumber
    """N m or N."""
    offset_std: FiniteNumber


class Sensitivity(NamedTuple):
    """What undeclared calibration errors would do to the base parameters."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    """Units of the errors: mrad, mm, % or ms."""
    shift: Float[np.ndarray, "beta errors"]
    """Change of the estimated `[M, sigma, iota]` by an error of one unit, SI."""
    covariance: Float[np.ndarray, "beta beta"]
    """Covariance of the estimated `[M, sigma, iota]`."""
    alone: Mapping[str, "Score"]
    """What each error would be if it alone were an unknown, by its name."""
    left: Float[np.ndarray, "rows columns"]
    """`[R_c, z]`: the equations of the errors after those of all other unknowns."""

    def together(self, names: Collection[str]) -> "Score":
        """What all of these would be if they were unknowns."""
        which = [k for k, name in enumerate(self.names) if name in names]
        return score(self.left[:, which], self.left[:, -1])

    def in_deviations(
        self, derivative: Float[np.ndarray, "parameters beta"]
    ) -> Float[np.ndarray, "parameters errors"]:
        """The shifts of parameters with this derivative, over their own deviations."""
        C = derivative @ self.covariance @ derivative.T
        return derivative @ self.shift / np.sqrt(np.diag(C))[:, None]


class Score(NamedTuple):
    """What some numbers would be if they were unknowns, to first order; SI."""

    values: Float[np.ndarray, " numbers"]
    std: Float[np.ndarray, " numbers"]
    """Infinite where nothing shows a number."""
    fall: float
    """How far chi-square would fall: chi-square itself where all numbers are zero."""


def score(R: Float[np.ndarray, "rows numbers"], z: Float[np.ndarray, " rows"]) -> Score:
    """The numbers `x` of `R x = z + e` that leave least, `e` white of unit variance.

    This is the one score of whatever may be freed: errors of instruments, what acts
    from outside, and what may be wrong with a recording (score test, Rao 1948).
    """
    x = np.linalg.lstsq(R, z)[0]
    after = z - R @ x
    # Where two numbers show alike, each is as sure as their sum is.
    std = np.sqrt(np.maximum(np.diag(np.linalg.pinv(R.T @ R)), 0.0))
    seen = R.any(axis=0)
    return Score(x, np.where(seen, std, np.inf), float(z @ z - after @ after))


class DisturbanceFit(NamedTuple):
    """One number of what acted from outside, identified with the parameters; SI."""

    group: str
    unit: str
    value: FiniteNumber
    std: FiniteNumber
    shift: NullableNumber
    """How far off the base parameter that it concerns most would be, in its deviations,
    had the group been left out; NaN where only another fit could tell."""


class Unknown(NamedTuple):
    """A number beside the parameters: zero where nothing is off and nothing acts."""

    name: str
    """Such as `joint.elbow.zero`, `gyro.scale.x` or `slow_torque.x.3`."""
    family: str
    """What is there or not there together, such as all numbers of a slow torque."""
    unit: str
    """`rad`, `m`, `1` or `s` of an error; N m and others of what acts."""
    std: float
    """The standard deviation beforehand; zero where it is taken for zero until a fit
    frees it."""
    place: float
    """Among the core's calibrations (`calibration.hpp`), or behind them."""
    positive: bool = False
    """Whether less than zero is impossible."""
