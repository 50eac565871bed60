"""A motion to be played, with what a model predicted beside it."""

from typing import Any

import numpy as np

from orbident.scene.replay import MotionHistory, Replay, centroidal_momentum, placed
from orbident.scene.scene import Scene
from orbident.viewer.stage import Arrows, DrawnRobot, Floor, Plot, heading

MOST_TIMES = 5000
"""Kept for playing."""
SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "5", "10", "30")
FASTEST_TURN = np.pi
"""A wheel is drawn to turn no faster than this at speed 1, rad/s."""
PLOTS_EVERY = 3
"""Pictures of the robot for one of the plots, which cost more."""


class ReplayPage:
    """The measured robot, the predicted one as a ghost, momentum, and plots."""

    def __init__(self, server: Any, scene: Scene, replay: Replay, title: str):
        """Show the first time.

        Args:
            server: viser's, with an empty page.
            scene: of the robot.
            replay: what it did.
            title: what is shown, in words.
        """
        measured = replay.measured.thinned(MOST_TIMES)
        predicted = replay.predicted and replay.predicted.thinned(MOST_TIMES)
        slowed = slow_motion(measured)
        self._motion, self._origins = measured, measured.r_S
        angles = measured.wheel_angles() / slowed
        at = placed(scene, measured, angles)
        self._robots = [(DrawnRobot(server, "/robot", scene), at)]
        if predicted:
            ghost = DrawnRobot(server, "/predicted", scene, ghost=True)
            self._robots.append((ghost, placed(scene, predicted, angles)))
        found = centroidal_momentum(replay.model, measured) if replay.model else None
        if found:
            self._origins = found.r_cm
        self._stage = Floor(server, scene, at.R[0], at.p[0] - self._origins[0])
        self._arrows = found and Arrows(server, found, self._stage.size)
        notes = [f"wheels are drawn {slowed:g} times slower"] if slowed > 1 else []
        heading(server, title, *notes, *replay.warnings)
        self._add_controls(server)
        self._plots = _plots(server, scene, replay, measured, predicted)
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
        self._follow = gui.add_checkbox("Follow", True)
        self._predicted = gui.add_checkbox(
            "Predicted", True, visible=len(self._robots) > 1
        )
        self._vectors = gui.add_checkbox(
            "Momentum", True, visible=self._arrows is not None
        )
        if self._arrows:
            gui.add_html(self._arrows.legend())

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
            t = self._time.value + seconds * self._chosen_speed()
            self._time.value = round(min(t, self._time.max), 3)
            if t >= self._time.max:
                self._toggle()
        boxes = self._follow, self._predicted, self._vectors
        wanted = self._time.value, *(box.value for box in boxes)
        if wanted != self._shown:
            self._show(*wanted)
            self._shown = wanted
            self._pictures += 1
        settled = not self._playing or self._pictures % PLOTS_EVERY == 0
        if settled and wanted[0] != self._plotted:
            for plot in self._plots:
                plot.move_to(wanted[0])
            self._plotted = wanted[0]

    def _chosen_speed(self) -> float:
        # The browser may send any text.
        chosen = self._speed.value
        return float(chosen) if chosen in SPEEDS else 1.0

    def _show(self, t: float, follow: bool, predicted: bool, vectors: bool) -> None:
        k = min(int(np.searchsorted(self._motion.t, t)), self._motion.t.size - 1)
        origin = self._origins[k if follow else 0]
        self._stage.move_to(origin)
        for robot, poses in self._robots:
            robot.move_to(poses.R[k], poses.p[k] - origin)
        for ghost, _ in self._robots[1:]:
            ghost.show(predicted)
        if self._arrows:
            self._arrows.move_to(k, origin)
            self._arrows.show(vectors)


def slow_motion(motion: MotionHistory) -> float:
    """How many times slower wheels turn than they did, for an eye to follow them."""
    fastest = float(np.abs(motion.qd_rw).max(initial=0.0))
    return 10.0 ** max(0, np.ceil(np.log10(max(fastest / FASTEST_TURN, 1.0))))


def _plots(
    server: Any,
    scene: Scene,
    replay: Replay,
    measured: MotionHistory,
    predicted: MotionHistory | None,
) -> list[Plot]:
    t, xyz = measured.t, ("x", "y", "z")
    dashed = predicted and predicted.w
    plots = [Plot(server, "Base rate, rad/s", t, measured.w, xyz, dashed)]
    if replay.velocity_known:
        dashed = predicted and predicted.v_S
        title = "Velocity of S, m/s"
        plots.append(Plot(server, title, t, measured.v_S, xyz, dashed))
    joints = scene.robot.joint_names
    if joints:
        plots.append(Plot(server, "Joints, rad or m", t, measured.q, joints))
    return plots
