"""How well a recording tells parameters apart, how far it went, what none tells."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from orbident.data_table import DataTable, Numeric, table_of
from orbident.estimation.quantities import physical_names
from orbident.estimation.result import Result
from orbident.model.formulas import not_identifiable
from orbident.model.minimal_sets import minimal_sets
from orbident.report.charts import heat_map
from orbident.report.page import NONE, Chart, Section, short
from orbident.robot.description import Joint

CLOSE = 0.95
"""A correlation worth a word."""

LISTED = 8
"""Pairs in a sentence."""


def conditioning(result: Result) -> Section:
    """Condition numbers, and the correlations of the base parameters."""
    words = [
        "The condition number bounds how much noise is amplified. The raw one depends "
        "on units; the normalised one is of columns scaled to unit norm."
    ]
    names, R = correlations(result)
    charts = ()
    if names:
        words.append(_close(names, R))
        charts = (
            Chart(
                "correlations",
                "Correlations of the base parameters",
                heat_map(
                    *(names, names, R, 1.0, 480),
                    colorbar={"thickness": 10, "tickvals": [-1, 0, 1]},
                    hovertemplate="%{y}, %{x}: %{z:.3f}<extra></extra>",
                ),
            ),
        )
    else:
        words.append("No correlations: no parameter is determined.")
    condition = result.condition_number
    rows = (
        (
            f"{name} ({equation})",
            Numeric(condition.get(name)),
            Numeric(condition.get(f"{name}_normalised")),
        )
        for name, equation in (("Y", "momentum"), ("W", "velocity"))
    )
    return Section(
        name="conditioning",
        title="Condition and correlation",
        words=tuple(words),
        tables=(
            table_of("Condition numbers", ("regressor", "as it is", "scaled"), rows),
        ),
        charts=charts,
    )


def correlations(result: Result) -> tuple[list[str], np.ndarray]:
    """The base parameters that are determined, and their correlation matrix."""
    C = result.base_covariance
    std = np.sqrt(np.diag(C))
    sure = np.isfinite(std) & (std > 0)
    what = physical_names(result.base)
    names = [what[k] for k in np.flatnonzero(sure)]
    return names, (C / np.outer(std, std))[np.ix_(sure, sure)]


def _close(names: list[str], R: np.ndarray) -> str:
    pairs = np.argwhere(np.triu(np.abs(R) > CLOSE, 1))
    if not len(pairs):
        return f"No two base parameters are correlated by more than {CLOSE}."
    order = np.argsort(-np.abs(R[tuple(pairs.T)]))[:LISTED]
    listed = "; ".join(
        f"{names[i]} with {names[j]} ({short(float(R[i, j]))})" for i, j in pairs[order]
    )
    more = "; and others" if len(pairs) > LISTED else ""
    return f"Hardly distinguished (correlation): {listed}{more}."


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
    return (
        joint.name,
        f"{_range(moved['position'])} {joint.unit}",
        NONE if joint.position is None else f"{_range(joint.position)} {joint.unit}",
        f"{short(moved['rate'])} {joint.unit}/s",
        NONE if joint.velocity is None else f"{short(joint.velocity)} {joint.unit}/s",
    )


def _range(ends: Any) -> str:
    if ends is None:
        return NONE
    low, high = map(short, ends)
    return low if low == high else f"{low} to {high}"
