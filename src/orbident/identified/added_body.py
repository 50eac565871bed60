"""What joined a body of the robot: mass, CM and inertia from ten parameters."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Inexact

from orbident.estimation.criteria import VAGUE
from orbident.estimation.quantities import Parameters, Quantity, nulled
from orbident.identified.possible import impossible
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    SYMBOLS,
)

NORMAL_95 = 1.96
"""So many standard deviations to either side hold 95 % of a normal distribution."""
STEP = 1e-30
"""Imaginary: so small that the derivative of a rational function is exact."""
I_COM = (
    "Ixx - (my^2 + mz^2)/m",
    "Ixy + mx my/m",
    "Iyy - (mx^2 + mz^2)/m",
    "Ixz + mx mz/m",
    "Iyz + my mz/m",
    "Izz - (mx^2 + my^2)/m",
)


class AddedBody(NamedTuple):
    """What joined a body of the robot, in that body's frame; NaN: not determined.

    Of what left, mass and inertia are negative.
    """

    theta: Float[np.ndarray, "10"]
    """The ten parameters, in the order of `robot.parameters`."""
    covariance: Float[np.ndarray, "10 10"]
    mass: Quantity
    """kg."""
    com: Parameters
    """Position of its CM from the origin of the body's frame, m."""
    I_com: Parameters
    """About its own CM, kg m^2."""
    I_origin: Parameters
    """About the origin of the body's frame, kg m^2."""
    impossible: str | None
    """Why no body can be like this, its covariance considered; None where one can."""

    def to_json(self) -> dict[str, Any]:
        """The body with 95 % intervals and the covariance of its ten parameters."""
        sets = {
            "com": self.com,
            "inertia_about_com": self.I_com,
            "inertia_about_origin": self.I_origin,
        }
        return {
            "mass": {
                "value": nulled(self.mass.value),
                "std": nulled(self.mass.std),
                "interval": nulled(interval_95(self.mass.value, self.mass.std)),
            },
            **{
                name: {
                    **found.to_json(),
                    "intervals": [
                        nulled(interval_95(value, std)) for _, _, value, std in found
                    ],
                }
                for name, found in sets.items()
            },
            "theta": {
                "names": list(SYMBOLS),
                "values": nulled(self.theta),
                "covariance": [nulled(row) for row in self.covariance],
            },
        }


def interval_95(value: float, std: float) -> Float[np.ndarray, "2"]:
    """The 95 % interval."""
    return value + NORMAL_95 * std * np.array([-1.0, 1.0])


def added_body(
    theta: Float[np.ndarray, "10"], covariance: Float[np.ndarray, "10 10"]
) -> AddedBody:
    """The body with these parameters.

    Args:
        theta: about the origin of the body's frame, its axes; NaN where not determined.
        covariance: of `theta`.
    """
    std = np.sqrt(np.diag(covariance))
    values, C = _about_com(theta, covariance)
    stds = np.sqrt(np.diag(C))
    return AddedBody(
        theta=theta,
        covariance=covariance,
        mass=Quantity(float(theta[MASS]), float(std[MASS])),
        com=Parameters(
            names=("cx", "cy", "cz"),
            formulas=("mx/m", "my/m", "mz/m"),
            values=values[:3],
            std=stds[:3],
        ),
        I_com=Parameters(
            names=SYMBOLS[INERTIA],
            formulas=I_COM,
            values=values[3:],
            std=stds[3:],
        ),
        I_origin=Parameters(
            names=SYMBOLS[INERTIA],
            formulas=SYMBOLS[INERTIA],
            values=theta[INERTIA],
            std=std[INERTIA],
        ),
        impossible=impossible(np.sign(theta[MASS]) * values[3:], C[3:, 3:]),
    )


def _about_com(
    theta: Float[np.ndarray, "10"], covariance: Float[np.ndarray, "10 10"]
) -> tuple[Float[np.ndarray, "9"], Float[np.ndarray, "9 9"]]:
    """`c` and the inertia about it, of first order; NaN where not determined."""
    m, std = theta[MASS], np.sqrt(covariance[MASS, MASS])
    if not std < VAGUE * abs(m):
        return np.full(9, np.nan), np.full((9, 9), np.nan)
    known = np.isfinite(theta)
    at = np.where(known, theta, 0.0)
    J = np.column_stack(
        [np.imag(_com_and_inertia(at + 1j * STEP * e)) / STEP for e in np.eye(PER_BODY)]
    )
    values = _com_and_inertia(theta)
    C = J @ np.where(np.outer(known, known), covariance, 0.0) @ J.T
    told = np.isfinite(values)
    return values, np.where(np.outer(told, told), C, np.nan)


def _com_and_inertia(theta: Inexact[np.ndarray, "10"]) -> Inexact[np.ndarray, "9"]:
    """`c = s / m` and `I + [s]x [c]x`: each entry from those that it needs alone."""
    s = theta[FIRST_MOMENT]
    c = s / theta[MASS]
    I = [
        value + (s[a] * c[b] if a != b else -sum(np.delete(s * c, a)))
        for value, (a, b) in zip(theta[INERTIA], INERTIA_ENTRIES, strict=True)
    ]
    return np.array([*c, *I])
