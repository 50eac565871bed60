"""The paper's method: Eq. 24 for `pi` and Eq. 31 for `phi`, each for itself."""

from dataclasses import dataclass

from orbident.estimation.estimate import Estimate, Progress, rms_of_equations
from orbident.estimation.found import found_linear
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.quantities import Quantity


@dataclass(frozen=True)
class LeastSquares:
    """Separate linear fits, and the mass by Eq. 32.

    The deviations are those of white noise of unknown size: no bias, no drift, and
    regressors without noise.
    """

    name: str = "least-squares"

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Take the linear fits as they are."""
        mass = problem.linear_mass
        M = Quantity(mass.value, mass.std)
        progress(1.0)
        return Estimate(
            found=found_linear(problem.sets, problem.fits, mass),
            mass=M,
            masses={"Eq. 32": M},
            rms=rms_of_equations(problem),
            biases=_biases(problem),
        )


def _biases(problem: MomentumProblem) -> dict[str, dict[str, float]]:
    """That of the accelerometer, where the velocity was integrated from it."""
    if not problem.samples.biased:
        return {}
    moving, phi = problem.sets.regressors.velocity_axes, problem.fits.phi
    names = [f"accelerometer.{'xyz'[k]}" for k in moving]
    values, stds = phi.nuisances[len(moving) :], phi.nuisances_std[len(moving) :]
    return {
        name: {"value": float(value), "std": float(std)}
        for name, value, std in zip(names, values, stds, strict=True)
    }
