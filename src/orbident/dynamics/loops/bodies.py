"""Where all bodies are, and what they weigh about S: base axes, one configuration.

The formulas are those of `dynamics.tree`, `dynamics.kinematics`, `dynamics.inertia`.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.dynamics.loops.vectors import (
    add,
    cross,
    dot,
    load,
    plus,
    put,
    rotated,
    row,
    six,
    symmetric,
    times,
)
from orbident.dynamics.tree import Tree
from orbident.loops import looped


class Joints(NamedTuple):
    """A robot's geometry; joint `k` moves body `k + 1`."""

    parent: Int[np.ndarray, " joints"]
    revolute: Float[np.ndarray, " joints"]
    axis: Float[np.ndarray, "joints 3"]
    R_PJ: Float[np.ndarray, "joints 3 3"]
    p_PJ: Float[np.ndarray, "joints 3"]


class Bodies(NamedTuple):
    """Room for what is known of the bodies and joints at one configuration."""

    R: Float[np.ndarray, "bodies 3 3"]
    d: Float[np.ndarray, "bodies 3"]
    a_w: Float[np.ndarray, "joints 3"]
    """Angular velocity that a joint's unit rate gives to all that it carries."""
    a_u: Float[np.ndarray, "joints 3"]
    """Velocity of that motion at S."""
    m: Float[np.ndarray, " bodies"]
    s: Float[np.ndarray, "bodies 3"]
    J: Float[np.ndarray, "bodies 6"]
    """About S: `[Jxx, Jxy, Jyy, Jxz, Jyz, Jzz]`."""
    p: Float[np.ndarray, "joints 3"]
    """Linear momentum that a joint's unit rate gives to all that it carries."""


def joints_of(tree: Tree) -> Joints:
    """The geometry that the loops need."""
    parts = tree.parent, tree.revolute, tree.axis, tree.R_PJ, tree.p_PJ
    return Joints(*(np.ascontiguousarray(part) for part in parts))


@looped
def room(bodies):
    """For so many bodies."""
    joints = bodies - 1
    return Bodies(
        np.empty((bodies, 3, 3)),
        np.empty((bodies, 3)),
        np.empty((joints, 3)),
        np.empty((joints, 3)),
        np.empty(bodies),
        np.empty((bodies, 3)),
        np.empty((bodies, 6)),
        np.empty((joints, 3)),
    )


@looped
def place(joints, q, bodies):
    """Poses of the bodies, and the motions that joints give them."""
    R, d = bodies.R, bodies.d
    for i in range(3):
        d[0, i] = 0.0
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(len(joints.parent)):
        p, c = joints.parent[k], k + 1
        x, y, z = axis = load(joints.axis, k)
        turns = joints.revolute[k] == 1.0
        # R_BJ = R_BP R_PJ takes the axis into base axes, and Rodrigues the rest.
        for i in range(3):
            for j in range(3):
                R[c, i, j] = (
                    R[p, i, 0] * joints.R_PJ[k, 0, j]
                    + R[p, i, 1] * joints.R_PJ[k, 1, j]
                    + R[p, i, 2] * joints.R_PJ[k, 2, j]
                )
        a = rotated(R, c, axis)
        origin = plus(load(d, p), rotated(R, p, load(joints.p_PJ, k)))
        if turns:
            co, si = cos(q[k]), sin(q[k])
            n = 1.0 - co
            for i in range(3):
                # Row i of R_BJ times c 1 + s [axis]x + (1 - c) axis axis^T.
                u, v, w = row(R, c, i)
                along = n * a[i]
                R[c, i, 0] = co * u + si * (v * z - w * y) + along * x
                R[c, i, 1] = co * v + si * (w * x - u * z) + along * y
                R[c, i, 2] = co * w + si * (u * y - v * x) + along * z
            put(d, c, origin)
            put(bodies.a_w, k, a)
            put(bodies.a_u, k, cross(origin, a))
        else:
            put(d, c, plus(origin, times(q[k], a)))
            put(bodies.a_w, k, (0.0, 0.0, 0.0))
            put(bodies.a_u, k, a)


@looped
def move(joints, bodies, motion, rates):
    """Angular velocity `w` of every body, and velocity `u` of its motion at S.

    Args:
        joints: the robot's geometry.
        bodies: placed.
        motion: `(w, u)`, filled; S itself is at rest.
        rates: of the base, rad/s, and of the joints.
    """
    w, u = motion
    put(w, 0, (rates[0], rates[1], rates[2]))
    put(u, 0, (0.0, 0.0, 0.0))
    for k in range(len(joints.parent)):
        p, qd = joints.parent[k], rates[3 + k]
        put(w, k + 1, plus(load(w, p), times(qd, load(bodies.a_w, k))))
        put(u, k + 1, plus(load(u, p), times(qd, load(bodies.a_u, k))))


@looped
def weigh(theta, bodies):
    """Mass, first moment and inertia of every body about S."""
    R, J = bodies.R, bodies.J
    for i in range(len(bodies.m)):
        m, d = theta[i, 0], load(bodies.d, i)
        s = rotated(R, i, (theta[i, 1], theta[i, 2], theta[i, 3]))
        I = six(theta, i, 4)
        x, y, z = row(R, i, 0), row(R, i, 1), row(R, i, 2)
        h_x, h_y, h_z = symmetric(I, x), symmetric(I, y), symmetric(I, z)
        # integral of -[d + r]x^2 dm = R I R^T + (d . e) 1 - (d e^T + e d^T) / 2
        e = plus(times(2.0, s), times(m, d))
        de = dot(d, e)
        J[i, 0] = dot(x, h_x) + de - d[0] * e[0]
        J[i, 1] = dot(x, h_y) - 0.5 * (d[0] * e[1] + d[1] * e[0])
        J[i, 2] = dot(y, h_y) + de - d[1] * e[1]
        J[i, 3] = dot(x, h_z) - 0.5 * (d[0] * e[2] + d[2] * e[0])
        J[i, 4] = dot(y, h_z) - 0.5 * (d[1] * e[2] + d[2] * e[1])
        J[i, 5] = dot(z, h_z) + de - d[2] * e[2]
        bodies.m[i] = m
        put(bodies.s, i, plus(s, times(m, d)))


@looped
def carry(joints, bodies):
    """Each body's mass, first moment and inertia become those of all from it on."""
    for k in range(len(joints.parent) - 1, -1, -1):
        p, c = joints.parent[k], k + 1
        bodies.m[p] += bodies.m[c]
        add(bodies.s, p, load(bodies.s, c))
        for i in range(6):
            bodies.J[p, i] += bodies.J[c, i]
