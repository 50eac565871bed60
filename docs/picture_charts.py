"""Charts of the README and of the gallery, as SVG."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from drawing import WIDTH, line, path, picture, words
from jaxtyping import Float

from orbident.estimation.identify import identify
from orbident.estimation.quantities import EstimatedSet, most_different
from orbident.estimation.result import Result
from orbident.excitation.bound import bound_of
from orbident.gaussian import NINETY_FIVE
from orbident.robot.description import Robot
from orbident.simulation.simulate import simulate
from orbident.studies.demo import DemoFlights
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

SHOWN = 9
"""Parameters, as on the first screen of `identify`."""


class Scale(NamedTuple):
    """A horizontal axis, in percent."""

    low: float
    high: float
    left: float
    right: float

    @classmethod
    def of(cls, x: np.ndarray, step: float, left: float, right: float) -> "Scale":
        """From one multiple of a step to another, with all of these between them."""
        low, high = np.floor(x.min() / step), np.ceil(x.max() / step)
        return cls(step * low, step * high, left, right)

    def at(self, x: float) -> float:
        """Where a number is seen."""
        share = (x - self.low) / (self.high - self.low)
        return self.left + (self.right - self.left) * share

    def drawn(self, top: float, bottom: float) -> Iterable[str]:
        """The axis: its ends and zero, with a line at each."""
        for x in sorted({self.low, 0.0, self.high}):
            ends = np.array([[self.at(x), top], [self.at(x), bottom]])
            yield line(ends, "grid")
            yield words(
                self.at(x), bottom + 22, f"{x:+g} %" if x else "0", "small middle"
            )


LONGEST = 26
"""Characters of a name that stand beside the axis."""


def called(base: EstimatedSet, row: int) -> str:
    """A base parameter: the first terms of its sum, as many as there is room for."""
    if base.names[row] == "M":
        return "total mass"
    terms = base.formulas[row].split(" + ")
    for k in range(len(terms), 1, -1):
        text = " + ".join([*terms[:k], *["…"] * (k < len(terms))])
        if len(text) <= LONGEST:
            return text
    return " + ".join([terms[0], *["…"] * (len(terms) > 1)])


def forest(flights: DemoFlights, result: Result) -> str:
    """Estimates and their intervals, beside CAD and, closer, beside the truth."""
    base, rows = result.base, most_different(result.base, SHOWN)
    percent = 100 / base.nominal[rows]
    off = percent * (base.values[rows] - base.nominal[rows])
    half = np.abs(percent) * NINETY_FIVE * base.std[rows]
    true = percent * (flights.true_base()[rows] - base.values[rows])
    top, high = 86.0, 30.0
    bottom = top + high * len(rows) - 8
    wide = Scale.of(np.append(off, 0.0), 10.0, 290.0, 500.0)
    near = Scale.of(np.concatenate([half, -half, true]), 0.1, 570.0, 710.0)
    title = "What one flight says, beside CAD and the truth"
    parts = [
        words(20, 32, title),
        words(wide.at(0.0), 62, "CAD", "small cad middle"),
        words(20, 62, "95 % intervals", "small found"),
        words(near.at(0.0), 62, "closer: the truth", "small middle"),
        *wide.drawn(70, bottom),
        *near.drawn(70, bottom),
        line(np.array([[wide.at(0.0), 70], [wide.at(0.0), bottom]]), "cad", 2.0),
    ]
    said = []
    for k, row in enumerate(rows):
        y = top + high * k
        what = called(base, row)
        said.append(
            f"{what}: {off[k]:+.1f} % from CAD, {true[k]:+.2f} % from the truth"
        )
        parts.append(words(20, y + 5, what, "small"))
        for scale, at in ((wide, off[k]), (near, 0.0)):
            ends = [[scale.at(at - half[k]), y], [scale.at(at + half[k]), y]]
            parts.append(line(np.array(ends), "found", 3.0))
            parts.append(
                f'<circle class="dot" cx="{scale.at(at):.1f}" cy="{y:g}" r="4"/>'
            )
        for way in (-5.0, 5.0):
            place = near.at(true[k])
            ends = np.array([[place - 5, y - way], [place + 5, y + way]])
            parts.append(line(ends, "true", 2.0))
    return picture(bottom + 40, title, "; ".join(said) + ".", parts)


COLORS = ("#2f81f7", "#d4772c", "#2da44e", "#a475f9", "#8b949e")
"""Colours of the parts of a whole; each has a contrast of 3 to 1 and more to the light
and to the dark background."""


def budget(result: Result) -> str:
    """What the variances of the parameters of `forest` are made of."""
    found, rows = result.budget(), most_different(result.base, SHOWN)
    assert found is not None
    names = [result.base.names[row] for row in rows]
    shares = 100 * found.shares[[found.parameters.index(name) for name in names]]
    order = np.argsort(-shares.mean(axis=0), kind="stable")[: len(COLORS) - 1]
    sources = [*(found.sources[k] for k in order), "all others"]
    parts = shares[:, order]
    parts = np.column_stack([parts, 100 - parts.sum(axis=1)])
    top, high, left, right = 116.0, 30.0, 290.0, 740.0
    drawn = [words(20, 32, "What the deviations of one flight are made of")]
    for k, (source, color) in enumerate(zip(sources, COLORS, strict=True)):
        x, y = 20 + 240 * (k % 3), 62 + 26 * (k // 3)
        drawn.append(_box(x, y - 13, 14, 14, color))
        drawn.append(words(x + 22, y, source, "small"))
    said = []
    for k, row in enumerate(rows):
        y, what = top + high * k, called(result.base, row)
        drawn.append(words(20, y + 5, what, "small"))
        ends = left + (right - left) / 100 * np.cumsum([0.0, *parts[k]])
        for start, end, color in zip(ends, ends[1:], COLORS, strict=False):
            drawn.append(_box(start, y - 9, end - start, 18, color))
        most = ", ".join(
            f"{source} {part:.1f} %"
            for source, part in zip(sources, parts[k], strict=True)
        )
        said.append(f"{what}: {most}")
    bottom = top + high * len(rows)
    drawn += [words(left, bottom + 12, "0", "small middle")]
    drawn += [words(right, bottom + 12, "100 % of a variance", "small right")]
    return picture(bottom + 28, "A budget of variances", "; ".join(said), drawn)


def _box(x: float, y: float, width: float, height: float, color: str) -> str:
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
        f'fill="{color}"/>'
    )


class Frame(NamedTuple):
    """Two axes; of numbers that are logarithms where an axis has decades."""

    low: tuple[float, float]
    high: tuple[float, float]
    height: float
    left: float = 90.0
    top: float = 100.0

    def at(self, x: np.ndarray, y: np.ndarray) -> Float[np.ndarray, "n 2"]:
        """Where points are seen; what is beyond the axes, at their ends."""
        share = np.column_stack([x, y]) - self.low
        share = np.clip(share / np.subtract(self.high, self.low), 0.0, 1.0)
        size = np.array([WIDTH - 20.0 - self.left, self.top - self.height])
        return np.array([self.left, self.height]) + size * share

    def drawn(
        self, x: Sequence[tuple[float, str]], y: Sequence[tuple[float, str]]
    ) -> Iterator[str]:
        """Lines of a grid, with what stands beside them."""
        for value, text in x:
            (place,) = self.at(np.array([value]), np.array([self.low[1]]))
            yield line(np.array([place, [place[0], self.top]]), "grid")
            yield words(place[0], self.height + 24, text, "small middle")
        for value, text in y:
            (place,) = self.at(np.array([self.low[0]]), np.array([value]))
            yield line(np.array([place, [WIDTH - 20.0, place[1]]]), "grid")
            yield words(self.left - 8, place[1] + 6, text, "small right")


def recursion(flights: DemoFlights) -> str:
    """The mass, sample by sample, of the demo's robot with faultless instruments."""
    robot, motion = spatial_robot(), spatial_trajectory(spatial_robot())
    flown = replace(robot, theta=flights.flown.theta)
    recording = simulate(flown, motion, noise="sensors")
    history = identify(robot, recording, "recursive").history
    assert history is not None
    t, M, std = history.t, history.M, history.std[:, 0]
    frame = Frame((0.0, 950.0), (float(np.ceil(t[-1])), 1125.0), 350.0)
    half = NINETY_FIVE * std
    low, high = frame.at(t, M - half), frame.at(t, M + half)
    ends = np.array([0.0, frame.high[0]])
    title = "The mass, sample by sample"
    said = ", ".join(
        f"{M[k]:.1f} +- {std[k]:.1f} kg after {t[k]:.0f} s"
        for k in np.searchsorted(t, [10.0, 20.0, t[-1]])
    )
    about = f"CAD: {robot.mass:.0f} kg; true: {flown.mass:.1f} kg; found: {said}."
    parts = [
        words(20, 32, title),
        words(20, 64, "CAD", "small cad"),
        words(80, 64, "found, with its 95 % interval", "small found"),
        words(350, 64, "true", "small"),
        *frame.drawn(
            [(s, f"{s:.0f} s") for s in np.arange(0.0, frame.high[0], 20.0)],
            [(kg, f"{kg:.0f} kg") for kg in (1000.0, 1050.0, 1100.0)],
        ),
        f'<path d="{path(np.vstack([low, high[::-1]])[::2])}Z" class="dot" '
        'fill-opacity="0.25"/>',
        line(frame.at(ends, np.full(2, robot.mass)), "cad", 2.0),
        line(frame.at(ends, np.full(2, flown.mass)), "true", 1.0),
        line(frame.at(t, M)[::2], "found", 2.0),
    ]
    return picture(390, title, about, parts)


