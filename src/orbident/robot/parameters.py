"""The one order of the inertial parameters `theta`.

A body has ten, about the origin of its body frame, in body axes (Pinocchio's
order): `[m, m cx, m cy, m cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz]`. `theta` stacks the
bodies, base first. What is known of a body makes some of them zero.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

PER_BODY = 10
SYMBOLS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
MASS = 0
FIRST_MOMENT = slice(1, 4)
INERTIA = slice(4, 10)
INERTIA_ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))


def cross_matrix(v: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 3 3"]:
    """`[v]x`, so that `[v]x u = v x u`."""
    m = np.zeros((*v.shape, 3))
    m[..., 2, 1], m[..., 0, 2], m[..., 1, 0] = np.moveaxis(v, -1, 0)
    return m - np.swapaxes(m, -1, -2)


def inertia_matrix(theta_i: Float[np.ndarray, "10"]) -> Float[np.ndarray, "3 3"]:
    """The inertia about the body-frame origin, kg m^2."""
    I = np.zeros((3, 3))
    for value, (row, column) in zip(theta_i[INERTIA], INERTIA_ENTRIES, strict=True):
        I[row, column] = I[column, row] = value
    return I


def from_mass_com_inertia(
    mass: float, com: Float[np.ndarray, "3"], I_com: Float[np.ndarray, "3 3"]
) -> Float[np.ndarray, "10"]:
    """The ten parameters of a body from mass, CM and the inertia about its CM.

    All is in body axes: kg; m, from the body-frame origin to the CM; kg m^2.
    """
    # Huygens-Steiner: I = I_com - m [c]x [c]x.
    C = cross_matrix(com)
    I = I_com - mass * C @ C
    return np.array([mass, *(mass * com), *(I[entry] for entry in INERTIA_ENTRIES)])


def inertia_about_com(theta_i: Float[np.ndarray, "10"]) -> Float[np.ndarray, "3 3"]:
    """The inertia about the body's own CM, body axes, kg m^2; `m` must not be zero."""
    C = cross_matrix(theta_i[FIRST_MOMENT])
    return inertia_matrix(theta_i) + C @ C / theta_i[MASS]


def transformed(
    theta_i: Float[np.ndarray, "10"],
    R_AB: Float[np.ndarray, "3 3"],
    p_AB: Float[np.ndarray, "3"],
) -> Float[np.ndarray, "10"]:
    """A body's parameters, given about B's origin in B's axes, for frame A.

    `R_AB` rotates vectors from B's axes into A's; `p_AB` is from A's origin to B's, A's
    axes, m.
    """
    m, s = theta_i[MASS], R_AB @ theta_i[FIRST_MOMENT]
    P, S = cross_matrix(p_AB), cross_matrix(s)
    # integral of -[p + r]x^2 dm, with r from B's origin.
    I = R_AB @ inertia_matrix(theta_i) @ R_AB.T - P @ S - S @ P - m * P @ P
    return np.array([m, *(s + m * p_AB), *(I[entry] for entry in INERTIA_ENTRIES)])


Axis = Literal["x", "y", "z"]


@dataclass(frozen=True)
class Structure:
    """What is known of one body's mass distribution; nothing by default."""

    com_on_axis: Axis | None = None
    """The CM lies on this axis of the body frame."""
    principal_axes: bool = False
    """The inertia has no products in body axes."""
    massless: bool = False
    """It only carries joints."""
    spins_about: Axis | None = None
    """It is the rotor of its joint's motor: it has inertia about this axis alone."""

    @property
    def has_mass(self) -> bool:
        """Whether it is a body, and not a rotor or nothing."""
        return not self.massless and self.spins_about is None

    def zero_parameters(self) -> frozenset[str]:
        """The symbols of `theta_i` that this knowledge makes zero."""
        if self.massless:
            return frozenset(SYMBOLS)
        if self.spins_about is not None:
            return frozenset(SYMBOLS) - {"I" + 2 * self.spins_about}
        zero = set()
        if self.com_on_axis is not None:
            zero |= {"mx", "my", "mz"} - {"m" + self.com_on_axis}
        if self.principal_axes:
            zero |= {"Ixy", "Ixz", "Iyz"}
        return frozenset(zero)
