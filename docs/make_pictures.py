"""The pictures of README and site, made of what `orbident demo` computes.

    python docs/make_pictures.py

`demo.svg` moves: a robot as measured, as CAD predicts it and as the identified model
does. The others are charts: `picture_charts.py`.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from drawing import WIDTH, line, path, picture, words
from jaxtyping import Float
from picture_charts import budget, forest, recursion, wheels

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.prediction import predict
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS
from orbident.scene.replay import (
    MotionHistory,
    predicted_motion,
    with_cad_values,
    with_resting_cm,
)
from orbident.scene.scene import Scene, scene_of, view_axes
from orbident.studies.demo import DemoFlights, fly_demo, turned_off

FOLDER = Path(__file__).parent / "pictures"

STEPS = 80
"""Pictures of the motion: joints turn by 20 degrees at most from one to the next."""
MOVES, HOLDS = 10.0, 2.0
"""s that the picture moves, and that it stands at the end."""

EYE = np.array([0.32, 0.56, 0.77])
"""Towards the eye, inertial axes: from there the arm's way looks widest, so that the
robot is largest."""


def pictures() -> dict[str, str]:
    """Every picture by the name of its file."""
    flights = fly_demo()
    result = identify(flights.robot, flights.first)
    return {
        "demo.svg": moving(flights, result),
        "forest.svg": forest(flights, result),
        "budget.svg": budget(result),
        "recursion.svg": recursion(flights),
        "wheels.svg": wheels(flights),
    }


def animated(attribute: str, values: Sequence[str]) -> str:
    """An attribute that takes these values one after another, again and again."""
    moves = MOVES / (MOVES + HOLDS)
    times = [*(f"{moves * k / (len(values) - 1):.4f}" for k in range(len(values))), "1"]
    return (
        f'<animate attributeName="{attribute}" dur="{MOVES + HOLDS:g}s" '
        f'repeatCount="indefinite" keyTimes="{";".join(times)}" '
        f'values="{";".join([*values, values[-1]])}"/>'
    )


class Outline(NamedTuple):
    """A robot as it is drawn, step by step."""

    faces: Float[np.ndarray, "n 6 4 3"]
    """Faces of the box around the base, corner by corner."""
    arm: Float[np.ndarray, "n points 3"]


SIDES = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4)]
SIDES += [(1, 3, 7, 5)]
"""The faces of a box whose corners are numbered as bits of z, y and x."""


def outline(scene: Scene, motion: MotionHistory, inertia: Robot) -> Outline:
    """The box of the base and the line of the arm, where the CM rests.

    Args:
        scene: of the robot, whose joints are a chain.
        motion: of it.
        inertia: the robot with the inertia that says where the CM is.
    """
    frames = with_resting_cm(scene, motion, inertia)
    base = np.vstack([shape.vertices for shape in scene.shapes if shape.frame == 0])
    ends = np.array([base.min(axis=0), base.max(axis=0)])
    corners = [
        ends[[x, y, z], range(3)] for x in (0, 1) for y in (0, 1) for z in (0, 1)
    ]
    p = frames.p
    at = p[:, :1] + np.array(corners) @ frames.R[:, 0].mT
    last = scene.robot.theta[-1]
    # The last link ends as far behind its CM as that is from its joint.
    tip = 2 * last[FIRST_MOMENT] / last[MASS]
    k = len(scene.robot.bodies)
    end = p[:, k - 1] + frames.R[:, k - 1] @ tip
    return Outline(at[:, np.array(SIDES)], np.hstack([p[:, 1:k], end[:, None]]))


def moving(flights: DemoFlights, result: Result) -> str:
    """Measured, predicted by CAD, and predicted by what is identified."""
    other, cad = flights.other, with_cad_values(result)
    scene, step = scene_of(flights.robot), (flights.other.t.size - 1) // STEPS
    found, wrong = (predicted_motion(each, other) for each in (result, cad))
    assert found.model is not None
    assert found.predicted is not None
    assert wrong.predicted is not None
    motions = {
        "seen": (found.measured, flights.flown),
        "cad": (wrong.predicted, flights.robot),
        "found": (found.predicted, found.model),
    }
    outlines = {
        name: outline(scene, MotionHistory(*(x[::step] for x in motion)), inertia)
        for name, (motion, inertia) in motions.items()
    }
    view = View.of([p for each in outlines.values() for p in each])
    parts = [robot(each, name, view) for name, each in outlines.items()]
    angles = [np.degrees(turned_off(predict(each, other))) for each in (cad, result)]
    t, title = found.measured.t, "Another flight, predicted from how its joints move"
    ends = [f"{angle[-1]:.2g}°" for angle in angles]
    about_it = (
        f"A spacecraft with an arm. After {t[-1]:.0f} s the attitude that CAD predicts "
        f"is {ends[0]} off the measured one, that of the identified model {ends[1]}."
    )
    legend = [
        words(20, 32, title),
        words(20, 64, "measured", "small"),
        words(20, 90, "predicted by CAD, which is 10 % off", "small cad"),
        words(20, 116, "predicted as identified", "small found"),
    ]
    return picture(
        520, title, about_it, [*parts, *legend, *strip(t, angles, ends, step)]
    )


class View(NamedTuple):
    """A parallel projection into the picture."""

    axes: Float[np.ndarray, "3 2"]
    scale: float
    shift: Float[np.ndarray, "2"]

    @classmethod
    def of(cls, points: Sequence[np.ndarray]) -> "View":
        """In which all of these points are seen, as large as can be."""
        # Down in an SVG.
        axes = view_axes(EYE)[:, :2] * [1, -1]
        flat = np.vstack([p.reshape(-1, 3) @ axes for p in points])
        low, high = flat.min(axis=0), flat.max(axis=0)
        room = np.array([[20.0, 40.0], [WIDTH - 20.0, 400.0]])
        scale = float(((room[1] - room[0]) / (high - low)).min())
        return cls(axes, scale, room.mean(axis=0) - scale * (low + high) / 2)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Where points are seen."""
        return self.scale * (points @ self.axes) + self.shift


