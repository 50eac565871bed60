"""Whether intervals of 95 % hold, over many flights of robots that are known."""

from collections.abc import Iterable
from typing import Any

import numpy as np

import orbident as oi
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

SURE, MOST = 1.96, 5.0
"""Deviations of a 95 % interval, and more than the worst of some thousand numbers."""

INSIDE = 0.91
"""Numbers of one flight are correlated: less than so many would be no chance."""


def assert_intervals_hold(
    flights: Iterable[tuple[Robot, Recording]], refused: float, **known: Any
) -> None:
    """Identify all, and print what was found.

    Args:
        flights: with the true robot of each.
        refused: part of them that may be.
        known: arguments of `identify`.
    """
    every, total = [], 0
    for robot, recording in flights:
        total += 1
        result = oi.identify(robot, recording, **known)
        if result.status != "ok":
            print(total, result.refusal(), flush=True)
            continue
        off = result.base.values - minimal_sets(robot).beta(robot.theta)
        every.append(np.abs(off / result.base.std))
        print(total, f"{np.nanmax(every[-1]):.1f}", flush=True)
    found = np.concatenate(every)
    found = found[np.isfinite(found)]
    inside = np.mean(found < SURE)
    print(f"{len(every)} of {total} accepted, {inside:.1%} of {found.size} inside,")
    print(f"worst {found.max():.1f}")
    assert total - len(every) <= refused * total
    assert inside > INSIDE
    assert found.max() < MOST
