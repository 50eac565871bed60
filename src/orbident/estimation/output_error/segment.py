"""One segment of a recording: its equations, linear in changes of the unknowns."""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.free_floating import Terms
from orbident.estimation.output_error.path import (
    Changes,
    Path,
    changes_of,
    path_of,
    refined,
)
from orbident.estimation.output_error.predictions import PREDICTIONS, Motion
from orbident.estimation.output_error.terms import (
    Body,
    JointState,
    expanded,
)
from orbident.estimation.output_error.unknowns import OWN, Own
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import small_rotation


class Course(NamedTuple):
    """The joints and wheels of a segment, at its rows and half-way between them."""

    joints: JointState
    """At `2 rows + 1` nodes."""
    h_rw: Float[AnyArray, "*s nodes 3"]
    """The wheels' momentum, base axes, N m s."""
    h_rw_rate: Float[AnyArray, "*s nodes 3"]
    basis: Float[AnyArray, "*s nodes 3 4"]
    """Of the joints' corrections: value, rate and acceleration of each function."""
    t: Float[AnyArray, "*s nodes"]
    """Since time zero, the recording's first row, s."""
    dt: Float[AnyArray, "*s rows"]
    """To the next row, s; zero where rows only fill up."""


class Shown(NamedTuple):
    """What the sensors showed at the rows."""

    values: Mapping[str, Float[AnyArray, "*s rows axes"]]
    """By sensor; anything finite where there was no sample."""
    weights: Mapping[str, Float[AnyArray, "*s rows weighted"]]
    """1 over the noise's std; zero where there was no sample."""


class Point(NamedTuple):
    """Where a segment's equations are linearised."""

    x_WB: Float[AnyArray, "*s 4"]
    """The attitude at its start."""
    own: Own
    corrections: Float[AnyArray, "*s 4 joints"]
    """Of the joints: error and error of the rate at the start, and at the end."""


class Rows(NamedTuple):
    """A segment's equations, linear in changes of `[own, corrections, beta]`."""

    residual: Float[AnyArray, "*s rows outputs"]
    """Shown less predicted, over the noise."""
    slopes: Float[AnyArray, "*s rows outputs unknowns"]
    """Of what is predicted, over the noise."""
    end: Float[AnyArray, "*s 4"]
    """The attitude at the end."""
    end_slopes: Float[AnyArray, "*s 3 unknowns"]
    """Of its small rotation, base axes, rad."""


def linearised(
    body: Body,
    planar: bool,
    substeps: int,
    beta: Float[AnyArray, " beta"],
    at: Point,
    course: Course,
    shown: Shown,
) -> Rows:
    """The equations of one segment at a point."""
    at_all = _motion(body, planar, substeps, beta, at, course)
    residual, slopes = [], []
    for sensor, weight in sorted(shown.weights.items()):
        predicted = PREDICTIONS[sensor](at_all)
        seen = shown.values[sensor]
        if sensor == "attitude":
            error = small_rotation(predicted.value, seen)
        else:
            error = seen - predicted.value
        residual.append(weight * error)
        slopes.append(weight[:, :, None] * predicted.slopes)
    return Rows(
        residual=jnp.concatenate(residual, axis=1),
        slopes=jnp.concatenate(slopes, axis=1),
        end=at_all.path.x_WB[-1],
        end_slopes=at_all.by_path.phi[-1],
    )


def _motion(
    body: Body,
    planar: bool,
    substeps: int,
    beta: Float[AnyArray, " beta"],
    at: Point,
    course: Course,
) -> Motion:
    joints = JointState(
        *(x + course.basis[:, k] @ at.corrections for k, x in enumerate(course.joints))
    )
    each = jax.vmap(lambda state, basis: expanded(body, beta, state, basis))
    terms, rates, by_inertia = each(joints, course.basis)
    by_terms = jax.tree.map(_after_own, by_inertia)
    unknowns = jnp.eye(by_terms.h_q.shape[-1])
    by_own = Own(*unknowns[:OWN].reshape(-1, 3, unknowns.shape[1]))
    K = joints.q.shape[1]
    by_corrections = unknowns[OWN : OWN + 4 * K].reshape(4, K, unknowns.shape[1])
    t = course.t[:, None]
    h_cm = at.own.h_cm + t * at.own.torque
    by_h_cm = by_own.h_cm + t[..., None] * by_own.torque
    slow = _Slow(terms, by_terms, course.h_rw, h_cm, by_h_cm)
    if substeps > 1:
        slow = jax.tree.map(lambda x: refined(x, substeps), slow)
    path, by_path = _turning(planar, slow, at.x_WB, by_own.turn, course.dt)
    return Motion(
        terms=terms,
        path=jax.tree.map(lambda x: x[::substeps], path),
        own=at.own,
        q=joints.q,
        t=course.t,
        dt=course.dt,
        rates=rates,
        h_rw_rate=course.h_rw_rate,
        by_terms=by_terms,
        by_path=jax.tree.map(lambda x: x[::substeps], by_path),
        by_own=by_own,
        by_q=jnp.einsum("nf,fkc->nkc", course.basis[:, 0], by_corrections),
    )


class _Slow(NamedTuple):
    """What the attitude depends on, at the nodes of its steps."""

    terms: Terms
    by_terms: Terms
    h_rw: Float[AnyArray, "nodes 3"]
    h_cm: Float[AnyArray, "nodes 3"]
    by_h_cm: Float[AnyArray, "nodes 3 unknowns"]


def _turning(
    planar: bool,
    at: _Slow,
    x_WB: Float[AnyArray, "4"],
    by_turn: Float[AnyArray, "3 unknowns"],
    dt: Float[AnyArray, " rows"],
) -> tuple[Path, Changes]:
    """The base, in one step a row or in several."""
    substeps = at.h_rw.shape[0] // (2 * dt.size)
    dt = jnp.repeat(dt / substeps, substeps)
    path = path_of(planar, at.terms, at.h_rw, dt, x_WB, at.h_cm)
    return path, changes_of(path, dt, by_turn, at.by_h_cm, at.by_terms)


def _after_own(x: Float[AnyArray, "*n columns"]) -> Float[AnyArray, "*n unknowns"]:
    """The inertia's terms do not depend on the unknowns that come first."""
    return jnp.concatenate([jnp.zeros((*x.shape[:-1], OWN)), x], axis=-1)
