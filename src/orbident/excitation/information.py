"""Fisher information of the free-flying base parameters under a robot's sensors.

With the joint history and the attitude that turns `h_cm` as measured, momentum
conservation predicts, to first order in `beta = [M, sigma, iota]`,

    d w   = D^-1 (R_0^T d h_cm - Y (d pi/d beta) d beta)
    d v_S = d v_cm + R_0 (W (d phi/d beta) d beta + r_cm x d w)

A gyro sees `w`, an accelerometer the changes of `v_S`, a star tracker or motion capture
the integral of `w`, and motion capture that of `v_S`; each with white noise and an
unknown constant. Momenta and constants are eliminated.
"""

from collections.abc import Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.errors import InputError
from orbident.excitation.floating import Floating
from orbident.regressors.derivatives import derivatives_of_beta
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray

RATE = 20.0
"""Hz, where the robot file does not say: the paper's."""

Blocks = Mapping[str, Float[AnyArray, "_ _ _"]]
"""Rows of a sensor, times first, for each group of unknowns."""


class Sensing(eqx.Module):
    """What is measured how well, and what of."""

    weights: dict[str, float]
    """By sensor that is there: 1 over the variance of a second of it, SI."""
    pi_of: Float[AnyArray, "pi unknowns"]
    """`d pi` of a change of the unknowns."""
    phi_of: Float[AnyArray, "phi unknowns"]
    beta_of: Float[AnyArray, "beta unknowns"]
    """The unknowns are `beta`, in units in which random motion shows all alike."""


def sensing_of(robot: Robot, sets: MinimalSets) -> Sensing:
    """The sensors of the robot file, around the nominal parameters.

    Raises:
        InputError: the robot file has no sensor of the base's motion.
    """
    declared = robot.sensors
    rate = float(declared.get("rate") or RATE)
    entries = {
        "gyro": ("angle_random_walk", 1.0),
        "accelerometer": ("velocity_random_walk", 1.0),
        "attitude": ("angle", rate),
        "position": ("std", rate),
    }
    weights = {}
    for sensor, (key, per_second) in entries.items():
        noise = (declared.get(sensor) or {}).get(key, 0.0)
        if noise:
            weights[sensor] = per_second / noise**2
    if not weights:
        raise InputError(
            f"{robot.name}: sensors: found no noise of gyro, accelerometer, attitude "
            "or position; the objectives d, a and e need it: give it in the robot "
            "file, or use the objective cond"
        )
    dpi, dphi = derivatives_of_beta(sets, sets.beta(robot.theta))
    unit = _unit(sets, dpi, dphi)
    return Sensing(weights, dpi @ unit, dphi @ unit, unit)


def _unit(
    sets: MinimalSets,
    dpi: Float[np.ndarray, "pi beta"],
    dphi: Float[np.ndarray, "phi beta"],
) -> Float[np.ndarray, "beta beta"]:
    """Units of `beta` that depend on no basis: random motion shows them all alike."""
    random = np.random.default_rng(0)
    joints = sets.regressors.tree.parent.shape[0]
    q, qd = random.standard_normal((2, 4 * len(dpi), joints))
    w = random.standard_normal((4 * len(dpi), 3))
    if len(sets.regressors.momentum_axes) == 1:
        w[:, :2] = 0.0
    Y, W = compiled(jax.vmap(sets.regressors))(q, qd, w)
    shown = np.concatenate(
        [
            (X @ d).reshape(-1, d.shape[1])
            for X, d in ((np.asarray(Y), dpi), (np.asarray(W), dphi))
        ]
    )
    R = np.linalg.qr(shown / np.sqrt(len(q)), mode="r")
    return np.linalg.inv(R)


