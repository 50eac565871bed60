"""A difference of base parameters, explained by one body that joined another.

Mass, CM and inertia of what joined follow from ten parameters. Not every inertia is
that of a body, within what is known of it.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Inexact, Int

from orbident.estimation.levels import ChiSquare
from orbident.estimation.parameter_checks import VAGUE
from orbident.estimation.quantities import Parameters, Quantity
from orbident.files.json_parts import nulled
from orbident.gaussian import NINETY_FIVE
from orbident.identified.difference import Difference, determined_combinations
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    SYMBOLS,
    Structure,
    inertia_matrix,
)


class Explanation(NamedTuple):
    """The body that joined `body`, by generalised least squares."""

    body: str
    theta: Float[np.ndarray, "10"]
    """About the origin of `body`'s frame, its axes; NaN where not determined."""
    covariance: Float[np.ndarray, "10 10"]
    left: ChiSquare
    """Chi-square of what it leaves unexplained."""
    probability: float
    """That it is this body, if it is one (Akaike's weight)."""


def explanations(difference: Difference, robot: Robot) -> tuple[Explanation, ...]:
    """Every body in turn, the most probable first; of equals the ends of the arms.

    The robot is the one that holds what was captured.
    """
    fits = [_fit(difference, robot, i) for i in range(len(robot.bodies))]
    # -2 log likelihood, and 2 for every parameter (Akaike 1974).
    criteria = np.array([fit.left.value - 2.0 * fit.left.dof for fit in fits])
    weights = np.exp(-(criteria - criteria.min()) / 2)
    weights /= weights.sum()
    parents = {joint.parent for joint in robot.joints}
    order = sorted(range(len(fits)), key=lambda i: (criteria[i].round(6), i in parents))
    return tuple(fits[i]._replace(probability=float(weights[i])) for i in order)


def free_columns(robot: Robot, i: int) -> Int[np.ndarray, " free"]:
    """The columns of `theta` that the structure of body `i` leaves free."""
    zero = robot.structure.get(robot.bodies[i], Structure()).zero_parameters()
    return np.array([k for k in range(PER_BODY) if SYMBOLS[k] not in zero])


def _fit(difference: Difference, robot: Robot, i: int) -> Explanation:
    d, T, W, _ = difference
    free = free_columns(robot, i)
    X = T[:, PER_BODY * i + free]
    V, alone = determined_combinations(X)
    # d = X V z + e, of which W e is white; theta_t = V z.
    WX = W @ X @ V
    inverse = np.linalg.pinv(WX)
    G = V @ inverse
    theta, covariance = np.full(PER_BODY, np.nan), np.full((PER_BODY, PER_BODY), np.nan)
    theta[free] = np.where(alone, G @ W @ d, np.nan)
    covariance[np.ix_(free, free)] = np.where(np.outer(alone, alone), G @ G.T, np.nan)
    residual = W @ d - WX @ (inverse @ W @ d)
    return Explanation(
        body=robot.bodies[i],
        theta=theta,
        covariance=covariance,
        left=ChiSquare(float(residual @ residual), d.size - V.shape[1]),
        probability=0.0,
    )


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
                "covariance": nulled(self.covariance),
            },
        }


def interval_95(value: float, std: float) -> Float[np.ndarray, "2"]:
    """The 95 % interval."""
    return value + NINETY_FIVE * std * np.array([-1.0, 1.0])


def added_body(
    theta: Float[np.ndarray, "10"], covariance: Float[np.ndarray, "10 10"]
) -> AddedBody:
    """The body with these parameters.

    They are about the origin of the body's frame, its axes; NaN where not determined.
    """
    std = np.sqrt(np.diag(covariance))
    values, C = _about_com(theta, covariance)
    stds, names = np.sqrt(np.diag(C)), SYMBOLS[INERTIA]
    return AddedBody(
        theta=theta,
        covariance=covariance,
        mass=Quantity(float(theta[MASS]), float(std[MASS])),
        com=Parameters(
            ("cx", "cy", "cz"), ("mx/m", "my/m", "mz/m"), values[:3], stds[:3]
        ),
        I_com=Parameters(names, I_COM, values[3:], stds[3:]),
        I_origin=Parameters(names, names, theta[INERTIA], std[INERTIA]),
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


CERTAIN = 3.0
"""Standard deviations below zero that are no chance."""


def impossible(
    I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]
) -> str | None:
    """Why no body can have this inertia about its CM; None where one can.

    Second moments are not negative in any direction `v`: `tr I / 2 - v^T I v >= 0`,
    which is least along the axis of the largest moment. Where not all of `I` is
    determined, what is determined of its diagonal must not be negative. The inertia is
    in kg m^2, NaN where not determined, and `C` is its covariance.
    """
    if np.isfinite(I_com).all():
        return _flat(I_com, C)
    for k, (a, b) in enumerate(INERTIA_ENTRIES):
        if a == b and I_com[k] < -CERTAIN * np.sqrt(C[k, k]):
            symbol = SYMBOLS[INERTIA][k]
            return f"{symbol} about its CM, {I_com[k]:.4g} kg m^2, is negative"
    return None


def _flat(I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]) -> str | None:
    moments, axes = np.linalg.eigh(inertia_matrix(np.append(np.zeros(4), I_com)))
    v = axes[:, -1]
    g = np.array(
        [0.5 - v[a] ** 2 if a == b else -2 * v[a] * v[b] for a, b in INERTIA_ENTRIES]
    )
    if g @ I_com >= -CERTAIN * np.sqrt(g @ C @ g):
        return None
    x, y, z = (f"{moment:.4g}" for moment in moments)
    return (
        f"its principal moments {x}, {y}, {z} kg m^2 violate the triangle inequality "
        "by more than chance"
    )
