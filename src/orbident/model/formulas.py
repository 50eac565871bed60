"""The minimal sets in readable form: combinations of standard parameters."""

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array

from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import SYMBOLS

# A coefficient this small beside the largest of its formula is rounding.
NEGLIGIBLE = 1e-9


class Formulas(NamedTuple):
    """A minimal set's parameters in words."""

    names: tuple[str, ...]
    formulas: tuple[str, ...]


class SetFormulas(NamedTuple):
    """Names and formulas of all three descriptions."""

    base: Formulas
    phi: Formulas
    pi: Formulas


def formulas_of(robot: Robot, sets: MinimalSets) -> SetFormulas:
    """Formulas over `m(body)`, `mx(body)` ... `Izz(body)`, largest coefficient first.

    First moments are `mx = m cx`; inertias are about the body-frame origin. The
    products in `pi` are over `sigma_1 ..` of the base parameters and `M`.
    """
    standard = [f"{symbol}({body})" for body in robot.bodies for symbol in SYMBOLS]
    sigmas, iotas = sets.base.sigmas, sets.iotas
    names = ["M", *_numbered("sigma", sigmas), *_numbered("iota", iotas)]
    base = tuple(combination(row, standard) for row in sets.base.T)
    phi = tuple(_quotient(formula) for formula in base[1 : 1 + sigmas])
    products = [_product(names[1 + a], names[1 + b]) for a, b in sets.pairs]
    linear = sets.pi_of_beta @ sets.base.T
    pi = tuple(
        combination(
            np.concatenate([row, data]),
            [*standard, *(products[k] for k in indices)],
        )
        for row, (indices, data) in zip(
            linear, _entries(sets.pi_of_products), strict=True
        )
    )
    return SetFormulas(
        base=Formulas(tuple(names), base),
        phi=Formulas(_numbered("phi", sigmas), phi),
        pi=Formulas(_numbered("pi", len(pi)), pi),
    )


def combination(coefficients: Float[np.ndarray, " n"], names: Sequence[str]) -> str:
    """`2 a + b - 0.5 c`: rounded, the largest first, without what is negligible."""
    sizes = np.abs(coefficients)
    largest = sizes.max(initial=0.0)
    shown = np.flatnonzero(sizes > NEGLIGIBLE * largest)
    text = ""
    # Rounded, so that what is equal but for rounding keeps its order.
    order = np.argsort(-(sizes[shown] / (largest or 1.0)).round(9), kind="stable")
    for k in shown[order]:
        c = coefficients[k]
        sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
        factor = f"{abs(c):.4g} ".removeprefix("1 ")
        text += sign + factor + names[int(k)]
    return text or "0"


def mass_forms(
    sets: MinimalSets, forms: Float[np.ndarray, "forms pi"], words: SetFormulas
) -> Formulas:
    """Forms of Eq. 32: `c pi`, and `c pi / (c g(phi))`, for every row `c`."""
    phi = words.phi.names
    pairs = [(phi[a], phi[b]) for a, b in sets.pairs]
    below = ["1", *phi, *(f"{a}^2" if a == b else f"{a} {b}" for a, b in pairs)]
    divisors = np.hstack(
        [forms @ sets.pi_of_beta[:, : 1 + len(phi)], forms @ sets.pi_of_products]
    )
    names, formulas = [], []
    for c, divisor in zip(forms, divisors, strict=True):
        name = combination(c, words.pi.names)
        above = f"({name})" if " " in name else name
        names.append(name)
        formulas.append(f"{above}/({combination(divisor, below)})")
    return Formulas(tuple(names), tuple(formulas))


def _entries(A: csr_array) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Row by row, columns and values of what is not zero."""
    for start, end in itertools.pairwise(A.indptr):
        yield A.indices[start:end], A.data[start:end]


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}_{k}" for k in range(1, count + 1))


def _quotient(formula: str) -> str:
    return f"({formula})/M" if " " in formula else f"{formula}/M"


def _product(a: str, b: str) -> str:
    return f"{a}^2/M" if a == b else f"{a} {b}/M"
