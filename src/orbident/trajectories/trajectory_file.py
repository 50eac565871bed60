"""Trajectory files: YAML, validated, unknown keys refused."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from pydantic import Field, model_validator

from orbident.errors import InputError
from orbident.files.bounds import MOST_RECORDINGS
from orbident.files.replacing import write_text
from orbident.files.schema_parts import (
    MappingSchema,
    Number,
    Positive,
    Vector3,
    Vector4,
    read_yaml_mapping,
    validated,
)
from orbident.files.text import read_text
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import InitialState, Trajectory

MOST_HARMONICS = 1000
"""Most harmonics of a joint. No motion needs a hundred, and a table of a thousand over
time takes 0.1 GB."""
SCHEMA = "orbident/trajectory/1"


class _State(MappingSchema):
    position: Number = 0.0
    velocity: Number = 0.0
    acceleration: Number = 0.0

    def row(self) -> list[float]:
        return [self.position, self.velocity, self.acceleration]


class _Joint(MappingSchema):
    a: tuple[Number, ...] = ()
    b: tuple[Number, ...] = ()
    start: _State = _State()
    end: _State = _State()

    @model_validator(mode="after")
    def _equally_long(self) -> "_Joint":
        if len(self.a) != len(self.b):
            raise InputError(
                f"a has {len(self.a)} and b has {len(self.b)} entries; "
                "give one entry a harmonic in each"
            )
        if len(self.a) > MOST_HARMONICS:
            raise InputError(
                f"has {len(self.a)} harmonics; give at most {MOST_HARMONICS}"
            )
        return self


class _Initial(MappingSchema):
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)
    attitude: Vector4 = (0.0, 0.0, 0.0, 1.0)
    velocity: Vector3 = (0.0, 0.0, 0.0)
    wheel_speed: dict[str, Number] = Field(default_factory=dict)


class _TrajectoryFile(MappingSchema):
    schema_: Literal["orbident/trajectory/1"] = Field(alias="schema")
    duration: Positive
    joints: dict[str, _Joint]
    initial: _Initial = _Initial()
    environment: Environment | None = None
    design: dict[str, Any] | None = None


def load_trajectory(path: str | os.PathLike[str]) -> Trajectory:
    """Reads a trajectory file; missing start and end values are zero.

    Joints with fewer harmonics than others get zeros for the rest.

    Raises:
        InputError: The file is missing, not YAML, has a key twice, an unknown key, or
            a value that a trajectory cannot have.
    """
    path, text = Path(path), read_text(Path(path))
    document = read_yaml_mapping(text, str(path), SCHEMA)
    file = validated(_TrajectoryFile, document, str(path), text)
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
        environment=file.environment,
        design=file.design,
        source=str(path),
    )


def numbered(path: Path, recordings: int) -> list[Path]:
    """Where the trajectories of so many recordings are: `a-1.yaml`, `a-2.yaml` ..

    Of one recording it is `a.yaml` itself.

    Raises:
        InputError: the path is a folder's.
    """
    if recordings == 1:
        return [path]
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give the name of a trajectory file")
    return [path.with_stem(f"{path.stem}-{k}") for k in range(1, recordings + 1)]


def load_experiment(path: Path) -> list[Trajectory]:
    """Read a trajectory file, or those of several recordings that `excite` numbered.

    Raises:
        InputError: as of `load_trajectory`, or a file is not one of several.
    """
    first = path if path.exists() else path.with_stem(f"{path.stem}-1")
    if first == path or not first.exists():
        return [load_trajectory(path)]
    recordings = (load_trajectory(first).design or {}).get("recordings")
    if not isinstance(recordings, int) or not 2 <= recordings <= MOST_RECORDINGS:
        raise InputError(
            f"{path}: no such file, and {first} is not one of several that excite "
            "--recordings made; give a trajectory file"
        )
    return [load_trajectory(each) for each in numbered(path, recordings)]


def save_trajectory(trajectory: Trajectory, path: str | os.PathLike[str]) -> None:
    """Writes a trajectory file; loading it gives the same numbers to the bit.

    Raises:
        InputError: The folder does not exist or cannot be written to.
    """
    names = ("position", "velocity", "acceleration")
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
        "initial": vars(trajectory.initial),
    }
    if trajectory.environment is not None:
        document["environment"] = trajectory.environment.model_dump(
            exclude_defaults=True
        )
    if trajectory.design is not None:
        document["design"] = trajectory.design
    text = yaml.safe_dump(
        _plain(document), sort_keys=False, default_flow_style=None, width=120
    )
    write_text(Path(path), text)


def _padded(rows: Sequence[Sequence[float]], width: int) -> np.ndarray:
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
