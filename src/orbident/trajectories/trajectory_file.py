"""Trajectory files: YAML, validated, unknown keys refused."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)

from orbident.errors import InputError
from orbident.trajectories.trajectory import InitialState, Trajectory
from orbident.recordings.replacing import replacing

SCHEMA = "orbident/trajectory/1"


def _no_bool(value: object) -> object:
    # YAML reads yes and no as booleans, and pydantic those as 1 and 0.
    if isinstance(value, bool):
        raise ValueError("give a number")  # noqa: TRY004 - pydantic's contract
    return value


Number = Annotated[float, BeforeValidator(_no_bool), Field(allow_inf_nan=False)]
Vector3 = tuple[Number, Number, Number]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _State(_Strict):
    position: Number = 0.0
    velocity: Number = 0.0
    acceleration: Number = 0.0

    def row(self) -> list[float]:
        return [self.position, self.velocity, self.acceleration]


class _Joint(_Strict):
    a: list[Number] = []
    b: list[Number] = []
    start: _State = _State()
    end: _State = _State()

    @model_validator(mode="after")
    def _equally_long(self) -> "_Joint":
        if len(self.a) != len(self.b):
            raise ValueError(
                f"a has {len(self.a)} and b has {len(self.b)} entries; "
                "give one entry a harmonic in each"
            )
        return self


class _Initial(_Strict):
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)
    attitude: tuple[Number, Number, Number, Number] = (0.0, 0.0, 0.0, 1.0)
    velocity: Vector3 = (0.0, 0.0, 0.0)
    wheel_speed: dict[str, Number] = {}


class _TrajectoryFile(_Strict):
    schema_: Literal["orbident/trajectory/1"] = Field(alias="schema")
    duration: Annotated[Number, Field(gt=0)]
    joints: dict[str, _Joint]
    initial: _Initial = _Initial()
    design: dict[str, Any] | None = None


def load_trajectory(path: str | os.PathLike[str]) -> Trajectory:
    """Reads a trajectory file; missing start and end values are zero.

    Joints with fewer harmonics than others get zeros for the rest.

    Raises:
        InputError: The file is missing, not YAML, has a key twice, an unknown key, or
            a value that a trajectory cannot have.
    """
    path = Path(path)
    try:
        file = _TrajectoryFile.model_validate(read_yaml(path))
    except ValidationError as error:
        raise InputError(one_line(error, str(path))) from None
    joints = file.joints.values()
    harmonics = max((len(joint.a) for joint in joints), default=0)
    initial = file.initial
    try:
        state = InitialState(
            angular_velocity=np.array(initial.angular_velocity),
            attitude=np.array(initial.attitude),
            velocity=np.array(initial.velocity),
            wheel_speed=initial.wheel_speed,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return Trajectory(
        duration=file.duration,
        joints=tuple(file.joints),
        a=_padded([joint.a for joint in joints], harmonics),
        b=_padded([joint.b for joint in joints], harmonics),
        start=_padded([joint.start.row() for joint in joints], 3),
        end=_padded([joint.end.row() for joint in joints], 3),
        initial=state,
        design=file.design,
        source=str(path),
    )


def save_trajectory(trajectory: Trajectory, path: str | os.PathLike[str]) -> None:
    """Writes a trajectory file; loading it gives the same numbers to the bit.

    Raises:
        InputError: The folder does not exist or cannot be written to.
    """
    names = ("position", "velocity", "acceleration")
    initial = trajectory.initial
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "duration": float(trajectory.duration),
        "joints": {
            joint: {
                "a": trajectory.a[k],
                "b": trajectory.b[k],
                "start": dict(zip(names, trajectory.start[k], strict=True)),
                "end": dict(zip(names, trajectory.end[k], strict=True)),
            }
            for k, joint in enumerate(trajectory.joints)
        },
        "initial": {
            "angular_velocity": initial.angular_velocity,
            "attitude": initial.attitude,
            "velocity": initial.velocity,
            "wheel_speed": initial.wheel_speed,
        },
    }
    if trajectory.design is not None:
        document["design"] = trajectory.design
    text = yaml.safe_dump(
        _plain(document),
        sort_keys=False,
        default_flow_style=None,
        width=120,
    )
    with replacing(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8")


def read_yaml(path: Path) -> dict[Any, Any]:
    """The mapping in a YAML file.

    Raises:
        InputError: The file is missing or a folder, is not YAML in UTF-8, gives a key
            twice, or holds something else than a mapping.
    """
    try:
        document = yaml.load(path.read_text(encoding="utf-8-sig"), _UniqueKeyLoader)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise InputError(f"{path}: {line}{error.problem}; correct the YAML") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: is not YAML in UTF-8 ({reason})") from None
    if not isinstance(document, dict):
        found = "nothing" if document is None else repr(document)[:40]
        raise InputError(f"{path}: found {found}; give keys and values")
    return document


def one_line(error: ValidationError, source: str) -> str:
    """Pydantic's findings as one line: file, place, what was found, what to do."""
    first, *others = error.errors(include_url=False)
    place = "".join(
        f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"]
    ).lstrip(".")
    message = first["msg"].removeprefix("Value error, ")
    found = repr(first["input"])
    if first["type"] == "missing":
        text = "is missing; add it"
    elif first["type"] == "extra_forbidden":
        text = "is not a known key; correct or remove it"
    elif isinstance(first["input"], dict):
        text = message
    else:
        text = f"found {found if len(found) <= 60 else found[:57] + '...'}; {message}"
    more = f" (and {len(others)} more)" if others else ""
    return f"{source}: {place}: {text}{more}"


class _UniqueKeyLoader(yaml.SafeLoader):
    """Refuses a key given twice, where YAML loaders silently take the last."""

    def construct_mapping(
        self, node: yaml.MappingNode, deep: bool = False
    ) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            name = (key.tag, getattr(key, "value", None))
            if isinstance(name[1], str):
                if name in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key '{key.value}' is given twice", key.start_mark
                    )
                seen.add(name)
        return super().construct_mapping(node, deep)


def _padded(rows: list[list[float]], width: int) -> np.ndarray:
    table = np.zeros((len(rows), width))
    for k, row in enumerate(rows):
        table[k, : len(row)] = row
    return table


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as YAML's own."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value
