"""Campaign files: which robots fly which motions, how often, and what varies."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, Field, model_validator

from orbident.choices import Method
from orbident.errors import InputError
from orbident.files.bounds import LARGEST
from orbident.files.names import first_duplicate, quoted, suggestion
from orbident.files.schema_parts import (
    MappingSchema,
    Name,
    WrongValueError,
    read_yaml_mapping,
    validated,
)
from orbident.files.text import read_text
from orbident.robot.units import quantity
from orbident.trajectories.environment import Environment

Kind = Literal["normal", "uniform", "signs"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
class Distribution:
    """A distribution about zero, unless it is uniform between other ends.

    `normal: s` has the standard deviation `s`; `uniform: [a, b]` is between `a` and
    `b`; `signs: s` is `s` or `-s`, each as often.
    """

    kind: Kind
    numbers: tuple[float, ...]

    def draw(self, random: np.random.Generator, n: int) -> Float[np.ndarray, " n"]:
        """So many independent numbers."""
        if self.kind == "uniform":
            return random.uniform(self.numbers[0], self.numbers[-1], n)
        (size,) = self.numbers
        if self.kind == "signs":
            return random.choice([-size, size], n)
        return size * random.standard_normal(n)


def drawn_from(dimension: str, largest: float = LARGEST) -> BeforeValidator:
    """Reads a distribution from a file, as `{normal: 0.1}`.

    The dimension is one of `robot.units`; no number is of a larger magnitude than
    `largest`.
    """

    def read(value: object) -> Distribution:
        if not isinstance(value, dict) or len(value) != 1:
            raise WrongValueError(
                "give one distribution with its numbers, such as {normal: 0.1}"
            )
        ((name, given),) = value.items()
        if name not in KINDS:
            known = suggestion(str(name), KINDS, "distributions")
            raise InputError(f"unknown distribution {quoted(name)}; {known}")
        numbers = _numbers(name, given, dimension)
        if max(map(abs, numbers)) > largest:
            raise WrongValueError(f"give {name} numbers of at most {largest:g}")
        return Distribution(name, numbers)

    return BeforeValidator(read)


def _numbers(kind: Kind, given: object, dimension: str) -> tuple[float, ...]:
    if kind != "uniform":
        size = quantity(given, dimension)
        if size < 0:
            raise WrongValueError(f"give {kind} a size of zero or more")
        return (size,)
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise WrongValueError("give uniform: [lower, upper]")
    low, high = (quantity(each, dimension) for each in given)
    if low > high:
        raise WrongValueError("give uniform: [lower, upper] with lower below upper")
    return low, high


SCHEMA = "orbident/campaign/1"

PAPER = "paper"
"""Instead of a trajectory file: the exciting motion of the paper for that robot."""

FILES = 200
"""Files of a campaign that does not say how many runs each has: enough that workers
are done at nearly the same time."""

FEWEST, MOST = 5, 100
"""Runs of such a file: writing one takes as long as a tenth of a run, and of 100 runs
at a quarter of a second a fault loses half a minute."""

LARGEST_LOGARITHM = 10.0
"""Largest deviation of `x` in factors `e^x` of masses or noises: no draw overflows."""

DrawnShare = Annotated[Distribution | None, drawn_from("share")]
DrawnLogarithm = Annotated[Distribution | None, drawn_from("share", LARGEST_LOGARITHM)]
DrawnAngle = Annotated[Distribution | None, drawn_from("angle")]
DrawnAngularRate = Annotated[Distribution | None, drawn_from("angular rate")]
DrawnSpeed = Annotated[Distribution | None, drawn_from("speed")]


class RobotEntry(MappingSchema):
    """A robot, and the motion from which it is identified."""

    robot: Name
    """A bundled name, a URDF or a robot file; files are relative to the campaign's."""
    trajectory: Name = PAPER
    environment: Environment | None = None
    """What acts from outside, instead of the trajectory file's."""


class InitialEntry(MappingSchema):
    """How the state at the start differs from the trajectory's, in each axis."""

    angular_velocity: DrawnAngularRate = None
    velocity: DrawnSpeed = None
    attitude: DrawnAngle = None
    wheel_speed: DrawnAngularRate = None


class Disperse(MappingSchema):
    """What varies from run to run; what is absent is as the files say."""

    inertia: DrawnLogarithm = None
    """How mass, CM and inertia about the CM of each body vary, relative to CAD."""
    instruments: DrawnShare = None
    """Errors of instruments and of geometry, in the robot file's tolerances."""
    noise: DrawnLogarithm = None
    """How the sizes of each sensor's noise vary, relative to the declared ones."""
    initial: InitialEntry = InitialEntry()


class Spec(MappingSchema):
    """A campaign file, `schema: orbident/campaign/1`."""

    schema_: Literal["orbident/campaign/1"] = Field(alias="schema")
    robots: tuple[RobotEntry, ...]
    """Taken in turn: run `k` flies robot `k` modulo their number."""
    methods: tuple[Method, ...] = ("maximum-likelihood",)
    runs: Annotated[int, Field(ge=1, le=10_000_000, strict=True)]
    entropy: Annotated[int, Field(ge=0, lt=2**64, strict=True)] = 0
    """Run `k` draws from `SeedSequence(entropy, spawn_key=(k,))`."""
    chunk: Annotated[int, Field(ge=1, le=10_000, strict=True)] | None = None
    """Runs in one file: what is computed again at most after a fault."""
    disperse: Disperse = Disperse()

    @property
    def chunks(self) -> tuple[range, ...]:
        """The runs of each file."""
        size = self.chunk or min(max(self.runs // FILES, FEWEST), MOST)
        return tuple(
            range(k, min(k + size, self.runs)) for k in range(0, self.runs, size)
        )

    @model_validator(mode="after")
    def _complete(self) -> "Spec":
        for name, given in (("robots", self.robots), ("methods", self.methods)):
            if not given:
                raise InputError(f"{name}: found none; give one or more")
        twice = first_duplicate(self.methods)
        if twice is not None:
            raise InputError(f"methods: '{twice}' is given twice; keep one")
        return self


class SpecFile(NamedTuple):
    """A campaign file as it was read."""

    spec: Spec
    document: dict[str, Any]
    path: Path


def load_spec(path: str | os.PathLike[str]) -> SpecFile:
    """Read a campaign file; the files that it names are not opened.

    Raises:
        InputError: the file is missing, not YAML, has a key twice, an unknown key, an
            unknown distribution or method, or a value that a campaign cannot have.
    """
    path, text = Path(path), read_text(Path(path))
    document = read_yaml_mapping(text, str(path), SCHEMA)
    return SpecFile(validated(Spec, document, str(path), text), document, path)
