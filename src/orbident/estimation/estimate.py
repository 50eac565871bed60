"""What an estimator makes of a problem: in one form, whatever the method."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float
from pydantic import AfterValidator

from orbident.estimation.base_parameters import (
    BetaEstimate,
    EstimatedParameters,
    parameters_of_beta,
)
from orbident.estimation.budget import ErrorSources
from orbident.estimation.checks import Check
from orbident.estimation.levels import ChiSquare
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.quantities import Quantity
from orbident.estimation.signals import Signals
from orbident.estimation.solution import Convergence, Shared, Solution
from orbident.estimation.unknowns import (
    CalibrationFit,
    DisturbanceFit,
    DriveFit,
    Sensitivity,
    SpringFit,
)
from orbident.files.json_parts import Keyed, NullableNumber, NumberOrNone, Unwritten
from orbident.files.schema_parts import WrongValueError
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.samples import OutsideMomentum

Progress = Callable[[float], object]
"""Is called with the fraction of the work that is done."""


class Change(NamedTuple):
    """A change that was found."""

    t: float
    """When it was found, s."""
    onset: float
    """The first sample that shows it, most likely, s."""
    statistic: float
    """What shows it, over its threshold: `g` of a filter; where output error confirms
    it, how far the robots before and after it are apart."""
    confidence: float
    """One less the probability that chance shows as much."""


class History(NamedTuple):
    """One row a sample that counted."""

    t: Float[np.ndarray, " n"]
    beta: Float[np.ndarray, "n beta"]
    std: Float[np.ndarray, "n beta"]
    pi: Float[np.ndarray, "n pi"]
    phi: Float[np.ndarray, "n phi"]
    M: Float[np.ndarray, " n"]
    nis: Float[np.ndarray, " n"]
    """Normalised innovation squared: chi-square with `dof` degrees of freedom."""
    dof: Float[np.ndarray, " n"]
    statistic: Float[np.ndarray, " n"]
    """The detector's statistic over its threshold."""
    changes: tuple[Change, ...]
    covariance: Float[np.ndarray, "beta beta"]
    """The covariance of the last `beta`."""
    determined: Bool[np.ndarray, " beta"]
    """Whether the samples, and not the prior, tell the last `beta`: without a wheel
    nothing tells the scale."""
    scale: bool
    """Whether the wheels' momentum told the scale of `pi`. Where it did not, `beta`,
    `pi` and `M` are NaN, and no change of the robot can be found."""
    declared: bool
    """Whether the noise of all sensors is, that the innovations are whitened with."""
    biases: dict[str, dict[str, float]]
    """Biases of the sensors at the end: `value` and `std`."""


class SensorFit(NamedTuple):
    """How well one sensor, or one equation, was predicted; SI."""

    rms: float
    """The root mean square of the residuals."""
    noise: float
    """Std of its white noise, as the residuals show it."""
    declared: float
    """As the robot file has it; NaN where it does not."""
    whiteness: float
    """Correlation of neighbouring residuals: 0 for white noise."""
    samples: int


class Goodness(NamedTuple):
    """The squared residuals over the noise of the sensors."""

    chi2: float
    dof: float
    """Residuals less unknowns: what `chi2` is on average."""
    declared: bool = True
    """Whether the noise is, of all that the residuals are made of."""

    @property
    def per_dof(self) -> float:
        """1 where the model and its noise are right."""
        return self.chi2 / max(self.dof, 1.0)


def _with_deviation(bias: Mapping[str, float | None]) -> Mapping[str, float | None]:
    if not {"value", "std"} <= bias.keys():
        raise WrongValueError("give a value and its std")
    return bias


Bias = Annotated[Mapping[str, NumberOrNone], AfterValidator(_with_deviation)]
"""Its `value` and `std`; SI."""


@dataclass(frozen=True, kw_only=True, repr=False)
class BesideParameters:
    """What is estimated beside the parameters: of an estimate and of its result."""

    convergence: Convergence = ()
    """The steps of the search; none for a method that solves its equations once."""
    biases: Mapping[str, Bias] = field(default_factory=dict)
    """The biases of sensors, with their standard deviations; SI."""
    calibration: Mapping[str, Keyed[CalibrationFit]] = field(default_factory=dict)
    """The errors of instruments that have a tolerance."""
    springs: Mapping[str, Keyed[SpringFit]] = field(default_factory=dict)
    """How passive joints swing, by joint."""
    drives: Mapping[str, Keyed[DriveFit]] = field(default_factory=dict)
    """What torques of joints drive beside what the joints move, by joint."""
    disturbances: Mapping[str, Keyed[DisturbanceFit]] = field(default_factory=dict)
    """What acted from outside, where the recording shows that something did."""
    allowed: Mapping[str, NullableNumber] = field(default_factory=dict)
    """How large what acts may be, by its group: the standard deviation beforehand that
    is in all deviations, SI; NaN for anything."""
    widened_by: float = 1.0
    """Deviations of the base parameters over those if nothing acted, in the mean."""
    history: Unwritten[History] = field(default=None, compare=False, repr=False)
    """How a recursive estimate came about; in a RUN it is `history.csv`."""


