"""Torques and forces that depend on time alone.

    constant       tau = tau_0,   F = F_0
    Gauss-Markov   cov(tau(t), tau(t + s)) = std^2 exp(-abs(s) / T), each axis
    burst          F = R_WB F_0   from its start until its end

Forces act at S; all but a burst's are given in inertial axes.
"""

import numpy as np
from jaxtyping import Float

from orbident.model.rotations import rotate
from orbident.simulation.environment.moving import Load, Moving, Vectors
from orbident.simulation.noise_processes import markov
from orbident.trajectories.environment import Burst

S = np.zeros(3)


class Slow:
    """A Gauss-Markov process at some times, straight from one to the next."""

    def __init__(
        self,
        t: Float[np.ndarray, " rows"],
        std: float,
        correlation_time: float,
        random: np.random.Generator,
    ) -> None:
        """Draw it.

        Args:
            t: the times at which it is drawn, s.
            std: of each axis, N m or N.
            correlation_time: s; infinite for what stays as it is drawn.
            random: the process's stream.
        """
        self.t = t
        self.drawn = markov(random, t, np.full(3, std), np.full(3, correlation_time))

    def at(self, t: Float[np.ndarray, " n"]) -> Vectors:
        """The process at the times `t`, s."""
        return np.stack([np.interp(t, self.t, x) for x in self.drawn.T], axis=1)


def constant_torque(torque: tuple[float, ...], moving: Moving) -> list[Load]:
    """The same torque all the time, inertial axes, N m."""
    return [moving.acting(0, S, moment=np.tile(torque, (moving.t.size, 1)))]


def constant_force(force: tuple[float, ...], moving: Moving) -> list[Load]:
    """The same force at S all the time, inertial axes, N."""
    return [moving.acting(0, S, force=np.tile(force, (moving.t.size, 1)))]


def slow_torque(slow: Slow, moving: Moving) -> list[Load]:
    """A torque that was drawn, inertial axes."""
    return [moving.acting(0, S, moment=slow.at(moving.t))]


def slow_force(slow: Slow, moving: Moving) -> list[Load]:
    """A force at S that was drawn, inertial axes."""
    return [moving.acting(0, S, force=slow.at(moving.t))]


def burst(given: Burst, moving: Moving) -> list[Load]:
    """A force at S for a while, base axes."""
    end = given.start + given.duration
    on = (given.start <= moving.inside) & (moving.inside < end)
    force = rotate(moving.R_WB, on[:, None] * np.array(given.force))
    return [moving.acting(0, S, force=force)]
