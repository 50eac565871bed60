"""What identification found: the object that all later stages are given."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
    InstanceOf,
    PlainSerializer,
    computed_field,
    model_serializer,
)
from typing_extensions import TypedDict

from orbident.choices import CauseSearch
from orbident.data_table import Interval
from orbident.errors import InputError
from orbident.estimation.budget import Budget, SensitivityTable
from orbident.estimation.checks import VERDICTS, Check, Level, worst
from orbident.estimation.estimate import BesideParameters, Solved
from orbident.estimation.linear_fits import Fits, InitialMomentum
from orbident.estimation.quantities import (
    EstimatedSet,
    Identified,
    fields_as,
    short_table,
)
from orbident.estimation.signals import Residual, Signals
from orbident.extras import provided
from orbident.files.json_parts import (
    Computed,
    Count,
    FiniteNumber,
    Keyed,
    NullableNumber,
    Unwritten,
    as_computed,
    held_as,
)
from orbident.model.core_robot import (
    rotor_deviations,
    rotor_parts,
    with_armatures,
)
from orbident.model.equations_of_motion import IndefiniteError
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.preprocessing.delays import Delay
from orbident.preprocessing.extent import RecordedMotion
from orbident.robot.description import NO_ROTOR, Friction, Robot

SCHEMA = "orbident/result/2"

FIRST = (
    *("schema", "robot", "method", "initial_momentum", "status", "level", "checks"),
    *("notes", "warnings", "mass", "pi", "phi", "base", "covariance", "diagnostics"),
    *("condition_number", "residual"),
)
"""What a reader of `result.json` looks for stands first in it."""

OWN = ("biases", "disturbances", "clocks", "rejected", "origins")
"""What each of several recordings has for itself, by names that then begin with its own
name."""

ROUNDING = 1e-9
"""A coefficient this small beside the largest is rounding."""


RecordingFile = TypedDict(
    "RecordingFile",
    {
        "file": str,
        "sha256": str,
        "from": FiniteNumber,
        "to": FiniteNumber,
        "seed": int | None,
    },
    total=False,
)
"""What a recording was read from, and its part that was used, s."""


class RecordingSource(RecordingFile, total=False):
    """What a result was identified from, by which command, and when (UTC)."""

    command: str
    date: str
    recordings: list[RecordingFile]


@dataclass(frozen=True, kw_only=True, repr=False)
class Result(BesideParameters, Identified):
    """Everything identified from a recording, or from several as one.

    Of several, the names of what is a recording's own begin with its name: `second
    flight: gyro.x`.

    It can be copied, pickled and sent from one process to another. That computes what
    else is computed when it is asked for; a refused result then begins with its causes.
    """

    schema: Literal["orbident/result/2"] = SCHEMA
    robot: Annotated[InstanceOf[Robot], PlainSerializer(attrgetter("name"))]
    method: str
    initial_momentum: InitialMomentum
    checks: tuple[Check, ...]
    """Every rule of acceptance, and how the result fares under it."""
    notes: tuple[str, ...] = ()
    """What was done to the recording, and what its readers remarked."""
    diagnostics: Identified | None = field(default=None, repr=False)
    """What was estimated where the result is refused: for a look, not for use."""
    condition_number: dict[str, NullableNumber]
    residual: Residual
    sensitivity: Computed[SensitivityTable | None] = field(
        default=lambda: None, compare=False, repr=False
    )
    """What errors of the other instruments would shift; None where it is not known."""
    budget: Computed[Budget | None] = field(
        default=lambda: None, compare=False, repr=False
    )
    """What the variance of each parameter is made of; None where it is not known, and
    of recordings without noise."""
    clocks: Mapping[str, Keyed[Delay]]
    """How far each sensor's clock is behind that of the base rate."""
    rejected: Mapping[str, Mapping[str, Count]]
    """How many samples were left out, by column and reason."""
    origins: Mapping[str, str]
    """How rates and velocities were obtained: measured, or derived."""
    samples: Count
    motion: RecordedMotion | None = field(default=None, repr=False)
    """How far and how fast all moved that was recorded."""
    input: Annotated[Mapping[str, Any], held_as(RecordingSource, dict, dict)] = field(
        default_factory=dict
    )
    """The recording's `file` and its `sha256`, and the `seed` of a simulated one; of
    several these of each, as `recordings`."""
    elapsed_s: FiniteNumber
    versions: dict[str, str]

    # What follows is not in `result.json`.
    solved: Unwritten[Solved] = field(default=None, compare=False, repr=False)
    """What a refused result was judged by, in which its cause is looked for."""
    fits: Unwritten[Fits] = field(default=None, compare=False, repr=False)
    """The linear fits."""
    signals: Annotated[Callable[[], Signals], Field(exclude=True)] = field(
        default=tuple, compare=False, repr=False
    )
    """What was measured and predicted; in a RUN it is `signals.parquet`."""

    def __post_init__(self) -> None:
        """Refuse the motion of another robot."""
        super().__post_init__()
        if self.motion and set(self.motion["joints"]) != {*self.robot.joint_names}:
            raise InputError("motion.joints: these are not the robot's")

    @computed_field
    @property
    def level(self) -> Level:
        """May the numbers be used: the worst that any check says."""
        return worst(self.checks)

    @computed_field
    @property
    def status(self) -> Literal["ok", "rejected"]:
        """Whether there is a result."""
        return "rejected" if self.level == "do not trust" else "ok"

    @computed_field
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

    def refusal_in_brief(self) -> list[str]:
        """What refuses the result, and why: all else is in `warnings`.

        That is its cause, where one is known, or else what was not determined.
        """
        failed = [check for check in self.checks if not check.passed]
        refused = [check for check in failed if check.level == "do not trust"]
        if refused and refused[0].name.endswith("cause"):
            return [check.words for check in refused[:2]]
        lost = [check for check in failed if check.name == "pi determined"]
        return [check.words for check in (*refused[:1], *lost)]

    def summary(self) -> list[str]:
        """What a result says first, as lines of text for one screen.

        The mass with its 95 % interval, and the base parameters beside CAD: all, or
        those that differ most. A refused result has its reason and no numbers.
        """
        head = (
            f"{self.robot.name}: {VERDICTS[self.level]}, {self.samples} samples, "
            f"{self.elapsed_s:.2f} s"
        )
        if self.status == "rejected":
            return [head, self.refusal()]
        if self.of_momentum_alone:
            alone = "pi alone, as no positions show the mass"
            return [head, alone, "", *short_table(self.pi)]
        within = Interval(self.mass.value, self.mass.std)
        mass = f"mass {self.mass!r} by {self.method} (95 %: {within})"
        return [head, mass, "", *short_table(self.base)]

    def __getstate__(self) -> dict[str, Any]:
        """The fields, with values instead of functions that know the whole problem.

        A cause that is to be kept is looked for before: `with_causes` takes seconds.
        """
        computed = ("sensitivity", "budget", "signals")
        return {
            **vars(replace(self, solved=None)),
            **{name: as_computed(getattr(self, name)()) for name in computed},
        }

    def __repr__(self) -> str:
        """The summary, and where the rest is."""
        more = "more: result.base, .pi, .phi, .mass_forms, .checks, .to_frame(), .plot"
        if self.status == "rejected":
            more = "more: result.checks, .diagnostics"
        return "\n".join([*self.summary(), more])

    def _repr_html_(self) -> str | None:
        """The report's first table, for notebooks; of a refused result its text."""
        return provided("html")(self)

    def to_frame(self) -> Any:
        """The base parameters beside CAD as a `pandas.DataFrame`.

        `pi` and `phi` have a `to_frame()` of their own.

        Raises:
            MissingLibraryError: pandas is not installed.
        """
        return self.base.to_frame()

    @property
    def links(self) -> EstimatedSet:
        """The base parameters that declared rotors are in, of the links alone.

        The rotors are taken out, and their tolerance is in the deviations, or how
        surely torques showed them.
        """
        sets, base = minimal_sets(self.robot), self.base
        robot = self._with_rotors(self.robot.rotors)
        each, off = (
            sets.base.T @ part(robot) for part in (rotor_parts, rotor_deviations)
        )
        rotors, size = each.sum(axis=1), np.abs(each).max(axis=1, initial=0.0)
        declared = dict.fromkeys(self.robot.rotors, NO_ROTOR)
        words = formulas_of(replace(self.robot, rotors=declared), sets).base
        has = np.flatnonzero(size > ROUNDING * size.max())
        return EstimatedSet(
            names=tuple(words.names[k] for k in has),
            formulas=tuple(words.formulas[k] for k in has),
            values=(base.values - rotors)[has],
            std=np.hypot(base.std, np.linalg.norm(off, axis=1))[has],
            nominal=(base.nominal - rotors)[has],
        )

    def with_causes(self, search: CauseSearch = "quick") -> "Result":
        """The result with the likely cause of a refusal as the first of its checks.

        Causes are put right one at a time and the recording is fitted again.

        Args:
            search: ends after some seconds ("quick"), or tries all, which may take a
                minute; or "none".
        """
        solved = self.solved
        if solved is None:
            return self
        found = provided("causes")(solved, search)
        causes = [one.of(solved.label) if solved.label else one for one in found]
        return replace(self, checks=(*causes, *self.checks), solved=None)

    def withheld(self) -> "Result":
        """The result without numbers: from then on they are its diagnostics."""
        whole = Identified(**fields_as(self, Identified))
        return replace(self, **vars(whole.nothing()), diagnostics=whole)

    @property
    def of_momentum_alone(self) -> bool:
        """Whether no positions were recorded, so that there is `pi` and no mass."""
        return self.status == "ok" and not np.isfinite(self.mass.value)

    def check_model(self) -> None:
        """Refuse to make a model of what must not be trusted, or of `pi` alone.

        Raises:
            InputError: the result is rejected, or has no mass.
        """
        self.check_accepted()
        if self.of_momentum_alone:
            raise InputError(
                f"the result for '{self.robot.name}' is pi alone: no model is made "
                "without the mass and phi; record position or velocity of the feature "
                "point, too"
            )

    def check_accepted(self) -> None:
        """Refuse to go on with what must not be trusted.

        Raises:
            InputError: the result is rejected.
        """
        if self.status == "rejected":
            raise InputError(
                f"the result for '{self.robot.name}' is refused, so no model is made "
                f"of it: {self.refusal()}"
            )

    def dynamics(self) -> Dynamics:
        """`H+`, `c+` and Jacobians from `(pi, phi, M)` (Eq. 16); no CAD inertia used.

        Rotors and friction are those that torques at joints showed, where they did. If
        no mechanism has these parameters, they are those of the nearest bodies that can
        exist (`Dynamics.moved`), near to CAD where nothing else decides.

        Raises:
            InputError: the result is rejected or not complete, or no bodies that can
                exist are near.
        """
        self.check_model()
        rubbed = {
            name: Friction(fit.viscous, fit.coulomb, fit.offset)
            for name, fit in self.drives.items()
        }
        robot = self._with_rotors(self.drives)
        robot = replace(robot, friction={**robot.friction, **rubbed})
        try:
            return reconstructed(robot, self.base.values, self.base_covariance)
        except IndefiniteError:
            nearest = provided("nearest_dynamics")(replace(self, robot=robot))
            if nearest is None:
                raise
            return nearest

    def _with_rotors(self, names: Collection[str]) -> Robot:
        """The robot with the rotors of some joints as torques showed them."""
        found = {name: fit[:2] for name, fit in self.drives.items() if name in names}
        return with_armatures(self.robot, found)

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

    @model_serializer(mode="wrap")
    def _first_what_is_asked_first(self, written: Any) -> dict[str, Any]:
        document = written(self)
        return {**{name: document[name] for name in FIRST}, **document}
