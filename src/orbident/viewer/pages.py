"""Pages: joints moved by hand with a base that answers, or a motion that is played."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.rotations import UNTURNED
from orbident.recordings.tables import read_recording
from orbident.robot.description import Joint, Robot
from orbident.scene.replay import (
    BasePose,
    MotionHistory,
    Replay,
    centroidal_momentum,
    inertia_ellipsoids,
    inertia_intervals,
    motion_residuals,
    placed,
    reaction,
    tips,
)
from orbident.scene.scene import Scene
from orbident.scene.shapes import CAD, IDENTIFIED
from orbident.scene.shown import to_be_shown
from orbident.viewer.server import Page
from orbident.viewer.stage import (
    TOTAL,
    Arrows,
    DrawnRobot,
    Ellipsoid,
    Floor,
    Plot,
    Trails,
    heading,
)

FREE = np.pi
"""How far a slider goes where the joint has no stops, rad or m."""


class SlidersPage:
    """A slider for each joint; the momentum stays zero."""

    def __init__(self, server: Any, scene: Scene, model: Robot, title: str):
        """Show the robot with its joints at zero, or as near as they get.

        The model is the same robot, with the inertia that decides.
        """
        self._scene, self._model = scene, model
        self._robot = DrawnRobot(server, "/robot", scene)
        server.scene.add_icosphere("/cm", 0.03 * scene.size, color=TOTAL)
        heading(server, title, "Floating free without momentum, the CM at rest.")
        self._answer = server.gui.add_html("")
        self._sliders = [
            server.gui.add_slider(f"{joint.name}, {joint.unit}", *_range(joint))
            for joint in scene.robot.joints
        ]
        self._start_again()
        Floor(server, scene, *self._poses())
        again = server.gui.add_button("Start again")
        again.on_click(lambda _: setattr(self, "_again", True))
        self._again = False

    def advance(self, seconds: float) -> None:
        """Answer what the sliders did since the last time."""
        if self._again:
            self._again = False
            self._start_again()
        q = self._at_sliders()
        if (q != self._q).any():
            self._base = reaction(self._model, self._base, self._q, q)
            self._q = q
            self._show()

    def _start_again(self) -> None:
        for slider, joint in zip(self._sliders, self._scene.robot.joints, strict=True):
            slider.value = _range(joint).start
        self._q = self._at_sliders()
        self._base = BasePose(UNTURNED, np.zeros(3))
        r_cm = centroidal_momentum(self._model, self._still()).r_cm[0]
        self._base = self._first = BasePose(UNTURNED, -r_cm)
        self._show()

    def _at_sliders(self) -> Float[np.ndarray, " joints"]:
        # The browser may send any number, one that is none included.
        pairs = zip(self._sliders, self._scene.robot.joints, strict=True)
        return np.array(
            [_range(joint).nearest(slider.value) for slider, joint in pairs]
        )

    def _still(self) -> MotionHistory:
        none = np.zeros((1, 3))
        wheels = np.zeros((1, len(self._scene.robot.wheels)))
        x_WB, r_S = self._base.x_WB[None], self._base.r_S[None]
        q = self._q[None]
        return MotionHistory(np.zeros(1), q, 0 * q, x_WB, none, r_S, none, wheels)

    def _poses(
        self,
    ) -> tuple[Float[np.ndarray, "frames 3 3"], Float[np.ndarray, "frames 3"]]:
        motion = self._still()
        poses = placed(self._scene, motion, motion.qd_rw)
        return poses.R[0], poses.p[0]

    def _show(self) -> None:
        self._robot.move_to(*self._poses())
        turned = 2 * np.arccos(min(1.0, abs(float(self._base.x_WB[3]))))
        moved = float(np.linalg.norm(self._base.r_S - self._first.r_S))
        self._answer.content = (
            '<div style="font-size:0.85em;padding:0 1.2em">Base turned by '
            f"{np.degrees(turned):.1f}&deg;, S moved by {moved:.3g} m</div>"
        )


class _Range(NamedTuple):
    low: float
    high: float
    step: float
    start: float

    def nearest(self, value: float) -> float:
        """The number inside; an end for what is no number."""
        return max(self.low, min(self.high, float(value)))


def _range(joint: Joint) -> _Range:
    """A joint's stops in few digits, inside of what the file says."""
    low, high = joint.within(FREE)
    step = 10.0 ** np.floor(np.log10((high - low) / 500))
    digits = max(0, -int(np.log10(step)))
    low = round(float(np.ceil(low / step) * step), digits)
    high = round(float(np.floor(high / step) * step), digits)
    return _Range(low, high, float(step), min(max(0.0, low), high))


