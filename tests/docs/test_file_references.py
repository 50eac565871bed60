"""The references of the robot file and of the recording leave nothing out."""

import re
import typing
from collections.abc import Iterator
from dataclasses import is_dataclass

import pytest
from pages import ROOT
from pydantic import BaseModel

from orbident.choices import DisturbanceGroup
from orbident.recordings.columns import (
    OF_PARTS,
    VECTORS,
    is_known,
)
from orbident.robot.schema import RobotFile
from orbident.robot.sensor_schema import SUITES
from orbident.robot.units import UNITS

ROBOT_FILE = (ROOT / "docs/robot-file.md").read_text(encoding="utf-8")
RECORDING = (ROOT / "docs/recording.md").read_text(encoding="utf-8")


def code(page: str) -> str:
    """What stands in backticks in the page's text, its blocks left out."""
    text = re.sub(r"^```.*?^```$", "", page, flags=re.MULTILINE | re.DOTALL)
    return "\n".join(re.findall(r"`([^`\n]+)`", text))


def keys(schema: type) -> Iterator[str]:
    """The keys of a file, those of its sections too."""
    if not issubclass(schema, BaseModel):
        yield from schema.__annotations__
        return
    for name, field in schema.model_fields.items():
        yield field.alias or name
        for section in sections(field.annotation):
            yield from keys(section)


def sections(annotation: object) -> Iterator[type]:
    """Models, dataclasses and named tuples."""
    if isinstance(annotation, type) and (
        issubclass(annotation, BaseModel)
        or is_dataclass(annotation)
        or hasattr(annotation, "_fields")
    ):
        yield annotation
    for part in typing.get_args(annotation):
        yield from sections(part)


def test_keys_are_those_of_all_sections():
    found = set(keys(RobotFile))
    # One of each section and depth.
    assert {"schema", "joint", "alpha", "drop_out", "markov_std", "clocks"} <= found
    assert {"angle", "thrust", "com_on_axis", "torque", "direction"} <= found


@pytest.mark.parametrize("key", sorted(set(keys(RobotFile))))
def test_every_key_of_a_robot_file_is_explained(key: str):
    assert re.search(rf"(?<!\w){key}(?!\w)", code(ROBOT_FILE))


def test_every_name_that_a_robot_file_may_hold_is_there():
    written = code(ROBOT_FILE).replace(" ", "")
    for name in (*DisturbanceGroup, *SUITES):
        assert name in written
    for dimension in (
        *("angle", "length", "mass", "inertia", "time", "frequency", "angular rate"),
        *("acceleration", "angle random walk", "velocity random walk", "share"),
        "length random walk",
    ):
        for unit in UNITS[dimension]:
            assert unit in written.split("\n"), (dimension, unit)


def test_every_column_of_a_recording_is_explained():
    lines = code(RECORDING).split("\n")
    for part, names in OF_PARTS.items():
        for name in names:
            assert f"{part}.NAME.{name}" in lines
    for name, (axes, _) in VECTORS.items():
        row = re.search(rf"^\| `{name}\.x`(.*?)\|", RECORDING, re.MULTILINE)
        assert row is not None, name
        assert re.findall(r"`\.(\w)`", row[1]) == list(axes[1:])


def test_every_column_that_is_explained_is_known():
    for name in re.findall(r"^\| `([\w.]+)`", RECORDING, re.MULTILINE):
        assert is_known(name), name
