"""A robot's filter as constant C++ tables: what `filter_in_flight.cpp` includes."""

import numpy as np

from orbident.estimation.recursive.filter import Extended, by_last_row, sparse
from orbident.estimation.recursive.prior import Prior
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot

WINDOW = 20
DOUBLES = 100_000
"""Static memory of the program: state and room of a robot with a few joints."""


def tables(
    robot: Robot, kalman: Extended, prior: Prior, t: np.ndarray, samples: np.ndarray
) -> str:
    """All constants, as hexadecimal floats."""
    sets = kalman.sets
    own, sigmas, pis = sets.regressors, sets.base.sigmas, len(sets.pi_of_beta)
    linear, chosen = columns_of_Y(sets)
    products = sparse(sets.pi_of_products.toarray())
    order = by_last_row(products)
    noise = [_number(std) for std in kalman.noise[:10]]
    noise.append(str(kalman.noise.accelerometer).lower())
    axes = f"{_axes(own.momentum_axes)}, {_axes(own.velocity_axes)}"
    laws = (
        f"{{{{{{JOINT, {len(robot.joints)}}}, nullptr, WHEEL, {len(robot.wheels)}}}, "
        f"{{LINEAR, SIGMA, CHOSEN, {len(chosen)}}}, THETA_OF, {{{axes}}}, "
        f"{{{', '.join(noise)}}}}}"
    )
    beta = f"{{SHOWN, PRODUCTS, PAIR, {pis}, {sigmas}, {sets.iotas}}}"
    return "\n".join(
        [
            f"const Joint JOINT[] = {{{', '.join(map(_joint, robot.joints))}}};",
            f"const Wheel WHEEL[] = {{{', '.join(map(_wheel, robot.wheels))}}};",
            _sparse("THETA_OF", sparse(sets.base.theta_of)),
            _sparse("LINEAR", sets.base.theta_of[:, linear]),
            _sparse("SIGMA", sets.base.theta_of[:, 1 : 1 + sigmas]),
            _sparse("SHOWN", sparse(sets.pi_of_beta)[:, : 1 + sigmas]),
            _sparse("PRODUCTS", products[:, order]),
            _integers("CHOSEN", sets.pairs[chosen]),
            _integers("PAIR", sets.pairs[order]),
            f"const FilterModel MODEL{{{laws}, {beta}}};",
            f"constexpr int BODIES = {len(robot.bodies)}, WINDOW = {WINDOW};",
            f"constexpr int COUNT = {t.size}, MEASURED = {samples.shape[1]};",
            f"constexpr long DOUBLES = {DOUBLES};",
            _doubles("PRIOR_BETA", prior.beta),
            _doubles("PRIOR_ROOT", prior.root),
            _doubles("TIMES", t),
            _doubles("SAMPLES", samples),
        ]
    )


def columns_of_Y(sets: MinimalSets) -> tuple[list[int], list[int]]:
    """The columns of `A` over `beta` and the products that `Y` is made of."""
    linear, chosen = [], []
    for unit in np.eye(len(sets.pi_of_beta)):
        own = np.flatnonzero((unit == sets.pi_of_beta.T).all(axis=1))
        if own.size:
            linear.append(int(own[0]))
        else:
            products = (unit == sets.pi_of_products.toarray().T).all(axis=1)
            chosen.append(int(np.flatnonzero(products)[0]))
    return linear, chosen


def _joint(joint) -> str:
    kind = str(joint.kind == "revolute").lower()
    R = f"(Matrix3<double>() << {_numbers(joint.R_PJ)}).finished()"
    axis, p = (f"Vector3<double>({_numbers(v)})" for v in (joint.axis, joint.p_PJ))
    return f"{{{joint.parent}, {kind}, {axis}, {R}, {p}}}"


def _wheel(wheel) -> str:
    return f"{{Vector3<double>({_numbers(wheel.axis)}), {_number(wheel.inertia)}}}"


def _axes(axes: tuple[int, ...]) -> str:
    return f"{{{', '.join(map(str, axes))}}}, {len(axes)}"


def _sparse(name: str, A: np.ndarray) -> str:
    column, row = np.nonzero(A.T)
    return "\n".join(
        [
            _integers(f"{name}_FIRST", np.searchsorted(column, range(A.shape[1] + 1))),
            _integers(f"{name}_ROW", row),
            _doubles(f"{name}_VALUE", A[row, column]),
            f"constexpr Sparse {name}{{{name}_FIRST, {name}_ROW, {name}_VALUE, "
            f"{A.shape[1]}}};",
        ]
    )


def _integers(name: str, values: np.ndarray) -> str:
    listed = ", ".join(str(int(value)) for value in np.ravel(values))
    return f"constexpr int {name}[] = {{{listed or '0'}}};"


def _doubles(name: str, values: np.ndarray) -> str:
    return f"constexpr double {name}[] = {{{_numbers(values) or '0.0'}}};"


def _numbers(values: np.ndarray) -> str:
    return ", ".join(map(_number, np.ravel(values)))


def _number(value: float) -> str:
    # Hexadecimal floats have no name for what is not a number.
    return float(value).hex() if np.isfinite(value) else "NAN"
