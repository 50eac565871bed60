"""The free-flying dynamics of a robot from its base parameters alone (Eq. 16).

`theta_of beta` is a `theta` with the momentum of `beta = [M, sigma, iota]`. The rows of
`H+` that belong to joints lie in the same parameter space as those of the base (theory,
section 8), so that `H+`, `c+` and the Jacobians are the robot's, although its bodies
need not be any that can exist.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import joined
from orbident.model.core_robot import friction_torques, lacking_rotors, rotors_of
from orbident.model.equations_of_motion import (
    Wrench,
    check_definite,
    deviations,
    equations_of_motion,
    generalised_forces,
    jacobian,
    motion_with,
    movable,
    speeds,
)
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

TILT = [3, 4]
"""The rates about x and y among the speeds, whose rows no planar motion shows."""


@dataclass(frozen=True, eq=False, repr=False)
class Dynamics:
    """`H+ v' + c+ = Q` (Eq. 13) over `v = [v_cm, w, qd, qd_rw]`, base axes.

    `q` and `v` are one state, or many, state first. What the parameters do not
    determine is NaN: in the plane, the rows and columns of the base's rates about x
    and y.
    """

    robot: Robot
    """The robot with a `theta` of the identified momentum; the nominal one is gone."""
    root: Float[np.ndarray, "beta beta"]
    """A square root of the covariance of the base parameters."""
    moved: float = 0.0
    """How far the base parameters were moved so that bodies can exist, in sigmas."""

    def __repr__(self) -> str:
        """What it is of, over which speeds, and what it gives."""
        robot = self.robot
        lines = [
            f"dynamics of {robot.name}, {robot.mass:.6g} kg, over v_cm, w, "
            f"{len(robot.joints)} joints and {len(robot.wheels)} wheels",
            f"its parameters moved by {self.moved:.2g} sigmas, to bodies that can exist"
            if self.moved
            else "",
            lacking_rotors(robot),
            "H_plus(q), c_plus(q, v), equations(q, v), jacobian(q, body, point), "
            "generalised_forces(q, joint_torques, wheel_torques), torques(q, qd, qdd)",
        ]
        return "\n".join(filter(None, lines))

    def H_plus(
        self, q: Float[np.ndarray, "*n joints"]
    ) -> Float[np.ndarray, "*n speeds speeds"]:
        """The system inertia matrix `H+` (Eq. 14).

        A joint's own entry has `gear^2` times the inertia of its motor's rotor only
        where the robot file declares it.

        Args:
            q: joint positions, rad or m.

        Raises:
            InputError: `q` has not the robot's size.
        """
        q = self._sized(q, "q", self._joints)
        return self._shown(self._equations(q, self._at_rest(q))[0], rows=2)

    def c_plus(
        self, q: Float[np.ndarray, "*n joints"], v: Float[np.ndarray, "*n speeds"]
    ) -> Float[np.ndarray, "*n speeds"]:
        """The velocity-dependent forces `c+` (Eqs. 9-13).

        Args:
            q: joint positions, rad or m.
            v: generalised speeds, base axes.

        Raises:
            InputError: `q` or `v` has not the robot's size, or leaves its plane.
        """
        return self.equations(q, v)[1]

    def equations(
        self, q: Float[np.ndarray, "*n joints"], v: Float[np.ndarray, "*n speeds"]
    ) -> tuple[Float[np.ndarray, "*n speeds speeds"], Float[np.ndarray, "*n speeds"]]:
        """`H+` and `c+` at once: as fast as either of them.

        Args:
            q: joint positions, rad or m.
            v: generalised speeds, base axes.

        Raises:
            InputError: `q` or `v` has not the robot's size, or leaves its plane.
        """
        q, v = self._state(q, v)
        H, c = self._equations(q, v)
        return self._shown(H, rows=2), self._shown(c, rows=1)

    def H_plus_std(
        self, q: Float[np.ndarray, "*n joints"]
    ) -> Float[np.ndarray, "*n speeds speeds"]:
        """Standard deviations of the entries of `H+`, of first order.

        Args:
            q: joint positions, rad or m.

        Raises:
            InputError: `q` has not the robot's size.
        """
        q = self._sized(q, "q", self._joints)
        return self._shown(self._std(q, self._at_rest(q))[0], rows=2)

    def c_plus_std(
        self, q: Float[np.ndarray, "*n joints"], v: Float[np.ndarray, "*n speeds"]
    ) -> Float[np.ndarray, "*n speeds"]:
        """Standard deviations of the entries of `c+`, of first order.

        Args:
            q: joint positions, rad or m.
            v: generalised speeds, base axes.

        Raises:
            InputError: `q` or `v` has not the robot's size, or leaves its plane.
        """
        q, v = self._state(q, v)
        return self._shown(self._std(q, v)[1], rows=1)

    def jacobian(
        self, q: Float[np.ndarray, " joints"], body: str, point: Float[np.ndarray, "3"]
    ) -> Float[np.ndarray, "6 speeds"]:
        """`J_0,p` and `J_i,p` (A.1, A.2): how a point of a body moves, over `v`.

        Args:
            q: joint positions, rad or m.
            body: its name.
            point: in the body's frame (the base's is at S), m.

        Returns:
            Rows: velocity of the point, then the body's rate; inertial motions, base
            axes.

        Raises:
            InputError: `q` or `point` has a wrong size, or the body is not the robot's.
        """
        q = self._sized(q, "q", self._joints, states=False)
        point = self._sized(point, "point", 3, states=False)
        return self._shown(jacobian(self.robot, q, body, point), rows=1)

    def generalised_forces(
        self,
        q: Float[np.ndarray, " joints"],
        joint_torques: Mapping[str, float],
        wheel_torques: Mapping[str, float],
        wrenches: Sequence[Wrench] = (),
    ) -> Float[np.ndarray, " speeds"]:
        """`Q = [0, 0, tau, tau_rw] + sum J^T F` (Eq. 15).

        Args:
            q: joint positions, rad or m.
            joint_torques: by joint name, N m or N; zero where absent.
            wheel_torques: on the rotor, by wheel name, N m; zero where absent.
            wrenches: what acts from outside.

        Raises:
            InputError: `q` has a wrong size, or a joint, a wheel or a body is not the
                robot's.
        """
        q = self._sized(q, "q", self._joints, states=False)
        Q = generalised_forces(self.robot, q, joint_torques, wheel_torques, wrenches)
        return self._shown(Q, rows=1)

    def torques(
        self,
        q: Float[np.ndarray, "*n joints"],
        qd: Float[np.ndarray, "*n joints"],
        qdd: Float[np.ndarray, "*n joints"],
        *,
        w: Float[np.ndarray, "*n 3"] | None = None,
        qd_rw: Float[np.ndarray, "*n wheels"] | None = None,
        qdd_rw: Float[np.ndarray, "*n wheels"] | None = None,
        friction: bool = False,
    ) -> Float[np.ndarray, "*n joints"]:
        """The joint torques of a motion where nothing acts from outside (Eq. 13).

        The base floats as the motion of joints and wheels makes it.

        Args:
            q: joint positions, rad or m.
            qd: joint rates, rad/s or m/s.
            qdd: joint accelerations, rad/s^2 or m/s^2.
            w: base rate, base axes, rad/s; by default that of a robot without angular
                momentum, wheels included.
            qd_rw: speeds of the wheels relative to the base, rad/s; by default zero.
            qdd_rw: their accelerations, rad/s^2; by default zero.
            friction: whether to add what friction takes, as torques at joints showed
                it, else as the robot file declares it: NaN where neither does.

        Returns:
            Torques in N m, or forces in N of joints that slide.

        Raises:
            InputError: an argument has not the robot's size, or `w` leaves its plane.
        """
        q, v = self._sized(q, "q", self._joints), []
        joints, wheels = self._joints, len(self.robot.wheels)
        for name, given, size in (
            ("w", w, 3),
            ("qd", qd, joints),
            ("qd_rw", qd_rw, wheels),
            ("qdd", qdd, joints),
            ("qdd_rw", qdd_rw, wheels),
        ):
            none = np.zeros((*q.shape[:-1], size))
            v.append(none if given is None else self._sized(given, name, size))
            self._check_rows(q, **{name: v[-1]})
        of_joints, none = slice(6, 6 + joints), np.zeros((*q.shape[:-1], 3))
        v_dot = np.concatenate([none, none, *v[3:]], axis=-1)
        q, v = self._state(q, np.concatenate([none, *v[:3]], axis=-1))
        if w is None:
            turning = np.flatnonzero(movable(self.robot)[3:6]) + 3
            H = self._equations(q, v)[0][..., turning, :]
            h = np.einsum("...ij,...j->...i", H, v)
            v[..., turning] = -np.linalg.solve(H[..., turning], h[..., None])[..., 0]
        free = movable(self.robot)
        free[6:] = False
        states = np.atleast_2d(q), np.atleast_2d(v), np.atleast_2d(v_dot)
        found = motion_with(self.robot, *states, free).Q[:, of_joints]
        if friction:
            known = [name in self.robot.friction for name in self.robot.joint_names]
            rubbed = friction_torques(self.robot, states[1][:, of_joints])
            found = found + np.where(known, rubbed, np.nan)
        return found.reshape(q.shape)

    @property
    def _joints(self) -> int:
        return len(self.robot.joints)

    def _at_rest(
        self, q: Float[np.ndarray, "*n joints"]
    ) -> Float[np.ndarray, "*n speeds"]:
        return np.zeros((*q.shape[:-1], speeds(self.robot)))

    def _equations(
        self, q: Float[np.ndarray, "*n joints"], v: Float[np.ndarray, "*n speeds"]
    ) -> tuple[Float[np.ndarray, "*n speeds speeds"], Float[np.ndarray, "*n speeds"]]:
        H, c, _ = equations_of_motion(self.robot, *map(np.atleast_2d, (q, v)))
        return H.reshape(*v.shape, v.shape[-1]), c.reshape(v.shape)

    def _sized(
        self, values: Any, what: str, size: int, states: bool = True
    ) -> Float[np.ndarray, "*n size"]:
        array = np.asarray(values, dtype=float)
        if array.shape[-1:] != (size,) or array.ndim > 1 + states:
            each = f", or (n, {size})" if states else ""
            raise InputError(
                f"{self.robot.name}: {what}: found shape {array.shape}, expected "
                f"({size},){each}, in the robot's order"
            )
        return array

    def _check_rows(
        self, q: Float[np.ndarray, "*n joints"], **others: Float[np.ndarray, "*m k"]
    ) -> None:
        for name, each in others.items():
            if q.shape[:-1] != each.shape[:-1]:
                raise InputError(
                    f"{self.robot.name}: q has shape {q.shape} and {name} "
                    f"{each.shape}; give one row of each for every state"
                )

    def _state(
        self, q: Any, v: Any
    ) -> tuple[Float[np.ndarray, "*n joints"], Float[np.ndarray, "*n speeds"]]:
        q = self._sized(q, "q", self._joints)
        v = self._sized(v, "v", speeds(self.robot))
        self._check_rows(q, v=v)
        if (v[..., ~movable(self.robot)] != 0).any():
            raise InputError(
                f"{self.robot.name}: v leaves the plane of a planar robot; give zero "
                "for v_cm along z and for w about x and y"
            )
        return q, v

    def _std(
        self, q: Float[np.ndarray, "*n joints"], v: Float[np.ndarray, "*n speeds"]
    ) -> tuple[Float[np.ndarray, "*n speeds speeds"], Float[np.ndarray, "*n speeds"]]:
        theta_of = minimal_sets(self.robot).base.theta_of
        directions = (theta_of @ self.root).T.reshape(-1, *self.robot.theta.shape)
        states = map(np.atleast_2d, (q, v))
        H_std, c_std = deviations(self.robot, directions, *states)
        _, armature, tolerance = rotors_of(self.robot)
        own = np.arange(6, 6 + self._joints)
        H_std[:, own, own] = np.hypot(H_std[:, own, own], tolerance * armature)
        return H_std.reshape(*v.shape, v.shape[-1]), c_std.reshape(v.shape)

    def _shown(self, entries: Any, rows: int) -> Any:
        """The entries, with NaN for what a planar motion does not determine."""
        if self.robot.motion == "planar":
            entries[..., TILT] = np.nan
            if rows == 2:
                entries[..., TILT, :] = np.nan
        return entries


def reconstructed(
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    covariance: Float[np.ndarray, "beta beta"],
) -> Dynamics:
    """The dynamics of a robot with these base parameters.

    Its nominal inertia is not used; `beta` is `[M, sigma, iota]`, and its covariance is
    NaN where it is not known.

    Raises:
        InputError: `beta` has not the robot's size or is not all known.
        IndefiniteError: no mechanism has such parameters: its mass matrix is not
            positive definite.
    """
    check_known(robot, beta)
    same_momentum = replace(robot, theta=minimal_sets(robot).theta(beta))
    check_definite(same_momentum)
    return Dynamics(same_momentum, root_of(covariance))


def check_known(robot: Robot, beta: Float[np.ndarray, " beta"]) -> None:
    """Refuse base parameters that are not those of the robot, or not all known.

    Raises:
        InputError: there are more or fewer of them, or some are NaN.
    """
    sets = minimal_sets(robot)
    if beta.shape != sets.base.T.shape[:1]:
        raise InputError(
            f"found {beta.size} base parameters, but robot '{robot.name}' has "
            f"{sets.base.T.shape[0]}; identify again"
        )
    names = formulas_of(robot, sets).base.names
    unknown = [names[k] for k in np.flatnonzero(~np.isfinite(beta))]
    if unknown:
        raise InputError(
            f"{robot.name}: {len(unknown)} of {beta.size} base parameters are not "
            f"determined ({joined(unknown)}), so there is no dynamics; identify from a "
            "recording that excites them (see its warnings)"
        )


def root_of(C: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """`S` such that `S S^T = C`, for a covariance that may be singular; or NaN."""
    if not np.isfinite(C).all():
        return np.full_like(C, np.nan)
    # Rounding leaves eigenvalues just below zero.
    values, vectors = np.linalg.eigh(C)
    return vectors * np.sqrt(np.maximum(values, 0.0))