MOST_TIMES = 5000
"""Kept for playing."""
SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "5", "10", "30")
FASTEST_TURN = np.pi
"""A wheel is drawn to turn no faster than this at speed 1, rad/s."""
PLOTS_EVERY = 3
"""Pictures of the robot for one of the plots, which cost more."""


class ReplayPage:
    """The measured robot, the predicted ones as ghosts, momentum, and plots."""

    def __init__(self, server: Any, scene: Scene, replay: Replay, title: str):
        """Show the first time."""
        replay = replay.thinned(MOST_TIMES)
        measured = replay.measured
        slowed = slow_motion(measured)
        self._motion, self._origins = measured, measured.r_S
        angles = measured.wheel_angles() / slowed
        at = placed(scene, measured, angles)
        self._robots = [(DrawnRobot(server, "/robot", scene), at)]
        self._ghosts: dict[str, DrawnRobot] = {}
        for name, motion, colour in (
            ("Predicted", replay.predicted, IDENTIFIED),
            ("CAD", replay.by_cad, CAD),
        ):
            if motion:
                ghost = DrawnRobot(server, f"/{name.lower()}", scene, colour)
                self._ghosts[name] = ghost
                self._robots.append((ghost, placed(scene, motion, angles)))
        found = centroidal_momentum(replay.model, measured) if replay.model else None
        if found:
            self._origins = found.r_cm
        self._stage = Floor(server, scene, at.R[0], at.p[0] - self._origins[0])
        paths, self._arrows = {"S": measured.r_S}, list[Arrows]()
        if found:
            self._arrows = [Arrows(server, found, self._stage.size)]
            paths["system CM"] = found.r_cm
        self._trails = Trails(server, paths | tips(scene.robot, at))
        self._ellipsoids = _ellipsoids(server, scene, replay)
        notes = [f"wheels are drawn {slowed:g} times slower"] if slowed > 1 else []
        heading(server, title, *notes, *replay.warnings)
        self._add_controls(server)
        panel = server.gui.add_panel()
        panel.dock_below(server.gui.main_panel)
        with panel.add_tab("Plots"):
            self._plots = _plots(server, scene.robot.joint_names, replay)
        self._playing = self._pressed = False
        self._shown = self._plotted = None
        self._pictures = 0
        self.advance(0.0)

    def _add_controls(self, server: Any) -> None:
        start, end = (round(float(t), 3) for t in self._motion.t[[0, -1]])
        gui = server.gui
        self._play = gui.add_button("Play")
        self._play.on_click(lambda _: setattr(self, "_pressed", True))
        self._time = gui.add_slider(
            "Time, s", start, end, max((end - start) / 1000, 1e-3), start
        )
        self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")
        self._loop = gui.add_checkbox("Loop", False)
        # Shut at first: on a phone the panel must leave room for the robot.
        with gui.add_folder("Show", expand_by_default=False):
            self._add_choices(gui)

    def _add_choices(self, gui: Any) -> None:
        self._follow = gui.add_checkbox("Follow", True)
        ghosts = [
            (gui.add_checkbox(name, True), ghost.show)
            for name, ghost in self._ghosts.items()
        ]
        self._named = gui.add_checkbox("Names", False)
        inertia = gui.add_checkbox(
            "Inertia",
            False,
            hint="Ellipsoids of even density with the system's mass, CM and inertia: "
            "blue as identified, red by CAD; between the blue nets lie 95 % of what "
            "each half axis of the blue one may be",
            visible=bool(self._ellipsoids),
        )
        vectors = gui.add_checkbox("Momentum", True, visible=bool(self._arrows))
        for arrows in self._arrows:
            gui.add_html(arrows.legend())
        self._traced = gui.add_checkbox("Trails", False)
        gui.add_html(self._trails.legend())
        self._switches = [
            *ghosts,
            (self._named, self._robots[0][0].show_names),
            *((inertia, each.show) for each in self._ellipsoids),
            *((vectors, each.show) for each in self._arrows),
            (self._traced, self._trails.show),
        ]

    def _toggle(self) -> None:
        self._playing = not self._playing
        if self._playing and self._time.value >= self._time.max:
            self._time.value = self._time.min
        self._play.label = "Pause" if self._playing else "Play"

    def advance(self, seconds: float) -> None:
        """Play on, and show what the controls say where that has changed."""
        if self._pressed:
            self._pressed = False
            self._toggle()
        if self._playing:
            # The browser may send any text.
            speed = float(self._speed.value) if self._speed.value in SPEEDS else 1.0
            t = self._time.value + seconds * speed
            self._time.value = round(min(t, self._time.max), 3)
            if t >= self._time.max and self._loop.value:
                self._time.value = self._time.min
            elif t >= self._time.max:
                self._toggle()
        boxes = self._follow, *(box for box, _ in self._switches)
        wanted = self._time.value, *(box.value for box in boxes)
        if wanted != self._shown:
            self._show()
            self._shown = wanted
            self._pictures += 1
        settled = not self._playing or self._pictures % PLOTS_EVERY == 0
        if settled and wanted[0] != self._plotted:
            for plot in self._plots:
                plot.move_to(wanted[0])
            self._plotted = wanted[0]

    def _show(self) -> None:
        t, shown = self._motion.t, self._time.value
        k = min(int(np.searchsorted(t, shown)), t.size - 1)
        origin = self._origins[k if self._follow.value else 0]
        self._stage.move_to(origin)
        for robot, poses in self._robots:
            robot.move_to(poses.R[k], poses.p[k] - origin)
        for each in (*self._arrows, self._trails, *self._ellipsoids):
            each.move_to(k, origin)
        for box, show in self._switches:
            show(box.value)


