"""The minimal sets in readable form: combinations of standard parameters."""

import re
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array, hstack

from orbident.files.names import listed
from orbident.model.core_robot import geared_joints, rotor_directions, undeclared_rotors
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS, PER_BODY, SYMBOLS
from orbident.threads import one_blas_thread

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

    First moments are `mx = m cx`; inertias are about the body-frame origin. Where the
    motor of a joint is geared, or may be, `rotor(joint)` is its gear's ratio times the
    inertia of its rotor. The products in `pi` are over `sigma_1 ..` of the base
    parameters and `M`.
    """
    rotors = geared_joints(robot)
    standard = [f"{symbol}({body})" for body in robot.bodies for symbol in SYMBOLS]
    standard += [f"rotor({name})" for name in rotors]
    at = [robot.joint_names.index(name) for name in rotors]
    of_rotors = sets.base.T @ rotor_directions(robot)[at].T
    T = csr_array(np.hstack([sets.base.T, of_rotors]))
    sigmas, iotas = sets.base.sigmas, sets.iotas
    names = ["M", *_numbered("sigma", sigmas), *_numbered("iota", iotas)]
    base = combinations(T, standard)
    phi = tuple(f"({x})/M" if " " in x else f"{x}/M" for x in base[1 : 1 + sigmas])
    pairs = [(names[1 + a], names[1 + b]) for a, b in sets.pairs]
    products = [f"{a}^2/M" if a == b else f"{a} {b}/M" for a, b in pairs]
    linear = csr_array(sets.pi_of_beta) @ T
    both = csr_array(hstack([linear, sets.pi_of_products]))
    pi = combinations(both, [*standard, *products])
    return SetFormulas(
        base=Formulas(tuple(names), base),
        phi=Formulas(_numbered("phi", sigmas), phi),
        pi=Formulas(_numbered("pi", len(pi)), pi),
    )


def combinations(
    coefficients: Float[np.ndarray, "rows n"] | csr_array, names: Sequence[str]
) -> tuple[str, ...]:
    """`2 a + b - 0.5 c`: rounded, the largest first, without what is negligible."""
    A = csr_array(coefficients)
    rows = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    largest = np.zeros(len(A.indptr) - 1)
    np.maximum.at(largest, rows, np.abs(A.data))
    share = np.abs(A.data) / np.where(largest > 0, largest, 1.0)[rows]
    # Rounded, so that what is equal but for rounding keeps its order.
    order = np.lexsort((A.indices, -share.round(9), rows))
    order = order[share[order] > NEGLIGIBLE]
    texts = [""] * len(largest)
    rows, values, columns = rows[order], A.data[order], A.indices[order]
    for row, c, k in zip(rows.tolist(), values.tolist(), columns.tolist(), strict=True):
        sign = ("-" if c < 0 else "") if not texts[row] else (" - " if c < 0 else " + ")
        factor = f"{abs(c):.4g} ".removeprefix("1 ")
        texts[row] += f"{sign}{factor}{names[k]}"
    return tuple(text or "0" for text in texts)


TERM = re.compile(r"(^-?|[+-] )([-\d.e+]+ )?(\w+)\(([^)]*)\)")
"""A term of a formula: sign, factor, symbol and body."""


def named(name: str, formula: str) -> str:
    """What a base parameter is, and its symbol in brackets."""
    physical = physical_name(name, formula)
    return name if physical == name else f"{physical} ({name})"


def physical_name(name: str, formula: str) -> str:
    """What a base parameter is: moments of one body, and of what moves with it.

    The formula of `M`, `sigma_1` or `iota_1` is in standard parameters.

    Returns:
        `"total mass"`, `"mx of link1"`, `"Ixx - Izz of link1 and beyond"`; the symbol
        where its formula has no such term.
    """
    if name == "M":
        return "total mass"
    terms = [match.groups() for match in TERM.finditer(formula)]
    kind = "m" if name.startswith("sigma") else "I"
    own = [term for term in terms if term[2].startswith(kind) and term[2] != "m"]
    if not own:
        return name
    _, factor, _, body = own[0]
    parts = [f"{sign.strip()} {x}" for sign, f, x, b in own if (f, b) == (factor, body)]
    beyond = " and beyond" if any(term[3] != body for term in terms) else ""
    return f"{' '.join(parts).removeprefix('+').strip()} of {body}{beyond}"


def of_width(texts: Sequence[str], width: int) -> list[str]:
    """Texts whose bodies' names are cut where they are too long, and remain different.

    Such names lose the words that all of them begin or end with, unless only numbers
    are left, and then as many letters of every word as need be.
    """
    texts = [x if len(x) <= width else x.replace(" and beyond", " ...") for x in texts]
    bodies = {_body(text): _body(text) for text in texts if len(text) > width}
    words = [re.split(r"([\W_]+)", body) for body in bodies]
    first, last = _alike(words), _alike([each[::-1] for each in words])
    for body, each in zip(bodies, words, strict=True):
        own = "".join(each[first : len(each) - last])
        bodies[body] = own if re.search(r"[^\W\d_]", own) else body
    return [_cut(text, bodies, width) for text in texts]


def _alike(rows: Sequence[Sequence[str]]) -> int:
    """How many of their first words are the same in all."""
    same = (len({*words}) == 1 for words in zip(*rows, strict=False))
    return sum(takewhile(bool, same))


def _body(text: str) -> str:
    return text.partition(" of ")[2].removesuffix(" ...")


def _cut(text: str, names: Mapping[str, str], width: int) -> str:
    letters, (head, body, beyond) = width, text.rpartition(_body(text) or text)
    while len(text) > width and letters:
        name = re.sub(rf"([^\W\d_]{{{letters}}})[^\W\d_]+", r"\1", names[body])
        text, letters = f"{head}{name}{beyond}", letters - 1
    return text[:width]


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
    names = combinations(forms, words.pi.names)
    formulas = tuple(
        f"{f'({above})' if ' ' in above else above}/({divisor})"
        for above, divisor in zip(names, combinations(divisors, below), strict=True)
    )
    return Formulas(names, formulas)


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}_{k}" for k in range(1, count + 1))


# The projector on what is seen has 1 on the diagonal where a parameter is seen alone.
ALONE = 1e-6
NEVER = 1e-9


@one_blas_thread
def not_identifiable(robot: Robot, sets: MinimalSets) -> list[str]:
    """Plain sentences: no scale, parameters that never show, or only in company."""
    sentences = []
    torques = robot.sensors.torques or robot.torque_constants
    if not (robot.wheels or robot.thrusters or torques):
        sentences.append(
            "the scale of pi, and so the total mass: without a reaction wheel the "
            "momentum equation has no known term; declare the robot's wheels, its "
            "thrusters, its magnetic torquers, or torque sensors at its joints, and "
            "record them"
        )
    names = undeclared_rotors(robot)
    if names:
        more = "; torques show gear * (gear - 1) times inertia too" if torques else ""
        sentences.append(
            f"the rotors of geared motors, if {listed(names)} have any: momentum shows "
            "gear times inertia, rotor(joint), only together with the link that the "
            f"joint moves{more}; say under 'rotors' what they are, or 'none'"
        )
    T = sets.base.T
    seen = np.sum(np.linalg.qr(T.T)[0] ** 2, axis=1)
    never = np.linalg.norm(T, axis=0) <= NEVER
    free = np.zeros(T.shape[1], dtype=bool)
    free[list(robot.free_parameters)] = True
    for i, body in enumerate(robot.bodies):
        own = slice(PER_BODY * i, PER_BODY * (i + 1))
        silent = _listed(free[own] & never[own])
        mixed = _listed(free[own] & ~never[own] & (seen[own] < 1 - ALONE))
        if silent:
            sentences.append(f"{body}: not seen at all: {silent}")
        if mixed:
            sentences.append(f"{body}: seen only in combination with others: {mixed}")
    return sentences


def _listed(which: np.ndarray) -> str:
    return ", ".join(SYMBOLS[k] for k in np.flatnonzero(which))


ROUNDING = 1e-10
"""Over the size of the terms of a sum: a smaller sum is zero. A URDF writes a right
angle as 1.57079632679, which is off by 5e-12."""

MOMENTS = np.array([4, 6, 9])
"""Where `theta_i` holds `Ixx`, `Iyy` and `Izz`."""


class Nominal(NamedTuple):
    """The minimal sets of the nominal inertia; what is rounding of zero is zero."""

    base: Float[np.ndarray, " beta"]
    phi: Float[np.ndarray, " phi"]
    pi: Float[np.ndarray, " pi"]


def nominal_parameters(robot: Robot, sets: MinimalSets) -> Nominal:
    """The minimal sets of a robot's nominal `theta`."""
    theta, size = robot.theta, _size(robot.theta)
    T = np.abs(sets.base.T)
    M, sigma, _ = sets.split(T @ size.ravel())
    a, b = sets.pairs.T
    size_pi = np.abs(sets.pi_of_beta) @ (T @ size.ravel())
    size_pi += abs(sets.pi_of_products) @ (sigma[a] * sigma[b] / M)
    return Nominal(
        base=_rounded(sets.beta(theta), T @ size.ravel()),
        phi=_rounded(sets.phi(theta), sigma / M),
        pi=_rounded(sets.pi(theta), size_pi),
    )


def _size(theta: Float[np.ndarray, "bodies 10"]) -> Float[np.ndarray, "bodies 10"]:
    """How large each of a body's parameters could be: `|m c|^2 <= m tr(I) / 2`."""
    m, trace = theta[:, MASS], np.abs(theta[:, MOMENTS]).sum(axis=1)
    size = np.abs(theta)
    size[:, FIRST_MOMENT] += np.sqrt(np.abs(m) * trace)[:, None]
    size[:, INERTIA] += trace[:, None]
    return size


def _rounded(
    values: Float[np.ndarray, " n"], size: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    return np.where(np.abs(values) > ROUNDING * size, values, 0.0)
