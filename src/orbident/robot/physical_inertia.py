"""Whether an inertia can belong to a body: what is wrong with it, in words.

Where the nominal inertia contradicts what is declared to be known of a body.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Structure
from orbident.robot.parameters import FIRST_MOMENT, MASS, SYMBOLS, inertia_matrix

ROUNDING = 1e-9
"""Relative to the largest principal moment: point masses and rods lie exactly on
the border, and files print few digits."""

SLIPS = [10.0 ** (sign * n) for n in range(1, 7) for sign in (-1, 1)]
"""What a decimal point that slipped, or a forgotten exponent, makes of a number."""

MOST_SLIPS = 3
"""Where more are possible, none is likely."""


def nonphysical(
    link: str, mass: float, I_com: Float[np.ndarray, "3 3"]
) -> tuple[str, ...]:
    """What no body can have: one sentence a fault, none for a physical body.

    Args:
        link: the name to use in the sentences.
        mass: kg.
        I_com: inertia about the CM, any axes, kg m^2; those of the file, where a
            decimal point may have slipped in one of its numbers.
    """
    a, b, c = np.linalg.eigvalsh(I_com)
    largest = max(abs(a), abs(c))
    faults = []
    if mass < 0:
        faults.append(f"link '{link}': the mass {mass:.6g} kg is negative")
    if mass == 0 and largest > 0:
        faults.append(
            f"link '{link}': it has no mass but principal moments "
            f"{_numbers(a, b, c)} kg m^2"
        )
    if a < -ROUNDING * largest:
        faults.append(
            f"link '{link}': principal moments {_numbers(a, b, c)} kg m^2, "
            f"the smallest is negative{_slipped(I_com)}"
        )
    elif a + b < c - ROUNDING * largest:
        faults.append(_broken_triangle(link, a, b, c) + _slipped(I_com))
    return tuple(faults)


def _slipped(I_com: Float[np.ndarray, "3 3"]) -> str:
    """Which number would make the inertia possible if its decimal point slipped."""
    found = list(_slips(I_com))
    if not 0 < len(found) <= MOST_SLIPS:
        return ""
    return f"; did a decimal point slip? possible would be {' or '.join(found)}"


def _slips(I_com: Float[np.ndarray, "3 3"]) -> Iterator[str]:
    for i, j in zip(*np.triu_indices(3), strict=True):
        for factor in SLIPS:
            I = I_com.copy()
            I[i, j] = I[j, i] = factor * I_com[i, j]
            a, b, c = np.linalg.eigvalsh(I)
            if a >= 0 and a + b >= c:
                yield f"i{'xyz'[i]}{'xyz'[j]} = {I[i, j]:.6g} (times {factor:g})"
                if i != j:
                    # Any smaller product of inertia is possible too.
                    break


def _broken_triangle(link: str, a: float, b: float, c: float) -> str:
    # Six digits may hide a small violation: "1 + 2 < 3".
    digits = 6 if f"{a + b:.6g}" != f"{c:.6g}" else 12
    x, y, z = (f"{value:.{digits}g}" for value in (a, b, c))
    return (
        f"link '{link}': principal moments {x}, {y}, {z} kg m^2 violate "
        f"the triangle inequality ({x} + {y} < {z})"
    )


def _numbers(*values: float) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


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
