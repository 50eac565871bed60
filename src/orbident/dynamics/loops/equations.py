"""`H+` and `c+` of Eqs. 8-14, state by state.

The formulas are those of `dynamics.inertia` and `dynamics.equations_of_motion`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.dynamics.equations_of_motion import Model
from orbident.dynamics.loops.bias import bias
from orbident.dynamics.loops.bodies import Joints, joints_of, place, room, weigh
from orbident.dynamics.loops.mass_matrix import mass_matrix
from orbident.loops import looped


class Machine(NamedTuple):
    """What the equations of motion need of a robot."""

    joints: Joints
    theta: Float[np.ndarray, "bodies 10"]
    A_rw: Float[np.ndarray, "wheels 3"]
    """Rows `a_i I_rw,i`."""
    I_rw: Float[np.ndarray, " wheels"]


def machine_of(model: Model) -> Machine:
    """A robot's model, as the loops take it."""
    A_rw = np.ascontiguousarray(np.asarray(model.wheels.A_rw).T)
    I_rw = (np.asarray(model.wheels.axes).T * A_rw).sum(axis=1)
    theta = np.ascontiguousarray(model.theta)
    return Machine(joints_of(model.tree), theta, A_rw, I_rw)


@looped
def equations(machine, q, v):
    """`H+` and `c+` in every state, a row of `q` and one of `v`."""
    H, c = np.empty((len(q), v.shape[1], v.shape[1])), np.empty(v.shape)
    bodies = room(len(machine.theta))
    motion = np.empty((2, len(machine.theta), 3))
    rate = np.empty((2, len(machine.theta), 3))
    for n in range(len(q)):
        place(machine.joints, q[n], bodies)
        weigh(machine.theta, bodies)
        bias(machine.joints, machine.A_rw, bodies, motion, rate, v[n], c[n])
        mass_matrix(machine.joints, bodies, H[n])
        _add_wheels(machine, H[n], c[n])
        _mirror(H[n])
    return H, c


@looped
def _add_wheels(machine, H, c):
    """Relative to the base, and free of velocity-dependent torques."""
    first = 6 + len(machine.joints.parent)
    for k in range(len(machine.I_rw)):
        row = H[first + k]
        for j in range(first + k):
            row[j] = 0.0
        for i in range(3):
            row[3 + i] = machine.A_rw[k, i]
        row[first + k], c[first + k] = machine.I_rw[k], 0.0


@looped
def _mirror(H):
    for i in range(len(H)):
        for j in range(i):
            H[j, i] = H[i, j]
