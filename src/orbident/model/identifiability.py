"""What no free-floating recording of a robot can determine, in words."""

import numpy as np

from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY, SYMBOLS
from orbident.threads import one_blas_thread

# The projector on what is seen has 1 on the diagonal where a parameter is seen alone.
ALONE = 1e-6
NEVER = 1e-9


@one_blas_thread
def not_identifiable(robot: Robot, sets: MinimalSets) -> list[str]:
    """Plain sentences: no scale, parameters that never show, or only in company."""
    sentences = []
    if not robot.wheels:
        sentences.append(
            "the scale of pi, and so the total mass: without a reaction wheel the "
            "momentum equation has no known term; declare the robot's wheels, or "
            "record its thrusters or magnetic torquers"
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
