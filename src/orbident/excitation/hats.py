"""The stacked regressors `Y-hat` (Eq. 24) and `W-hat` (Eq. 31) of a motion."""

from typing import NamedTuple

from jaxtyping import Float

from orbident.excitation.floating import Floating
from orbident.spatial.arrays import AnyArray


class Basis(NamedTuple):
    """Which parameters the columns of `Y` and `W` belong to."""

    pi_of: Float[AnyArray, "pi basis_pi"]
    """The automatic `pi` is this times the one in use: its columns are `Y pi_of`."""
    phi_of: Float[AnyArray, "phi basis_phi"]


def Y_hat(
    motion: Floating, pi_of: Float[AnyArray, "pi m"], at_rest: bool
) -> Float[AnyArray, "rows m"]:
    """`R_0 Y - (R_0 Y)_in`, inertial axes (Eq. 24).

    Args:
        motion: of the robot.
        pi_of: the parameters in use.
        at_rest: all was at rest before the wheels spun up, so `Y_in = 0` (Eq. 26).
    """
    RY = motion.R_h @ (motion.Y @ pi_of)
    RY = RY if at_rest else RY - RY[0]
    return RY.reshape(-1, RY.shape[-1])


def W_hat(
    motion: Floating, phi_of: Float[AnyArray, "phi m"]
) -> Float[AnyArray, "rows m"]:
    """`[W, R_0^T]` with the velocity of the CM eliminated (Eq. 31), inertial axes."""
    # R_0 [W, R_0^T] = [R_0 W, 1]: a constant is what the mean takes away.
    RW = motion.R_v @ (motion.W @ phi_of)
    RW = RW - RW.mean(axis=0)
    return RW.reshape(-1, RW.shape[-1])
