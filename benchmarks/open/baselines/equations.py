"""The two linear equations at every sample, for methods that go from one to the next.

    Y pi - R_0^T h_cm = -A_rw qd_rw                 (Eq. 24)
    W phi + R_0^T v_cm + R_0^T B b = R_0^T v_S      (Eq. 31)

`b` is the bias of an accelerometer, where the velocity is its integral. Rates come from
positions, which are smoothed; so does the attitude from the gyro.
"""

from typing import NamedTuple

import numpy as np

from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.model.rotations import quaternion_matrix
from orbident.preprocessing.samples import samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


class Equations(NamedTuple):
    """`[Y N_h] [pi; h_cm] = z_h` and `[W N_v] [phi; v_cm; b] = z_v` of each sample."""

    sets: MinimalSets
    Y: np.ndarray
    N_h: np.ndarray
    z_h: np.ndarray
    W: np.ndarray
    N_v: np.ndarray
    z_v: np.ndarray

    def noise(self, robot: Robot) -> tuple[float, float]:
        """The scatter of both equations with CAD values, from second differences."""
        h = self.z_h - self.Y @ self.sets.pi(robot.theta)
        v = self.z_v - self.W @ self.sets.phi(robot.theta)
        both = (np.diff(x, 2, axis=0) for x in (h, v))
        h, v = (float(np.sqrt(np.mean(np.square(x)) / 6)) for x in both)
        return h, v


def equations_of(robot: Robot, recording: Recording, momentum: str) -> Equations:
    """All samples that are complete.

    Args:
        robot: as its file says.
        recording: as its sensors made it.
        momentum: `"at-rest"` where `h_cm` is zero; else it is unknown.
    """
    sets, samples = minimal_sets(robot), samples_of(robot, recording)
    turning, moving = (
        list(axes)
        for axes in (sets.regressors.momentum_axes, sets.regressors.velocity_axes)
    )
    t, s = samples.complete()
    Y, W = sets.regressors(s.q, s.qd, s.w)
    R_BW = np.swapaxes(quaternion_matrix(s.x_WB), 1, 2)
    N_h = -R_BW[:, turning][:, :, turning]
    N_v = R_BW[:, moving][:, :, moving]
    drift = samples.drift()
    if drift is not None:
        more = (R_BW @ drift[np.isin(samples.t, t)])[:, moving][:, :, moving]
        N_v = np.concatenate([N_v, more], axis=2)
    return Equations(
        sets,
        Y,
        N_h[:, :, :0] if momentum == "at-rest" else N_h,
        (-s.qd_rw @ wheels_of(robot).A_rw.T)[:, turning],
        W,
        N_v,
        (R_BW @ s.v_S[:, :, None])[:, moving, 0],
    )
