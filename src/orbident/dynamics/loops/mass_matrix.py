"""`M`, `D`, `D_q` and `D_qq` of Eqs. 3, 5 and 6 by composite bodies."""

from orbident.dynamics.loops.bodies import carry
from orbident.dynamics.loops.vectors import (
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


@looped
def mass_matrix(joints, bodies, H):
    """The lower triangle of `H+` over `[v_cm, w, qd]`.

    What `bodies` holds becomes that of all from each body on, and `bodies.p` the
    momentum of what each joint carries.
    """
    carry(joints, bodies)
    _of_base(bodies, H)
    _of_joints(joints, bodies, H)


@looped
def _of_base(bodies, H):
    """`M` and `D`. Koenig: less what the whole mass at the CM would have."""
    M, s, D = bodies.m[0], load(bodies.s, 0), six(bodies.J, 0, 0)
    for i in range(3):
        for j in range(i):
            H[i, j] = 0.0
        H[i, i] = M
        put(H, 3 + i, (0.0, 0.0, 0.0))
        for j in range(i + 1):
            H[3 + i, 3 + j] = D[i * (i + 1) // 2 + j] + s[i] * s[j] / M
        H[3 + i, 3 + i] -= dot(s, s) / M


@looped
def _of_joints(joints, bodies, H):
    """`D_q` and `D_qq`."""
    s, per_M = load(bodies.s, 0), 1.0 / bodies.m[0]
    for k in range(len(joints.parent)):
        w, u, s_k = load(bodies.a_w, k), load(bodies.a_u, k), load(bodies.s, k + 1)
        p_k = plus(times(bodies.m[k + 1], u), cross(w, s_k))
        h_k = plus(cross(s_k, u), symmetric(six(bodies.J, k + 1, 0), w))
        put(bodies.p, k, p_k)
        about_cm = plus(h_k, times(-per_M, cross(s, p_k)))
        for i in range(3):
            H[6 + k, i], H[6 + k, 3 + i] = 0.0, about_cm[i]
        for j in range(k + 1):
            H[6 + k, 6 + j] = -per_M * dot(p_k, load(bodies.p, j))
        # The energy of each motion that carries k, in the momentum that k carries.
        j = k
        while j >= 0:
            work = dot(load(bodies.a_w, j), h_k) + dot(load(bodies.a_u, j), p_k)
            H[6 + k, 6 + j] += work
            j = joints.parent[j] - 1
