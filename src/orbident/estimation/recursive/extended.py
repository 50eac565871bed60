"""The free-flying base parameters sample by sample: an extended square-root filter.

Its unknowns are `[h_cm, v_cm, b_g, b_a | pi, phi]`, in which the conservation laws are
linear: a triangular factor holds all that the samples said, whatever `beta` was
believed to be meanwhile. What is known beforehand joins it, by Gauss and Newton, one
step a sample:

    beta = argmin |R y(beta) - z|^2 + |root (beta - beta_0)|^2,   y = [pi, phi]

A filter whose state is `beta` alone would linearise every sample about another `beta`,
and take the differences for information: from CAD values it gets lost.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.recursive import step as compiled
from orbident.estimation.recursive.equations import Model, model_of, plain
from orbident.estimation.recursive.linear_sets import (
    LinearSets,
    linear_sets_at,
    linear_sets_of,
)
from orbident.estimation.recursive.noise import Noise
from orbident.estimation.recursive.prior import Prior, prior_from
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.recursive.state import Parts, State, state_of
from orbident.regressors.minimal_sets import MinimalSets
from orbident.regressors.reconstruction import root_of
from orbident.robot.description import Robot

FLAGS = ("accelerometer", "declared")
"""Of the noise: no numbers."""

WIDE = 10.0
"""The momentum is unknown to so many times what CAD values say it is."""

FASTEST = 10.0
"""m/s: no point of a robot moves faster relative to the CM."""

EXACTLY = 1e-6
"""N m s: by how much a momentum that is known may be wrong."""


class Info(NamedTuple):
    """What one sample said about the estimate before it."""

    white: Float[np.ndarray, " e"]
    """The innovation, whitened: independent, of unit variance, while nothing changes.
    Momentum first; zero where nothing was measured."""
    nis: float
    """Its square: chi-square with `dof` degrees of freedom."""
    dof: int


@dataclass(frozen=True)
class Extended:
    """The filter of one robot."""

    model: Model
    noise: Noise
    sets: LinearSets

    @classmethod
    def of(cls, robot: Robot, sets: MinimalSets, noise: Noise) -> "Extended":
        """The filter of a robot whose sensors have this noise."""
        # Of one type: whole numbers would be compiled for again.
        stds = {k: float(std) for k, std in noise._asdict().items() if k not in FLAGS}
        return cls(model_of(robot, sets), noise._replace(**stds), linear_sets_of(sets))

    def start(
        self, prior: Prior, sample: Sample, h_cm: Float[np.ndarray, "3"] | None = None
    ) -> State:
        """Nothing is known but the prior; the sample itself is not used up.

        Args:
            prior: of `beta`.
            sample: complete; sets the scale of the momentum.
            h_cm: the momentum where it is known (Eqs. 25 and 26), inertial axes, N m s.
        """
        seen, R_WB = compiled.momentum(plain(self.model), prior.beta, sample.packed)
        h, v, _, _ = self._nuisances
        x = np.zeros(self._nuisances[-1].stop)
        x[h] = (seen if h_cm is None else h_cm)[self.model.turning]
        x[v] = np.nan_to_num(sample.v_S)[self.model.moving]
        parts = self._fresh(np.nan, R_WB, prior, x)
        if h_cm is not None:
            parts.top[h, h] = np.eye(h.stop) / EXACTLY
            parts.top[h, -1] = x[h] / EXACTLY
        return state_of(parts)

    @property
    def rows(self) -> int:
        """Of a sample's innovation."""
        return self.model.turning.size + self.model.moving.size

    def opened(self, state: State, covariance: Float[np.ndarray, "beta beta"]) -> State:
        """The robot has changed: the estimate becomes the prior of what it is now.

        Args:
            state: before.
            covariance: of what may have changed, added to the estimate's own.
        """
        prior = prior_from(state.beta, state.covariance + covariance)
        parts = state.parts
        return state_of(self._fresh(state.t, parts.R_WB, prior, parts.nuisances))

    @property
    def _nuisances(self) -> list[slice]:
        """Where `h_cm`, `v_cm`, `b_g` and `b_a` are among the nuisances."""
        h, v = self.model.turning.size, self.model.moving.size
        stops = np.cumsum([h, v, h, v if self.noise.accelerometer else 0])
        return [slice(*ends) for ends in pairwise([0, *stops.tolist()])]

    def biases(
        self,
        top: Float[np.ndarray, "x all"],
        beta: Float[np.ndarray, " beta"],
        covariance: Float[np.ndarray, "beta beta"],
    ) -> dict[str, dict[str, float]]:
        """Those of gyro (rad/s) and accelerometer (m/s^2), in base axes.

        Args:
            top: what a state's `Parts` say of its nuisances.
            beta: the estimate,
            covariance: and its own.

        Returns:
            By name, as `gyro.x`: `value` and `std`.
        """
        n = len(top)
        N, Y, z = top[:, :n], top[:, n:-1], top[:, -1]
        y, tangent = linear_sets_at(self.sets, beta)
        x = solve_triangular(N, z - Y @ y)
        J = Y @ tangent[:-1].T
        spread = np.hstack([np.eye(n), J @ root_of(covariance)])
        std = np.linalg.norm(solve_triangular(N, spread), axis=1)
        _, _, b_g, b_a = self._nuisances
        names = [f"gyro.{'xyz'[axis]}" for axis in self.model.turning]
        names += [f"accelerometer.{'xyz'[axis]}" for axis in self.model.moving]
        return {
            name: {"value": float(x[k]), "std": float(std[k])}
            for name, k in zip(names, range(b_g.start, b_a.stop), strict=False)
        }

    def _fresh(
        self,
        t: float,
        R_WB: Float[np.ndarray, "1 3 3"],
        prior: Prior,
        x: Float[np.ndarray, " n"],
    ) -> Parts:
        """Nothing is known but the prior, and the nuisances hardly at all."""
        h, v, b_g, b_a = self._nuisances
        std = np.empty(x.size)
        std[h] = WIDE * max(float(np.linalg.norm(x[h])), 1.0)
        std[v] = FASTEST
        std[b_g], std[b_a] = self.noise.gyro_bias, self.noise.accelerometer_bias
        y = self.sets.pi_of_beta.shape[1] + self.sets.sigmas
        return Parts(
            t=np.array([t]),
            w=np.full(3, np.nan),
            R_WB=R_WB,
            top=np.hstack(
                [np.diag(1 / std), np.zeros((x.size, y)), (x / std)[:, None]]
            ),
            R_z=np.zeros((y, y + 1)),
            beta=prior.beta,
            root=prior.root,
            nuisances=x.copy(),
            prior=prior,
        )

    def step(self, state: State, sample: Sample) -> tuple[State, Info]:
        """Take one sample in.

        One that is not complete, or not later than the last one, leaves the state as
        it is; so does one whose rate is the last one's to the last digit: that is how
        a gyro dies, or how a row is written twice.
        """
        model, noise, sets = self._plain
        packed, info = compiled.step(
            model, noise, sets, *state, sample.t, sample.packed
        )
        return State(state.sizes, packed), Info(*info)

    def gathered(
        self,
        state: State,
        t: Float[np.ndarray, " n"],
        samples: Float[np.ndarray, "n all"],
    ) -> tuple[State, float, int]:
        """Take many samples in, all linearised about the estimate, which stays.

        Args:
            state: before.
            t: of the samples, s.
            samples: packed.

        Returns:
            The state after the last one, with the estimate and the nuisances of before;
            the squared residuals of the equations, which are of unit variance; and how
            many equations these are.
        """
        model, noise, _ = self._plain
        packed, squares, rows = compiled.gather(model, noise, *state, t, samples)
        return State(state.sizes, packed), squares, rows

    @cached_property
    def _plain(self) -> tuple:
        """Numba takes tuples without names in a fourth of the time."""
        return plain(self.model), plain(self.noise), plain(self.sets)