def _ellipsoids(server: Any, scene: Scene, replay: Replay) -> list[Ellipsoid]:
    """The system's inertia as ellipsoids, by CAD and as identified, with 95 % ends.

    There are none of a robot on a table, of which only one moment shows.
    """
    if scene.robot.motion == "planar":
        return []
    models = [("/inertia/cad", scene.robot, CAD)]
    if replay.predicted and replay.model:
        models.append(("/inertia/identified", replay.model, IDENTIFIED))
    drawn = [
        Ellipsoid(server, name, inertia_ellipsoids(model, replay.measured), colour)
        for name, model, colour in models
    ]
    if replay.model and replay.root is not None:
        ends = inertia_intervals(replay.model, replay.root, replay.measured)
        for name, end in zip(("low", "high"), ends, strict=True):
            name = f"/inertia/{name}"
            drawn.append(Ellipsoid(server, name, end, IDENTIFIED, wireframe=True))
    return drawn


def slow_motion(motion: MotionHistory) -> float:
    """How many times slower wheels turn than they did, for an eye to follow them."""
    fastest = float(np.abs(motion.qd_rw).max(initial=0.0))
    return 10.0 ** max(0, np.ceil(np.log10(max(fastest / FASTEST_TURN, 1.0))))


def _plots(server: Any, joints: Sequence[str], replay: Replay) -> list[Plot]:
    measured, predicted = replay.measured, replay.predicted
    t, xyz = measured.t, ("x", "y", "z")
    dashed = predicted and predicted.w
    plots = [Plot(server, "Base rate, rad/s", t, measured.w, xyz, dashed)]
    if replay.velocity_known:
        dashed = predicted and predicted.v_S
        title = "Velocity of S, m/s"
        plots.append(Plot(server, title, t, measured.v_S, xyz, dashed))
    if joints:
        plots.append(Plot(server, "Joints, rad or m", t, measured.q, joints))
    if predicted:
        off = motion_residuals(measured, predicted)
        if not replay.velocity_known:
            del off["position of S, m"]
        plots += [
            Plot(server, f"Residual {name}", t, x, xyz) for name, x in off.items()
        ]
    return plots


def prepared(
    named: str, recording: Path | None
) -> tuple[Callable[[Any], Page], tuple[str, ...]]:
    """The page for a robot or a RUN, which only needs a server, and warnings.

    Without a recording the joints have sliders.

    Raises:
        InputError: what is named cannot be read; the recording lacks what a replay
            needs; without a recording, a RUN does not determine a model, or a
            mass matrix is singular.
    """
    shown = to_be_shown(named)
    name, scene = shown.scene.robot.name, shown.scene
    if recording is None:
        title = name if named == name else f"{name}: {named}"
        page = partial(SlidersPage, scene=scene, model=shown.model(), title=title)
        return page, scene.warnings
    replay = shown.replay(read_recording(recording))
    page = partial(ReplayPage, scene=scene, replay=replay, title=f"{name}: {recording}")
    return page, (*scene.warnings, *replay.warnings)
