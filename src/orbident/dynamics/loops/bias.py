"""`c+` of Eqs. 9-13 by Newton and Euler.

A rigid motion is the pair (w, u) of its rate and its velocity at S, now; forces and
momenta are taken about that point. The system CM is at rest: its own motion adds to
nothing but the force, `M w x v_cm`.
"""

from orbident.dynamics.loops.bodies import move
from orbident.dynamics.loops.vectors import (
    add,
    cross,
    dot,
    load,
    plus,
    put,
    six,
    symmetric,
    times,
)
from orbident.loops import looped

ZERO = (0.0, 0.0, 0.0)


@looped
def bias(joints, A_rw, bodies, motion, rate, v, c):
    """`c+` at the speeds `v`.

    Args:
        joints: the robot's geometry.
        A_rw: of the wheels; rows `a_i I_rw,i`.
        bodies: placed and weighed.
        motion: room for the bodies' motions.
        rate: room for what changes them.
        v: generalised speeds.
        c: filled, but for the wheels.
    """
    move(joints, bodies, motion, v[3:])
    _relative_to_cm(bodies, motion)
    _accelerate(joints, bodies, motion, rate, v)
    _push(joints, A_rw, bodies, motion, rate, v)
    _sum_up(joints, bodies, rate, v, c)


@looped
def _relative_to_cm(bodies, motion):
    """As they are with the system CM at rest, instead of S."""
    w, u = motion
    M, P = 0.0, ZERO
    for i in range(len(bodies.m)):
        M += bodies.m[i]
        P = plus(P, times(bodies.m[i], load(u, i)))
        P = plus(P, cross(load(w, i), load(bodies.s, i)))
    for i in range(len(bodies.m)):
        add(u, i, times(-1.0 / M, P))


@looped
def _accelerate(joints, bodies, motion, rate, v):
    """Every body's acceleration where `v' = 0`, but for that of S."""
    w, u = motion
    a_w, a_u = rate
    put(a_w, 0, ZERO)
    put(a_u, 0, ZERO)
    for k in range(len(joints.parent)):
        p, qd = joints.parent[k], v[6 + k]
        w_k, u_k = load(w, k + 1), load(u, k + 1)
        S_w, S_u = load(bodies.a_w, k), load(bodies.a_u, k)
        # S_k is fixed in the body that the joint moves: S_k' = V_k x S_k.
        put(a_w, k + 1, plus(load(a_w, p), times(qd, cross(w_k, S_w))))
        turned = plus(cross(w_k, S_u), cross(u_k, S_w))
        put(a_u, k + 1, plus(load(a_u, p), times(qd, turned)))


@looped
def _push(joints, A_rw, bodies, motion, rate, v):
    """Every body's force and moment, in place of its acceleration."""
    w, u = motion
    first = 6 + len(joints.parent)
    spin = ZERO
    for k in range(len(A_rw)):
        spin = plus(spin, times(v[first + k], load(A_rw, k)))
    M, F = 0.0, ZERO
    for i in range(len(bodies.m)):
        m, s, J = bodies.m[i], load(bodies.s, i), six(bodies.J, i, 0)
        w_i, u_i = load(w, i), load(u, i)
        a_w, a_u = load(rate[0], i), load(rate[1], i)
        p = plus(times(m, u_i), cross(w_i, s))
        l = plus(cross(s, u_i), symmetric(J, w_i))
        if i == 0:
            l = plus(l, spin)
        # The rate of its momentum.
        f = plus(plus(times(m, a_u), cross(a_w, s)), cross(w_i, p))
        n = plus(cross(s, a_u), symmetric(J, a_w))
        put(rate[0], i, plus(n, plus(cross(w_i, l), cross(u_i, p))))
        put(rate[1], i, f)
        M += m
        F = plus(F, f)
    # S accelerates so that in all there is no force.
    a_0 = times(-1.0 / M, F)
    for i in range(len(bodies.m)):
        add(rate[0], i, cross(load(bodies.s, i), a_0))
        add(rate[1], i, times(bodies.m[i], a_0))


@looped
def _sum_up(joints, bodies, rate, v, c):
    """A joint's torque is the power of what it carries, at unit rate."""
    n, f = rate
    M = 0.0
    for i in range(len(bodies.m)):
        M += bodies.m[i]
    for k in range(len(joints.parent) - 1, -1, -1):
        n_k, f_k = load(n, k + 1), load(f, k + 1)
        c[6 + k] = dot(load(bodies.a_w, k), n_k) + dot(load(bodies.a_u, k), f_k)
        add(n, joints.parent[k], n_k)
        add(f, joints.parent[k], f_k)
    force = times(M, cross((v[3], v[4], v[5]), (v[0], v[1], v[2])))
    for i in range(3):
        c[i], c[3 + i] = force[i], n[0, i]