def information(
    sensing: Sensing,
    motion: Floating,
    dt: float | Float[AnyArray, ""],
    at_rest: bool,
) -> Float[AnyArray, "unknowns unknowns"]:
    """The information that a motion gives of the unknowns, nuisances eliminated.

    Args:
        sensing: what is measured.
        motion: of the robot.
        dt: from node to node, s.
        at_rest: `h_cm = 0` is known: all was at rest before the wheels spun up.
    """
    n, h, _ = motion.Y.shape
    v, u = motion.W.shape[1], sensing.pi_of.shape[1]
    dw, dv = _shown(sensing, motion)
    one_h, one_v = (jnp.broadcast_to(jnp.eye(k), (n, k, k)) for k in (h, v))
    seen: dict[str, Blocks] = {
        "gyro": {**dw, "gyro": one_h},
        "accelerometer": {
            **{name: jnp.diff(block, axis=0) / dt for name, block in dv.items()},
            "accelerometer": motion.R_v[1:],
        },
        "attitude": {
            **{name: _integral(motion.R_h @ block, dt) for name, block in dw.items()},
            "attitude": one_h,
        },
        "position": {
            **{name: _integral(block, dt) for name, block in dv.items()},
            "v_cm": _integral(one_v, dt),
            "position": one_v,
        },
    }
    nuisances = {"h_cm": h, "gyro": h, "attitude": h, "accelerometer": v}
    nuisances |= {"position": v, "v_cm": v}
    needed = set(sensing.weights) if at_rest else {"h_cm", *sensing.weights}
    if "position" in sensing.weights:
        needed.add("v_cm")
    layout = {"unknown": u}
    layout |= {name: size for name, size in nuisances.items() if name in needed}
    F = jnp.zeros((sum(layout.values()),) * 2)
    for sensor, weight in sensing.weights.items():
        rows = _rows(seen[sensor], layout)
        F = F + weight * dt * rows.T @ rows
    return _without_nuisances(F, u)


def _without_nuisances(
    F: Float[AnyArray, "all all"], unknowns: int
) -> Float[AnyArray, "unknowns unknowns"]:
    """The Schur complement; nuisances scaled, since their units differ."""
    F_uu, F_nu = F[:unknowns, :unknowns], F[unknowns:, :unknowns]
    scale = 1 / jnp.sqrt(jnp.diag(F)[unknowns:])
    F_nn = F[unknowns:, unknowns:] * scale[:, None] * scale
    F_nu = F_nu * scale[:, None]
    left = F_uu - F_nu.T @ jnp.linalg.solve(F_nn, F_nu)
    return (left + left.T) / 2


def _shown(sensing: Sensing, motion: Floating) -> tuple[Blocks, Blocks]:
    """Changes of the base rate, base axes, and of the velocity of S, inertial axes."""
    dw = {
        "unknown": -motion.E @ (motion.Y @ sensing.pi_of),
        "h_cm": motion.E @ jnp.swapaxes(motion.R_h, 1, 2),
    }
    dv = {
        "unknown": motion.R_v
        @ (motion.W @ sensing.phi_of + motion.lever @ dw["unknown"]),
        "h_cm": motion.R_v @ motion.lever @ dw["h_cm"],
    }
    return dw, dv


def _integral(
    X: Float[AnyArray, "n axes m"], dt: float | Float[AnyArray, ""]
) -> Float[AnyArray, "n axes m"]:
    """From the first node, by the trapezoidal rule."""
    steps = dt / 2 * (X[1:] + X[:-1])
    return jnp.concatenate([jnp.zeros_like(X[:1]), jnp.cumsum(steps, axis=0)])


def _rows(blocks: Blocks, layout: Mapping[str, int]) -> Float[AnyArray, "rows columns"]:
    """Blocks side by side in the order of the layout, zero where there is none."""
    n, axes, _ = blocks["unknown"].shape
    parts = [
        blocks[name] if name in blocks else jnp.zeros((n, axes, size))
        for name, size in layout.items()
    ]
    return jnp.concatenate(parts, axis=-1).reshape(n * axes, -1)