def robot(shape: Outline, kind: str, view: View) -> str:
    """One robot, moving."""
    faces, arm = view.at(shape.faces), view.at(shape.arm)
    boxes = ["".join(f"{path(face)}Z" for face in each) for each in faces]
    arms = [path(each) for each in arm]
    seen = kind == "seen"
    box = f'<path class="{kind}{" face" if seen else ""}" stroke-width="1.6"'
    line = f'<path class="{kind}" stroke-width="{7 if seen else 2.5}"'
    return (
        f'<g stroke-linejoin="round" stroke-linecap="round">'
        f'{box} d="{boxes[-1]}">{animated("d", boxes)}</path>'
        f'{line} d="{arms[-1]}">{animated("d", arms)}</path></g>'
    )


def strip(
    t: Float[np.ndarray, " n"],
    angles: Sequence[Float[np.ndarray, " n"]],
    ends: Sequence[str],
    step: int,
) -> list[str]:
    """How far the attitude is off, over time, with the time that is shown."""
    left, right, top, bottom = 60.0, WIDTH - 76.0, 434.0, 484.0
    most = float(max(angle.max() for angle in angles))
    x = left + (right - left) * t / t[-1]
    parts = [
        line(np.array([[left, bottom], [right, bottom]]), "grid"),
        words(left, 510, "0", "small middle"),
        words(right, 510, f"{t[-1]:.0f} s", "small middle"),
        words(20, 418, "attitude off by", "small"),
        words(left - 8, bottom, "0°", "small right"),
    ]
    for kind, angle, end in zip(("cad", "found"), angles, ends, strict=True):
        y = bottom - (bottom - top) * angle / most
        parts.append(line(np.column_stack([x, y])[::step], kind, 2.2))
        parts.append(words(right + 8, y[-1] + 5, end, f"small {kind}"))
    ticks = [f"{each:.1f}" for each in x[::step]]
    parts.append(
        f'<line class="seen" y1="{top - 6:g}" y2="{bottom:g}" x1="{ticks[-1]}" '
        f'x2="{ticks[-1]}">{animated("x1", ticks)}{animated("x2", ticks)}</line>'
    )
    return parts


def main() -> None:
    """Write them all."""
    FOLDER.mkdir(exist_ok=True)
    for name, text in pictures().items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
