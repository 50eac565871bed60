"""What `result.json` must hold, so that whoever is given a result need not ask."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    model_validator,
)

from orbident.errors import InputError
from orbident.estimation.checks import Level
from orbident.estimation.signals import sensor_of
from orbident.files.schema_errors import validated
from orbident.files.schema_parts import WrongValueError

LARGEST = 1e60
"""SI. Deviations of what is hardly determined are large; the fourth power of this is
still a float64."""

MOST = 10**12
"""Samples."""


def _known(value: object) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WrongValueError("a number is expected, or null")
    if not abs(value) <= LARGEST:
        raise WrongValueError(f"a number of at most {LARGEST:g}, or null, is expected")
    return float(value)


def _std(value: object) -> float | None:
    std = _known(value)
    if std is not None and std < 0:
        raise WrongValueError("a deviation is not negative")
    return std


def _number(value: object) -> float:
    number = _known(value)
    if number is None:
        raise WrongValueError("a number is expected")
    return number


Known = Annotated[float | None, BeforeValidator(_known)]
Std = Annotated[float | None, BeforeValidator(_std)]
Number = Annotated[float, BeforeValidator(_number)]
Count = Annotated[int, Field(ge=0, le=MOST)]
Ends = Annotated[list[Number], Field(min_length=2, max_length=2)] | None


class _Part(BaseModel):
    """A mapping whose known keys are checked; a later version may have more."""

    model_config = ConfigDict(extra="ignore", strict=True)


class _Quantity(_Part):
    value: Known
    std: Std


class _Parameters(_Part):
    names: list[str]
    formulas: list[str]
    values: list[Known]
    std: list[Std]

    @model_validator(mode="after")
    def _side_by_side(self) -> "_Parameters":
        columns = self.names, self.formulas, self.values, self.std
        if len({len(column) for column in columns}) > 1:
            raise InputError("names, formulas, values and std are not of one length")
        return self


class _Routes(_Parameters):
    sigmas: list[Known]
    left_out: Count

    @model_validator(mode="after")
    def _all_compared(self) -> "_Routes":
        if len(self.sigmas) != len(self.names):
            raise InputError("names and sigmas are not of one length")
        return self


class _Mass(_Quantity):
    forms: _Routes


class _Set(_Parameters):
    nominal: list[Known]

    @model_validator(mode="after")
    def _all_nominal(self) -> "_Set":
        if len(self.nominal) != len(self.names):
            raise InputError("names and nominal are not of one length")
        return self


class _Base(_Set):
    covariance: list[list[Known]]

    @model_validator(mode="after")
    def _square(self) -> "_Base":
        size = len(self.names)
        if [len(row) for row in self.covariance] != size * [size]:
            raise InputError(f"the covariance is not {size} by {size}")
        return self


class _SensorFit(_Part):
    rms: Known
    noise: Known
    declared: Known
    whiteness: Known
    samples: Count


EQUATIONS = (
    "gyro",
    "accelerometer",
    "attitude",
    "position",
    "velocity",
    "joints",
    "momentum",
)


def _equation(name: str) -> str:
    if sensor_of(name) not in EQUATIONS:
        raise WrongValueError(f"one of {', '.join(EQUATIONS)} is expected")
    return name


_Equation = Annotated[str, AfterValidator(_equation)]
"""Name of an equation; where there are several recordings, as in `flight 2: gyro`."""


class _Residual(_Part):
    rms: dict[_Equation, Known] = Field(default_factory=dict)
    chi2_per_dof: Known = None
    sensors: dict[_Equation, _SensorFit] = Field(default_factory=dict)


class _Step(_Part):
    cost: Known
    size: Known
    round: Count


class _Calibration(_Part):
    value: Number
    std: Number
    tolerance: Number


class _Disturbance(_Part):
    group: str
    unit: str
    value: Number
    std: Number
    shift: Number


class _Sensitivity(_Part):
    parameters: list[str]
    errors: list[str]
    units: list[str]
    in_deviations: list[list[Known]]

    @model_validator(mode="after")
    def _rectangular(self) -> "_Sensitivity":
        rows, columns = len(self.parameters), len(self.errors)
        shape = [len(row) for row in self.in_deviations]
        if shape != rows * [columns] or len(self.units) != columns:
            raise InputError(f"the table is not {rows} by {columns}")
        return self


class _Clock(_Part):
    late: Known
    std: Std
    corrected: bool


class _MovedJoint(_Part):
    position: Ends
    rate: Known


class _MovedWheel(_Part):
    speed: Ends


class _MovedBase(_Part):
    rate: Known


class _Motion(_Part):
    duration: Number
    rate: Number
    joints: dict[str, _MovedJoint]
    wheels: dict[str, _MovedWheel]
    base: dict[str, _MovedBase]
    locked: list[str]


class _Check(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    name: str
    level: Level
    reason: str
    remedy: str
    statistic: Known
    limit: Known


class _Identified(_Part):
    mass: _Mass
    pi: _Set
    phi: _Set
    base: _Base
    covariance: list[list[Known]]

    @model_validator(mode="after")
    def _triangular(self) -> "_Identified":
        size = len(self.pi.names) + len(self.phi.names)
        if [len(row) for row in self.covariance] != [k + 1 for k in range(size)]:
            raise InputError(f"the covariance is no lower triangle of {size} rows")
        return self


class _Source(_Part):
    file: str = ""
    sha256: str = ""
    from_: Known = Field(default=None, alias="from")
    to: Known = None
    seed: int | None = None


class _Origin(_Source):
    recordings: list[_Source] = Field(default_factory=list)


class _Result(_Identified):
    schema_: Literal["orbident/result/2"] = Field(alias="schema")
    robot: str
    method: str
    initial_momentum: str
    status: Literal["ok", "rejected"]
    level: Level
    checks: list[_Check]
    notes: list[str]
    warnings: list[str]
    diagnostics: _Identified | None
    condition_number: dict[str, Known]
    residual: _Residual
    convergence: list[_Step] = Field(default_factory=list)
    biases: dict[str, _Quantity]
    calibration: dict[str, _Calibration]
    disturbances: dict[str, _Disturbance] = Field(default_factory=dict)
    sensitivity: _Sensitivity | None
    clocks: dict[str, _Clock]
    rejected: dict[str, dict[str, Count]]
    origins: dict[str, str]
    samples: Count
    motion: _Motion | None = None
    input: _Origin = Field(default_factory=_Origin)
    elapsed_s: Number
    versions: dict[str, str]

    @model_validator(mode="before")
    @classmethod
    def _without_empty_motion(cls, document: Any) -> Any:
        """A result that was made by hand says nothing of the motion."""
        if isinstance(document, dict) and document.get("motion") == {}:
            return {**document, "motion": None}
        return document


def check_content(document: Any, joints: tuple[str, ...], path: Path) -> None:
    """Refuse a document that is no result.

    Args:
        document: what `result.json` holds.
        joints: of the robot whose result it is.
        path: of the file, for messages.

    Raises:
        InputError: the first thing that is wrong, and how many more there are.
    """
    try:
        _check(document, joints)
    except InputError as error:
        raise InputError(
            f"{path}: is not what 'orbident identify' wrote: {error}; identify again"
        ) from None


def _check(document: Any, joints: tuple[str, ...]) -> None:
    if not isinstance(document, dict):
        raise InputError("it holds no keys and values")
    moved = validated(_Result, document, "").motion
    if moved is not None and set(moved.joints) != set(joints):
        raise InputError("motion.joints: these are not the robot's")
