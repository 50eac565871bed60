"""What two results of one robot differ by, in parameters that both can be told in.

A result holds `beta = T theta`, of a `theta` that its robot's structure restricts. Let
`T_c` be for the robot of which only that is known which both structures know. Its
momentum is linear in `theta`, with the columns of either robot among its own: what one
result does not see of its `theta`, `T_c` does not see on the same columns. So

    T_c theta = J beta,  J = T_c theta_of

whatever `theta` has this `beta`. A body `theta_t` that joins body `i` adds
`T_c[:, i] theta_t`, and for independent recordings

    d = J_after beta_after - J_before beta_before = T_c[:, i] theta_t + e,
    cov e = J_after C_after J_after^T + J_before C_before J_before^T.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import null_space

from orbident.errors import InputError
from orbident.estimation.base_parameters import Known
from orbident.estimation.levels import ChiSquare
from orbident.estimation.result import Result
from orbident.estimation.several import difference_in_pi
from orbident.files.names import listed
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import Structure

TOLERANCE = 1e-9
"""Relative, and in m: what a change of a file's digits may do."""


def check_same_robot(before: Robot, after: Robot) -> None:
    """Refuse robots that differ in geometry, joints, wheels or feature point.

    Raises:
        InputError: they differ; the first difference is named.
    """
    difference = _of_names(before, after) or _of_numbers(before, after)
    if difference:
        raise InputError(
            f"the robots differ: {difference}; give two results of one robot, which "
            "may differ in inertia and structure alone"
        )


def _of_names(before: Robot, after: Robot) -> str | None:
    for what, a, b in (
        ("body", before.bodies, after.bodies),
        ("joint", before.joint_names, after.joint_names),
        ("wheel", before.wheel_names, after.wheel_names),
    ):
        for when, own, others in (("before", a, b), ("after", b, a)):
            for name in own:
                if name not in others:
                    return f"{what} '{name}' is in the run {when} only"
        if a != b:
            return f"{what} order: {listed(a)} before, {listed(b)} after"
    return None


def _of_numbers(before: Robot, after: Robot) -> str | None:
    a, b = _geometry(before), _geometry(after)
    for what in a:
        if not _equal(a[what], b[what]):
            return f"{what}: {_shown(a[what])} before, {_shown(b[what])} after"
    return None


def _geometry(robot: Robot) -> dict[str, Any]:
    """All that two results have to have in common, beside names."""
    found = {
        "robot: motion": robot.motion,
        "robot: feature point (m)": robot.feature_point,
    }
    for joint in robot.joints:
        who = f"joint '{joint.name}'"
        found |= {
            f"{who}: kind": joint.kind,
            f"{who}: parent": robot.bodies[joint.parent],
            f"{who}: axis": joint.axis,
            f"{who}: position (m)": joint.p_PJ,
            f"{who}: rotation matrix": joint.R_PJ,
        }
    for wheel in robot.wheels:
        who = f"wheel '{wheel.name}'"
        found |= {f"{who}: axis": wheel.axis, f"{who}: inertia (kg m^2)": wheel.inertia}
    return found


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, str):
        return a == b
    # An inertia has no size that would be small for every wheel.
    atol = TOLERANCE if np.ndim(a) else 0.0
    return bool(np.allclose(a, b, rtol=TOLERANCE, atol=atol))


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return value
    if np.ndim(value) == 0:
        return f"{value:.10g}"
    return "[" + ", ".join(f"{x:.10g}" for x in np.ravel(value)) + "]"


FLOOR = 1e-12
"""Eigenvalues of a correlation matrix below this are rounding."""

ZERO = 1e-8
"""Singular values below this are zero: dependent columns of length one have 1e-13."""


class Difference(NamedTuple):
    """`d = T theta_t + e`, `W` whitens `e`: what both results determine, over its std.

    `T` has the columns of all bodies.
    """

    d: Float[np.ndarray, " rows"]
    T: Float[np.ndarray, "rows theta"]
    W: Float[np.ndarray, "rows rows"]
    T_c: Float[np.ndarray, "beta theta"]
    """All of `T_c`, including what one of the results does not determine."""


