"""What identification found: the object that all later stages are given."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Literal, TypeVar

from orbident.errors import InputError
from orbident.estimation.checks import Check, Level, worst
from orbident.estimation.estimate import Solved
from orbident.estimation.linear_fits import Fits, InitialMomentum
from orbident.estimation.parameter_table import short_table
from orbident.estimation.provided import provided
from orbident.estimation.quantities import Identified, nulled
from orbident.estimation.recursion import History
from orbident.estimation.sensitivity_table import SensitivityTable
from orbident.estimation.signals import Signals
from orbident.estimation.solution import Convergence
from orbident.estimation.unknowns import CalibrationFit, DisturbanceFit
from orbident.gaussian import NINETY_FIVE
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.preprocessing.delays import Delay
from orbident.robot.description import Robot

T = TypeVar("T")

SCHEMA = "orbident/result/2"


@dataclass(frozen=True, kw_only=True, repr=False)
class Result(Identified):
    """Everything identified from a recording, or from several as one.

    Of several, the names of what is a recording's own begin with its name: `second
    flight: gyro.x`.

    It can be copied, pickled and sent from one process to another. That computes what
    else is computed when it is asked for; a refused result then begins with its causes.
    """

    robot: Robot
    method: str
    initial_momentum: InitialMomentum
    checks: tuple[Check, ...]
    """Every rule of acceptance, and how the result fares under it."""
    notes: tuple[str, ...] = ()
    """What was done to the recording, and what its readers remarked."""
    diagnostics: Identified | None = field(default=None, repr=False)
    """What was estimated where the result is refused: for a look, not for use."""
    condition_number: dict[str, float]
    residual: dict[str, Any]
    biases: Mapping[str, Mapping[str, float]]
    """Biases of sensors, with their standard deviations; SI."""
    calibration: Mapping[str, CalibrationFit] = field(default_factory=dict)
    """The errors of instruments that have a tolerance."""
    disturbances: Mapping[str, DisturbanceFit] = field(default_factory=dict)
    """What acted from outside, where the recording shows that something did."""
    sensitivity: Callable[[], SensitivityTable | None] = field(
        default=lambda: None, compare=False, repr=False
    )
    """What errors of the other instruments would shift; None where it is not known."""
    solved: Solved | None = field(default=None, compare=False, repr=False)
    """What a refused result was judged by, in which its cause is looked for."""
    clocks: Mapping[str, Delay]
    """How far each sensor's clock is behind that of the base rate."""
    rejected: Mapping[str, Mapping[str, int]]
    """How many samples were left out, by column and reason."""
    origins: dict[str, str]
    """How rates and velocities were obtained: measured, or derived."""
    samples: int
    elapsed_s: float
    versions: dict[str, str]
    convergence: Convergence = ()
    """The steps of the search; none for a method that solves its equations once."""
    fits: Fits | None = field(default=None, compare=False, repr=False)
    """The linear fits; not kept in `result.json`."""
    history: History | None = field(default=None, compare=False, repr=False)
    """How a recursive estimate came about; in a RUN it is `history.csv`."""
    motion: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """How far and how fast all moved that was recorded."""
    input: Mapping[str, Any] = field(default_factory=dict)
    """The recording's `file` and its `sha256`, and the `seed` of a simulated one; of
    several these of each, as `recordings`."""
    signals: Callable[[], Signals] = field(default=tuple, compare=False, repr=False)
    """What was measured and predicted; in a RUN it is `signals.parquet`."""

    @property
    def level(self) -> Level:
        """May the numbers be used: the worst that any check says."""
        return worst(self.checks)

    @property
    def status(self) -> Literal["ok", "rejected"]:
        """Whether there is a result."""
        return "rejected" if self.level == "do not trust" else "ok"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What refuses the result, the notes, and what calls for care."""
        failed = [check for check in self.checks if not check.passed]
        refused = [c.words for c in failed if c.level == "do not trust"]
        careful = [c.words for c in failed if c.level != "do not trust"]
        return (*refused, *self.notes, *careful)

    def refusal(self) -> str:
        """Why the result is refused; empty where it is not."""
        refused = (c.words for c in self.checks if c.level == "do not trust")
        return next(refused, "")

    def summary(self) -> list[str]:
        """What a result says first, as lines of text for one screen.

        The mass with its 95 % interval, and the base parameters beside CAD: all, or
        those that differ most. A refused result has its reason and no numbers.
        """
        careful = " with care" if self.level == "with care" else ""
        head = (
            f"{self.robot.name}: {self.status}{careful}, {self.samples} samples, "
            f"{self.elapsed_s:.2f} s"
        )
        if self.status == "rejected":
            return [head, self.refusal()]
        M, std = self.mass.value, self.mass.std
        low, high = M - NINETY_FIVE * std, M + NINETY_FIVE * std
        mass = (
            f"mass {M:.6g} +- {std:.2g} kg by {self.method} "
            f"(95 %: {low:.6g} to {high:.6g})"
        )
        return [head, mass, "", *short_table(self.base)]

    def __getstate__(self) -> dict[str, Any]:
        """The fields, with values instead of functions that know the whole problem."""
        computed = ("sensitivity", "signals")
        return {
            **vars(self.with_causes()),
            **{name: partial(_known, getattr(self, name)()) for name in computed},
        }

    def __repr__(self) -> str:
        """The summary, and where the rest is."""
        more = "more: result.base, .pi, .phi, .mass_forms, .checks, .to_frame(), .plot"
        if self.status == "rejected":
            more = "more: result.checks, .diagnostics"
        return "\n".join([*self.summary(), more])

    def to_frame(self) -> Any:
        """The base parameters beside CAD as a `pandas.DataFrame`.

        `pi` and `phi` have a `to_frame()` of their own.

        Raises:
            MissingLibraryError: pandas is not installed.
        """
        return self.base.to_frame()

    def with_causes(self) -> "Result":
        """The result with the likely cause of a refusal as the first of its checks.

        Causes are put right one at a time and the recording is fitted again, which
        takes some seconds.
        """
        causes = () if self.solved is None else provided("causes")(self.solved)
        return replace(self, checks=(*causes, *self.checks), solved=None)

    def check_accepted(self) -> None:
        """Refuse to go on with what must not be trusted.

        Raises:
            InputError: the result is rejected.
        """
        if self.status == "rejected":
            raise InputError(
                f"the result for '{self.robot.name}' is rejected, so no model is made "
                f"of it: {self.refusal()}"
            )

    def dynamics(self) -> Dynamics:
        """`H+`, `c+` and Jacobians from `(pi, phi, M)` (Eq. 16); no CAD inertia used.

        Raises:
            InputError: the result is rejected or not complete, or no mechanism has
                such parameters.
        """
        self.check_accepted()
        return reconstructed(self.robot, self.base.values, self.base_covariance)

    @property
    def plot(self) -> Any:
        """The charts of the report as figures of matplotlib: `result.plot.mass()`.

        Raises:
            MissingLibraryError: matplotlib is not installed.
        """
        return provided("plot")(self)

    def to_pinocchio(self) -> Any:
        """The robot as a `pinocchio.Model` without gravity; each wheel is a joint.

        Its joint `root_joint`, in the frame of the base link, is a free flyer, or in
        the plane a planar joint. Its bodies have the identified parameters; where only
        sums over bodies are identified, they are as near to CAD as can be.

        Raises:
            InputError: the result is rejected or not complete, no bodies that can
                exist have its parameters, or a library is not installed.
        """
        return provided("to_pinocchio")(self)

    def to_mujoco(self) -> Any:
        """The robot as a `mujoco.MjSpec` without gravity; each wheel is a joint.

        The base floats on a free joint, or in the plane on two slides and a hinge; S
        is the site `feature_point`. Its bodies are those of `to_pinocchio()`.

        Raises:
            InputError: the result is rejected or not complete, no bodies that can
                exist have its parameters, or a library is not installed.
        """
        return provided("to_mujoco")(self)

    def to_json(self) -> dict[str, Any]:
        """The content of `result.json`."""
        table = self.sensitivity()
        return {
            "schema": SCHEMA,
            "robot": self.robot.name,
            "method": self.method,
            "initial_momentum": self.initial_momentum,
            "status": self.status,
            "level": self.level,
            "checks": [check.to_json() for check in self.checks],
            "notes": list(self.notes),
            "warnings": list(self.warnings),
            **self.parameters_to_json(),
            "diagnostics": (
                None
                if self.diagnostics is None
                else self.diagnostics.parameters_to_json()
            ),
            "condition_number": {
                k: nulled(v) for k, v in self.condition_number.items()
            },
            "residual": self.residual,
            "convergence": [
                {
                    "cost": nulled(step.cost),
                    "size": nulled(step.size),
                    "round": step.round,
                }
                for step in self.convergence
            ],
            "biases": {name: dict(bias) for name, bias in self.biases.items()},
            "calibration": {
                name: fit._asdict() for name, fit in self.calibration.items()
            },
            "disturbances": {
                name: fit._asdict() for name, fit in self.disturbances.items()
            },
            "sensitivity": None if table is None else table.to_json(),
            "clocks": {
                sensor: {
                    "late": nulled(delay.late),
                    "std": nulled(delay.std),
                    "corrected": delay.believed,
                }
                for sensor, delay in self.clocks.items()
            },
            "rejected": {name: dict(why) for name, why in self.rejected.items()},
            "origins": self.origins,
            "samples": self.samples,
            "motion": dict(self.motion),
            "input": dict(self.input),
            "elapsed_s": self.elapsed_s,
            "versions": self.versions,
        }


def _known(value: T) -> T:
    """What a function that was called already gave."""
    return value
