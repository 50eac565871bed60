"""Where the search begins: attitude as measured, the rest from linear estimates."""

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp

from orbident.compilation import compiled
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.dynamics.wheels import wheels_of
from orbident.estimation.output_error.chain import Loose, State
from orbident.estimation.output_error.sensors import Sensors, scatter
from orbident.estimation.output_error.unknowns import LOCAL, Own
from orbident.regressors.minimal_sets import conserved_axes
from orbident.robot.description import Robot
from orbident.signals.histories import MEASURED
from orbident.signals.samples import Samples

CONTINUOUS = 1e-9
"""rad/sqrt(s): what splines and integration add to the attitude."""

STEADY = 1e-6
"""Walk of a bias of which nothing is declared, over the noise of a sample."""

SLIGHT = 1e-11
"""rad/s and m/s^2 per sqrt(s): with less, rounding hides what else is known of it."""

FIXED = 1e-9
"""rad: without an attitude sensor, inertial axes are those of the first attitude."""

BIAS = np.repeat([0.1, 1.0], 3)
"""Std of biases beforehand, rad/s and m/s^2: more than any sensor's."""

ENCODERS = 1e-2
"""Std of the error of smoothed encoders beforehand, rad or m, and per second."""

STEP = 1 / 16
"""rad of nutation: steps of RK4 so large are wrong by 1e-8 rad."""

MOST_SUBSTEPS = 32

_inertia = compiled(inertia)


def looseness(robot: Robot, samples: Samples, sensors: Sensors) -> Loose:
    """How freely attitude, biases and joints may vary from segment to segment."""
    turns = np.full(3, FIXED)
    if "attitude" in sensors.by_name:
        # Nothing would hold a planar base's tilt, and it is none.
        turns[list(conserved_axes(robot)[0])] = np.pi
    walks = []
    for name in ("gyro", "accelerometer"):
        sensed = sensors.by_name.get(name)
        walk = max(sensed.drift, STEADY * sensed.std, SLIGHT) if sensed else 1.0
        walks += 3 * [walk]
    # Joints whose rates are measured, or that do not move, have no corrections.
    free = [
        ENCODERS
        if "joints" in sensors.by_name and name not in samples.locked
        else FIXED
        for name in robot.joint_names
    ]
    corrections = np.tile(free, 2)
    return Loose(
        first=np.concatenate([turns, BIAS, corrections]),
        corrections=corrections,
        walk=np.array([*3 * [_turn_walk(robot, samples)], *walks]),
    )


def _turn_walk(robot: Robot, samples: Samples) -> float:
    """What noise of measured wheel speeds adds to the attitude, rad/sqrt(s)."""
    if samples.origins["wheel_speeds"] != MEASURED or not robot.wheels:
        return CONTINUOUS
    h_rw = _wheels_momentum(robot, samples)
    known = np.isfinite(h_rw).all(axis=1)
    dt = float(np.median(np.diff(samples.t[known])))
    rate = scatter(h_rw[known]) / float(_principal_inertias(robot)[0])
    return max(rate * np.sqrt(dt), CONTINUOUS)


def substeps_of(robot: Robot, samples: Samples) -> int:
    """How many RK4 steps a sample follow the fastest nutation; few sizes are compiled.

    It turns with at most `|h_cm| / D`, and its phase is wrong by the fourth power of
    the step.
    """
    if robot.motion == "planar":
        return 1
    D = _principal_inertias(robot)
    w, h_rw = (
        np.nanmax(np.linalg.norm(vectors, axis=1), initial=0.0)
        for vectors in (np.column_stack(samples.w), _wheels_momentum(robot, samples))
    )
    rate = w + (D[-1] * w + h_rw) / D[0]
    turned = rate * float(np.median(np.diff(samples.t)))
    return int(2 ** np.ceil(np.log2(np.clip(turned / STEP, 1, MOST_SUBSTEPS))))


def _wheels_momentum(robot: Robot, samples: Samples) -> Float[np.ndarray, "n 3"]:
    qd_rw = np.reshape(samples.qd_rw, (len(robot.wheels), samples.t.size))
    return qd_rw.T @ wheels_of(robot).A_rw.T


def _principal_inertias(robot: Robot) -> Float[np.ndarray, " axes"]:
    """Nominal, of the whole robot; about z alone in the plane."""
    D = _inertia(tree_of(robot), robot.theta, np.zeros(len(robot.joints))).D
    return np.linalg.eigvalsh(D[2:, 2:] if robot.motion == "planar" else D)


def start_of(
    samples: Samples,
    t: Float[np.ndarray, " boundaries"],
    own: Own,
    beta: Float[np.ndarray, " beta"],
    joints: int,
) -> State:
    """The state at the boundaries `t`, without biases or corrections."""
    local = np.zeros((t.size, LOCAL + 2 * joints))
    common = np.concatenate([*own, beta])[LOCAL:]
    return State(_attitude(samples, t), local, common)


def _attitude(
    samples: Samples, t: Float[np.ndarray, " boundaries"]
) -> Float[np.ndarray, "boundaries 4"]:
    x = np.column_stack(samples.x_WB)
    known = np.isfinite(x).all(axis=1)
    at = samples.t[known]
    between = Slerp(at, Rotation.from_quat(x[known]))
    return between(np.clip(t, at[0], at[-1])).as_quat()