def difference_of(before: Result, after: Result) -> Difference:
    """Subtract two accepted results of one robot.

    Raises:
        InputError: their structures contradict each other, or a result has not its
            robot's number of base parameters.
    """
    T_c = minimal_sets(_known_of_both(before.robot, after.robot)).base.T
    d, C = np.zeros(len(T_c)), np.zeros((len(T_c), len(T_c)))
    lost = []
    for sign, result in ((-1.0, before), (1.0, after)):
        J = T_c @ _theta_of(result)
        known = np.isfinite(result.base.values + np.diag(result.base_covariance))
        d += sign * J[:, known] @ result.base.values[known]
        C += J[:, known] @ result.base_covariance[known][:, known] @ J[:, known].T
        lost.append(J[:, ~known])
    std = np.sqrt(np.diag(C))
    std[std == 0.0] = 1.0
    # Combinations in which what is undetermined does not occur.
    Q = _free_of(np.hstack(lost) / std[:, None])
    values, vectors = np.linalg.eigh(Q.T @ (C / np.outer(std, std)) @ Q)
    W = (vectors / np.sqrt(np.maximum(values, FLOOR))).T
    return Difference(Q.T @ (d / std), Q.T @ (T_c / std[:, None]), W, T_c)


def change_of_pi(before: Result, after: Result) -> ChiSquare:
    """Chi-square of the difference in `pi`, as far as both determine it.

    Raises:
        InputError: the robots' structures differ, and so do the parameters in `pi`.
    """
    if before.pi.formulas != after.pi.formulas:
        raise InputError(
            "the structures of the robots differ, so that their pi are of other "
            "parameters; identify one of them again with the structure of the other"
        )
    n = after.pi.values.size
    one, other = (
        Known(x.pi.values, x.covariance[:n, :n], np.isfinite(x.pi.values))
        for x in (before, after)
    )
    return difference_in_pi(after.robot, minimal_sets(after.robot), one, other)


def determined_combinations(
    X: Float[np.ndarray, "rows columns"],
) -> tuple[Float[np.ndarray, "columns rank"], Bool[np.ndarray, " columns"]]:
    """What columns tell of their parameters: `V`, where combinations `V z` show.

    Then which parameters show alone, not only in combinations with others.
    """
    size = np.linalg.norm(X, axis=0)
    size[size == 0.0] = 1.0
    _, s, Vt = np.linalg.svd(X / size)
    rank = int(np.sum(s > ZERO * s.max(initial=0.0)))
    alone = np.linalg.norm(Vt[rank:], axis=0) < np.sqrt(ZERO)
    return Vt[:rank].T / size[:, None], alone


def _theta_of(result: Result) -> Float[np.ndarray, "theta beta"]:
    theta_of = minimal_sets(result.robot).base.theta_of
    size = theta_of.shape[1]
    if result.base.values.size != size:
        raise InputError(
            f"the result has not the {size} base parameters of robot "
            f"'{result.robot.name}'; identify again"
        )
    return theta_of


def _free_of(columns: Float[np.ndarray, "beta lost"]) -> Float[np.ndarray, "beta rows"]:
    size = np.linalg.norm(columns, axis=0)
    if not size.any():
        return np.eye(len(columns))
    return np.asarray(null_space((columns[:, size > 0] / size[size > 0]).T, rcond=ZERO))


def _known_of_both(before: Robot, after: Robot) -> Robot:
    structure = {
        body: _known(body, before.structure, after.structure) for body in after.bodies
    }
    both = replace(after, structure=structure)
    # The minimal sets of the robot itself are found already.
    return after if both.free_parameters == after.free_parameters else both


def _known(
    body: str, before: Mapping[str, Structure], after: Mapping[str, Structure]
) -> Structure:
    a, b = before.get(body, Structure()), after.get(body, Structure())
    axes = {a.com_on_axis, b.com_on_axis}
    if len(axes - {None}) > 1:
        raise InputError(
            f"structure: {body}: com_on_axis is {a.com_on_axis} before and "
            f"{b.com_on_axis} after; identify one of them again without it"
        )
    return Structure(
        com_on_axis=None if None in axes else a.com_on_axis,
        principal_axes=a.principal_axes and b.principal_axes,
        massless=a.massless and b.massless,
        spins_about=a.spins_about if a.spins_about == b.spins_about else None,
    )