SPEEDS = np.array([5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 400.0])
"""rad/s."""


def wheels(flights: DemoFlights) -> str:
    """The least deviation of the mass, by how fast the wheels turn."""
    kinds = {"cad": flights.robot, "found": spatial_robot()}
    found = {kind: _least(robot) for kind, robot in kinds.items()}
    x = np.log10(SPEEDS)
    frame = Frame((float(x[0]), -0.6), (float(x[-1]), 1.4), 350.0)
    title = "What wheels' speed is worth, and what it cannot buy"
    about = "Least deviations of the mass: " + "; ".join(
        f"{speed:.0f} rad/s: {usual:.2f} kg as usual, {noise:.2f} kg by noise and drift"
        for speed, usual, noise in zip(
            SPEEDS, found["cad"], found["found"], strict=True
        )
    )
    parts = [
        words(20, 32, title),
        words(20, 64, "usual tolerances, and what may act", "small cad"),
        words(390, 64, "noise and drift of sensors alone", "small found"),
        *frame.drawn(
            [(a, f"{s:.0f} rad/s") for a, s in zip(x[1:-1], SPEEDS[1:-1], strict=True)],
            [(np.log10(kg), f"{kg:g} kg") for kg in (0.3, 1.0, 3.0, 10.0)],
        ),
        *(line(frame.at(x, np.log10(std)), kind, 2.2) for kind, std in found.items()),
    ]
    return picture(390, title, about + ".", parts)


def _least(robot: Robot) -> Float[np.ndarray, " speeds"]:
    """The Cramér-Rao bound of the total mass on the paper's motion, kg."""
    motion, least = spatial_trajectory(robot), []
    for speed in SPEEDS:
        initial = replace(
            motion.initial, wheel_speed=dict.fromkeys(robot.wheel_names, float(speed))
        )
        bound = bound_of(robot, replace(motion, initial=initial))
        least.append(bound.parameters.base.covariance[0, 0])
    return np.sqrt(least)
