"""All joint motions of Eq. 41 with given ends, as a linear space.

With the ends fixed, positions and rates are linear in the coefficients `a, b`. But the
quintic nearly cancels a slow harmonic, so some coefficients may be a hundred times
larger than the motion they make: a search over `a, b` never gets there. Here a motion
is `y`, coordinates in which the rate has mean square 1, over the joint's limit.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.excitation.conditions import Limits
from orbident.robot.couplings import CoupledJoints
from orbident.trajectories.fourier_quintic import FourierQuintic

NEGLIGIBLE = 1e-4
"""A rate whose coefficients are ten thousand times larger is not worth its digits."""

Histories = tuple[
    Float[np.ndarray, "n columns"],
    Float[np.ndarray, "n columns"],
    Float[np.ndarray, "n columns"],
]
"""Position, rate and acceleration."""


class JointMotions(NamedTuple):
    """Histories at some times: an offset, and what each coordinate adds to it."""

    t: Float[np.ndarray, " n"]
    offset: Histories
    """Histories of each joint with all `a` and `b` zero."""
    basis: Histories
    """Histories of a joint whose rate limit is 1, for each coordinate of `y`."""
    scale: Float[np.ndarray, " free"]
    """The rate limits."""
    coupled: CoupledJoints
    ab_of_y: Float[np.ndarray, "2harmonics m"]
    without_series: FourierQuintic
    """What `offset` are the values of."""

    def resampled(self, nodes: int) -> "JointMotions":
        """The same motions at so many times, evenly spaced over the duration."""
        offset = self.without_series
        t = np.linspace(0.0, offset.duration, nodes)
        a, b = np.split(self.ab_of_y.T, 2, axis=1)
        still = np.zeros((len(a), 3))
        basis = FourierQuintic(a, b, still, still, offset.duration)
        return self._replace(t=t, offset=offset.at(t), basis=basis.at(t))

    @property
    def _gain(self) -> Float[np.ndarray, "joints free"]:
        return self.coupled.lead * self.scale

    def along(
        self, y: Float[np.ndarray, "free m"]
    ) -> tuple[Float[np.ndarray, "n joints"], Float[np.ndarray, "n joints"]]:
        """Positions and rates."""
        scaled = (self._gain @ y).T
        return self.offset[0] + self.basis[0] @ scaled, (
            self.offset[1] + self.basis[1] @ scaled
        )

    def pull_back(
        self,
        by_q: Float[np.ndarray, "n joints"],
        by_qd: Float[np.ndarray, "n joints"],
    ) -> Float[np.ndarray, "free m"]:
        """The gradient with respect to `y`."""
        return self._gain.T @ (by_q.T @ self.basis[0] + by_qd.T @ self.basis[1])

    def coefficients(
        self, y: Float[np.ndarray, "free m"]
    ) -> tuple[Float[np.ndarray, "joints N_f"], Float[np.ndarray, "joints N_f"]]:
        """`a` and `b` of Eq. 41."""
        ab = self._gain @ (y @ self.ab_of_y.T)
        harmonics = ab.shape[1] // 2
        return ab[:, :harmonics], ab[:, harmonics:]

    def coordinates(
        self, a: Float[np.ndarray, "joints N_f"], b: Float[np.ndarray, "joints N_f"]
    ) -> Float[np.ndarray, "free m"]:
        """`y` of the nearest motion in the space."""
        ab = np.concatenate([a, b], axis=1)[self.coupled.free] / self.scale[:, None]
        return ab @ np.linalg.pinv(self.ab_of_y).T


def joint_motions(
    start: Float[np.ndarray, "joints 3"],
    end: Float[np.ndarray, "joints 3"],
    duration: float,
    harmonics: int,
    limits: Limits,
    nodes: int,
    coupled: CoupledJoints | None = None,
) -> JointMotions:
    """The motions between two states of the joints.

    Args:
        start: position, velocity and acceleration of each joint at t = 0.
        end: the same at the end.
        duration: t_f, s.
        harmonics: N_f.
        limits: of the joints' rates.
        nodes: so many times, evenly spaced from 0 to the duration.
        coupled: which joints follow others; none where absent.
    """
    if coupled is None:
        joints = len(start)
        coupled = CoupledJoints([*range(joints)], np.eye(joints), np.zeros(joints))
    t = np.linspace(0.0, duration, nodes)
    none = np.zeros((len(start), harmonics))
    offset = FourierQuintic(none, none, start, end, duration)
    still = np.zeros((2 * harmonics, 3))
    a, b = np.hsplit(np.eye(2 * harmonics), 2)
    rates = FourierQuintic(a, b, still, still, duration).derivative(1, t)
    _, s, Vt = np.linalg.svd(rates / np.sqrt(nodes), full_matrices=False)
    kept = s > NEGLIGIBLE * s[0]
    ab_of_y = Vt[kept].T / s[kept]
    empty = offset.at(t[:0])
    scale = limits.velocity[coupled.free]
    return JointMotions(t[:0], empty, empty, scale, coupled, ab_of_y, offset).resampled(
        nodes
    )
