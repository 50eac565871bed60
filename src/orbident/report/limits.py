"""What no recording tells, how far this one went, and what the limits would allow."""

from collections.abc import Iterator, Mapping
from typing import Any

from orbident.data_table import DataTable, table_of
from orbident.estimation.result import Result
from orbident.model.identifiability import not_identifiable
from orbident.model.minimal_sets import minimal_sets
from orbident.report.numbers import NONE, short
from orbident.report.page import Section
from orbident.robot.description import Joint


def identifiability(result: Result) -> Section:
    """What free floating never shows of this robot."""
    sentences = not_identifiable(result.robot, minimal_sets(result.robot))
    words = tuple(f"{sentence}." for sentence in sentences)
    return Section(
        name="identifiability",
        title="What free floating cannot identify",
        words=(
            "The base parameters are all that the motion depends on. No free-floating "
            "recording, however rich, shows more of single bodies. It leaves open:",
            *words,
        )
        if words
        else ("Every parameter of every body can be identified.",),
    )


def excitation(result: Result) -> Section | None:
    """How far and how fast all moved; None for results that do not say."""
    motion = result.motion
    if not motion:
        return None
    locked = motion["locked"]
    words = [
        f"{short(motion['duration'])} s at {short(motion['rate'])} Hz. Joints "
        "that hardly move leave their parameters uncertain; use more of the range and "
        "rate."
    ]
    if locked:
        words.append(f"Never moved: {', '.join(locked)}.")
    return Section(
        name="excitation",
        title="Excitation and limits",
        words=tuple(words),
        tables=tuple(_tables(result, motion)),
    )


def _tables(result: Result, motion: Mapping[str, Any]) -> Iterator[DataTable]:
    if result.robot.joints:
        rows = (
            _joint(each, motion["joints"][each.name]) for each in result.robot.joints
        )
        head = "joint", "position", "limits", "fastest", "limit"
        yield table_of("Joints", head, rows)
    rows = (
        (name, f"{_range(wheel['speed'])} rad/s")
        for name, wheel in motion["wheels"].items()
    )
    yield table_of("Wheels", ("wheel", "speed"), rows)
    rows = (
        (axis, f"{short(base['rate'])} rad/s") for axis, base in motion["base"].items()
    )
    yield table_of("Base", ("axis", "fastest"), rows)


def _joint(joint: Joint, moved: Mapping[str, Any]) -> tuple[str, ...]:
    unit = "rad" if joint.kind == "revolute" else "m"
    return (
        joint.name,
        f"{_range(moved['position'])} {unit}",
        NONE if joint.position is None else f"{_range(joint.position)} {unit}",
        f"{short(moved['rate'])} {unit}/s",
        NONE if joint.velocity is None else f"{short(joint.velocity)} {unit}/s",
    )


def _range(ends: Any) -> str:
    if ends is None:
        return NONE
    low, high = map(short, ends)
    return low if low == high else f"{low} to {high}"
