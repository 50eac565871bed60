"""What is identified without the samples that are no measurement."""

from collections.abc import Callable

import numpy as np
import pytest
from clean_recordings import clean_space
from random_motions import random_motion
from scipy.spatial.transform import Rotation

import orbident as oi
from orbident.recordings.recording import Recording

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 5))]

FARTHEST = 4.0
"""Deviations: one of 10,000 is farther off, and there are 15 parameters and 65 runs."""

Change = Callable[[Recording], Recording]


def rows(which: slice | list[int], **values: float) -> Change:
    def change(recording: Recording) -> Recording:
        new = {}
        for name, value in values.items():
            column = name.replace("__", ".")
            new[column] = recording.columns[column].copy()
            new[column][which] = value
        return recording.with_columns(new)

    return change


def columns(heads: tuple[str, ...], f: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda recording: recording.with_columns(
        {n: f(x) for n, x in recording.columns.items() if n.startswith(heads)}
    )


def held(x: np.ndarray, step: int) -> np.ndarray:
    return x[np.arange(x.size) // step * step]


def frozen(x: np.ndarray) -> np.ndarray:
    return np.concatenate([x[:300], np.full(20, x[300]), x[320:]])


def clipped(part: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda x: np.clip(x, *(part * np.abs(x).max() * np.array([-1, 1])))


def with_rates(f: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Change:
    def change(recording: Recording) -> Recording:
        positions = {
            name.replace("position", "velocity"): f(x, np.gradient(x, recording.t))
            for name, x in recording.columns.items()
            if name.startswith("joint.")
        }
        return recording.with_columns(positions)

    return change


def lone_gyro(recording: Recording) -> Recording:
    """Without attitude, so that the inertial axes are those of the base at first."""
    robot = oi.load_robot("paper-spatial")
    first = random_motion(robot, 1, 80.0, 100.0, "turning").initial.attitude
    p = Rotation.from_quat(first).inv().apply(recording.vector("position"))
    kept = {n: x for n, x in recording.columns.items() if "attitude" not in n}
    kept |= {f"position.{axis}": x for axis, x in zip("xyz", p.T, strict=True)}
    change = rows([0, 1, 100, 101, 400, -1], gyro__x=-9999, gyro__y=-9999)
    return change(Recording(recording.t, kept))


NO_TURN = dict.fromkeys(("attitude__x", "attitude__y", "attitude__z"), 0.0)
NOWHERE = dict.fromkeys(("position__x", "position__y", "position__z"), 0.0)
LOST = slice(200, 210)
KINDS: dict[str, tuple[Change, str]] = {
    "zeros": (rows(LOST, attitude__w=0, **NO_TURN), "quaternions of zeros"),
    "identity": (
        rows(LOST, attitude__w=1, **NO_TURN, **NOWHERE),
        "position: 10 samples of a frozen sensor",
    ),
    "9999999": (rows(LOST, position__y=9999999), "impossible value 9999999"),
    "frozen": (
        columns(("attitude", "position"), frozen),
        "attitude: 20 samples of a frozen sensor",
    ),
    "held poses": (
        columns(("attitude", "position"), lambda x: held(x, 2)),
        "attitude: 400 repeats of the sample before",
    ),
    "held rows": (columns(("",), lambda x: held(x, 2)), "rows: 400 repeats"),
    "held joints": (
        columns(("joint",), lambda x: held(x, 5)),
        "joint.joint2.position: 640 repeats",
    ),
    "saturated": (columns(("gyro",), clipped(0.7)), "samples saturated at +-"),
    "a little": (columns(("gyro.x",), clipped(0.95)), "samples saturated at 0.09"),
    "lone gyro": (lone_gyro, "gyro: 6 samples with the impossible value -9999"),
    "wrapped": (
        columns(("joint",), lambda x: x % (2 * np.pi)),
        "column 'joint.joint1.position' leaps by a turn",
    ),
    "motor": (with_rates(lambda q, v: 160 * v), "it is 160 times that; it"),
    "late": (
        with_rates(lambda q, v: 10 * np.diff(q, prepend=q[0])),
        "it is 0.05 s late",
    ),
}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_identified_is_true(kind: str, seed: int):
    clean = clean_space(seed)
    change, words = KINDS[kind]
    result = oi.identify(clean.robot, change(clean.recording))
    assert any(words in note for note in result.notes), result.notes
    assert result.status == "ok"
    assert abs(result.mass.value - 1110.0) < 3.0 * result.mass.std
    assert np.abs(clean.z(result)).max() < FARTHEST
