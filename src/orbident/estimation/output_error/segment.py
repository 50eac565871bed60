"""One segment of a recording: its equations, linear in changes of the unknowns."""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.estimation.output_error.path import changes_of, path_of
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
    beta: Float[AnyArray, " beta"],
    at: Point,
    course: Course,
    shown: Shown,
) -> Rows:
    """The equations of one segment at a point."""
    at_all = _motion(body, planar, beta, at, course)
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
    path = path_of(planar, terms, course.h_rw, course.dt, at.x_WB, h_cm)
    return Motion(
        terms=terms,
        path=path,
        own=at.own,
        q=joints.q,
        t=course.t,
        dt=course.dt,
        rates=rates,
        h_rw_rate=course.h_rw_rate,
        by_terms=by_terms,
        by_path=changes_of(path, course.dt, by_own.turn, by_h_cm, by_terms),
        by_own=by_own,
        by_q=jnp.einsum("nf,fkc->nkc", course.basis[:, 0], by_corrections),
    )


def _after_own(x: Float[AnyArray, "*n columns"]) -> Float[AnyArray, "*n unknowns"]:
    """The inertia's terms do not depend on the unknowns that come first."""
    return jnp.concatenate([jnp.zeros((*x.shape[:-1], OWN)), x], axis=-1)
