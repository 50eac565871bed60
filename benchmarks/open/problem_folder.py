"""A problem as files: a robot, recordings, and the truth where somebody knows it."""

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from math import isclose
from pathlib import Path
from typing import TypedDict

import numpy as np

from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

ROUNDING = 1e-6
"""What machines may differ by: the attitude is integrated to 1e-9 rad."""
DESCRIPTION, TRUTH = "problem.json", "truth.json"


def parameters_of(robot: Robot) -> dict[str, float]:
    """What is scored, by name: `pi_1`, ..., `phi_1`, ..., `M`."""
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    return {**named(pi, phi), "M": robot.mass}


def named(pi: np.ndarray, phi: np.ndarray) -> dict[str, float]:
    """The two minimal sets by the names that `orbident inspect` has for them."""
    sets = (("pi", pi), ("phi", phi))
    return {f"{s}_{k}": float(x) for s, xs in sets for k, x in enumerate(xs, 1)}


def digest(path: Path) -> str:
    """The SHA-256 of what a recording holds, whatever kind of file it is."""
    recording = read_recording(path)
    found = hashlib.sha256(np.ascontiguousarray(recording.t).tobytes())
    for name in sorted(recording.columns):
        # -0 is 0, and one NaN is as good as another.
        column = recording.columns[name] + 0.0
        found.update(name.encode())
        found.update(np.where(np.isnan(column), np.nan, column).tobytes())
    return found.hexdigest()


def mean_square(path: Path) -> float:
    """The mean square of all numbers of a recording, to compare machines by."""
    columns = read_recording(path).columns.values()
    return float(np.mean([np.nanmean(np.square(column)) for column in columns]))


class TrueValue(TypedDict):
    """The true value of a parameter."""

    value: float
    bound: float | None
    """Cramér-Rao; `None` where the motion does not determine it."""


@dataclass(frozen=True)
class Problem:
    """What every entry is given."""

    folder: Path

    @property
    def name(self) -> str:
        return self.folder.name

    @cached_property
    def description(self) -> dict:
        return json.loads((self.folder / DESCRIPTION).read_text())

    @cached_property
    def truth(self) -> dict[str, TrueValue]:
        """The true value of every parameter; empty where nobody knows them."""
        path = self.folder / TRUTH
        return json.loads(path.read_text()) if path.is_file() else {}

    @cached_property
    def robot(self) -> Robot:
        return load_robot(self.folder / "robot.yaml")

    def recordings(self) -> dict[str, Recording]:
        """Those to identify from."""
        names = self.description["identify"]
        return {name: read_recording(self.folder / name) for name in names}

    def unused(self) -> Recording:
        """The one to predict."""
        return read_recording(self.folder / self.description["unused"])

    def changed(self) -> list[str]:
        """Recordings that are missing, or not those that the checksums are of."""
        return [
            name
            for name, sha256 in self.description["sha256"].items()
            if not (self.folder / name).is_file()
            or digest(self.folder / name) != sha256
        ]

    def rounded_otherwise(self) -> bool:
        """Whether every recording is there and is the same, but for rounding."""
        return all(
            (self.folder / name).is_file()
            and isclose(mean_square(self.folder / name), size, rel_tol=ROUNDING)
            for name, size in self.description.get("mean_square", {}).items()
        )


def problems(folder: Path) -> list[Problem]:
    """All of a folder."""
    return [Problem(path.parent) for path in sorted(folder.glob(f"*/{DESCRIPTION}"))]
