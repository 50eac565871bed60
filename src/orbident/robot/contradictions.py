"""Where the nominal inertia contradicts what is declared to be known of a body."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Structure
from orbident.robot.parameters import FIRST_MOMENT, MASS, SYMBOLS, inertia_matrix

TOLERANCE = 1e-6
"""Relative to the length of the first moment, and to the trace of the inertia."""

_PRODUCTS = ("Ixy", "Ixz", "Iyz")


def contradictions(
    bodies: tuple[str, ...],
    theta: Float[np.ndarray, "bodies 10"],
    structure: Mapping[str, Structure],
) -> tuple[str, ...]:
    """One sentence for each body and kind of knowledge that theta contradicts."""
    warnings = []
    for body, theta_i in zip(bodies, theta, strict=True):
        known = structure.get(body, Structure())
        if known.com_on_axis is not None and _com_off_axis(theta_i, known):
            com = theta_i[FIRST_MOMENT] / (theta_i[MASS] or 1.0)
            warnings.append(
                f"structure: {body}: com_on_axis: {known.com_on_axis}, but the nominal "
                f"CM is at {_vector(com)} m"
            )
        if known.principal_axes and _has_products(theta_i):
            products = np.array([theta_i[SYMBOLS.index(name)] for name in _PRODUCTS])
            warnings.append(
                f"structure: {body}: principal_axes, but the nominal products of "
                f"inertia are {_vector(products)} kg m^2 (xy, xz, yz)"
            )
    return tuple(warnings)


def _com_off_axis(theta_i: Float[np.ndarray, "10"], known: Structure) -> bool:
    s = theta_i[FIRST_MOMENT]
    off_axis = [axis != known.com_on_axis for axis in "xyz"]
    return bool(np.linalg.norm(s[off_axis]) > TOLERANCE * np.linalg.norm(s))


def _has_products(theta_i: Float[np.ndarray, "10"]) -> bool:
    I = inertia_matrix(theta_i)
    largest = np.abs(I - np.diag(np.diag(I))).max()
    return bool(largest > TOLERANCE * abs(np.trace(I)))


def _vector(values: Float[np.ndarray, "3"]) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"