@dataclass(frozen=True)
class Estimate(BesideParameters):
    """The parameters, and what the residuals say of them."""

    parameters: EstimatedParameters
    """`pi`, `phi` and base parameters."""
    mass: Quantity
    """kg."""
    masses: Mapping[str, Quantity]
    """The mass by every route that was taken, the method's own last; kg."""
    rms: Mapping[str, float | None]
    """The root mean square residual of each sensor or equation; SI."""
    goodness: Goodness | None = None
    """How large all residuals are; None where the noise is estimated from them."""
    sensors: Mapping[str, SensorFit] = field(default_factory=dict)
    unexpected: tuple[str, ...] = ()
    """Groups that act more than the robot's world, or its file, says that they may."""
    rest: ChiSquare = field(default_factory=lambda: ChiSquare(0.0, 0))
    """How much more momentum was found than a robot at rest may have."""
    carried: ChiSquare = field(default_factory=lambda: ChiSquare(0.0, 0))
    """How far what passive joints carry is from what was known of it beforehand."""
    weighed: ChiSquare = field(default_factory=lambda: ChiSquare(0.0, 0))
    """How far what scales and balances said is from what the recording says."""
    sensitivity: Callable[[], Sensitivity] | None = None
    """What errors of the other instruments would do, where that is known."""
    sources: Callable[[], ErrorSources] | None = None
    """What the covariance of `beta` is made of, where that is known."""
    converged: bool = True
    settled: bool = True
    """Whether the weights of the residuals no longer changed from round to round."""
    signals: Signals = ()
    """What sensors showed and what was predicted, where sensors are what is fitted."""
    solution: Solution | None = None
    """Where the search ended, where these are what is fitted."""
    shared: Callable[[], Shared] | None = None
    """What it says to other recordings of the robot, where it can."""
    given: Callable[[], OutsideMomentum | None] = lambda: None
    """What acted from outside has given to the momenta, where something did."""
    tested: "Callable[[], Estimate] | None" = None
    """Asks this fit what acts more than it may; None where that was asked."""
    expected: "Callable[[], Estimate] | None" = None
    """The fit in which nothing acts more than it may, where that is another one."""

    @property
    def acting(self) -> set[str]:
        """The groups of what was found to act from outside."""
        return {fit.group for fit in self.disturbances.values()}


@runtime_checkable
class Estimator(Protocol):
    """A method of identification, with its options."""

    @property
    def name(self) -> str:
        """As `--method` has it."""
        ...

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Estimate the parameters of a problem.

        Args:
            problem: of a recording.
            progress: is called with the fraction of the work that is done.
        """
        ...


def estimate_of_beta(
    problem: MomentumProblem,
    beta: BetaEstimate,
    route: str,
    rms: Mapping[str, float | None],
    goodness: Goodness | None,
    disturbed: bool = False,
) -> Estimate:
    """The estimate of a method whose unknowns are the base parameters.

    Args:
        problem: of a recording.
        beta: what was found.
        route: to the mass, in words.
        rms: the root mean square residual of each sensor or equation; SI.
        goodness: how large all residuals are.
        disturbed: something was found to act, of which Eq. 32 knows nothing, as it
            knows nothing of joints that nobody measures.
    """
    mass, masses = Quantity(*beta.mass), dict[str, Quantity]()
    if not problem.samples.tracked:
        mass = Quantity(float("nan"), float("nan"))
    elif problem.linear and not disturbed:
        linear = problem.linear_mass
        masses["Eq. 32"] = Quantity(linear.value, linear.std)
    return Estimate(
        parameters=parameters_of_beta(problem.robot, problem.sets, beta),
        mass=mass,
        masses={**masses, route: mass},
        rms=rms,
        goodness=goodness,
    )


def biases_of_sensors(
    problem: MomentumProblem, biases: Mapping[str, Mapping[str, float]]
) -> dict[str, Mapping[str, float]]:
    """Without that of a base rate which is not the gyro's own."""
    if problem.samples.origins["base_rate"] is Origin.MEASURED:
        return dict(biases)
    return {name: b for name, b in biases.items() if not name.startswith("gyro")}


def rms_of_equations(problem: MomentumProblem) -> dict[str, float | None]:
    """What the linear fits leave of Eq. 24, N m s, and Eq. 31, m/s."""
    velocity = problem.fits.phi.rms if problem.samples.tracked else None
    return {"momentum": problem.fits.pi.rms, "velocity": velocity}


def whiteness(values: Float[np.ndarray, "samples axes"]) -> float:
    """Correlation of neighbouring residuals, all axes together: 0 for white noise."""
    power = np.sum(values**2)
    return float(np.sum(values[:-1] * values[1:]) / power) if power else 0.0


class Solved(NamedTuple):
    """An estimate, not yet judged."""

    problem: MomentumProblem
    hindered: list[Check]
    """What about the recording itself forbids a result."""
    estimate: Estimate
    shown: Estimate | None
    """The estimate by output error; None where nothing can be estimated, and for exact
    recordings, which need none."""
    off: float = 0.0
    """The largest difference of these two in the estimate's own deviations, which
    include it from then on."""
    work: float = 0.0
    """Samples that all this went through (`allowance.py`)."""
    label: str = ""
    """What the recording is called, where it is one of several."""
