"""A robot whose joints are moved by hand, and whose base answers."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Joint, Robot
from orbident.scene.reaction import BasePose, reaction
from orbident.scene.replay import MotionHistory, centroidal_momentum, placed
from orbident.scene.scene import Scene
from orbident.viewer.stage import TOTAL, DrawnRobot, Floor, heading

FREE = np.pi
"""How far a slider goes where the joint has no stops, rad or m."""
UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])


class SlidersPage:
    """A slider for each joint; the momentum stays zero."""

    def __init__(self, server: Any, scene: Scene, model: Robot, title: str):
        """Show the robot with its joints at zero, or as near as they get.

        Args:
            server: viser's, with an empty page.
            scene: of the robot.
            model: the same robot, with the inertia that decides.
            title: what is shown, in words.
        """
        self._scene, self._model = scene, model
        self._robot = DrawnRobot(server, "/robot", scene)
        server.scene.add_icosphere("/cm", 0.03 * scene.size, color=TOTAL)
        heading(server, title, "Floating free without momentum, the CM at rest.")
        self._answer = server.gui.add_html("")
        self._sliders = [_slider(server.gui, joint) for joint in scene.robot.joints]
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


def _slider(gui: Any, joint: Joint) -> Any:
    unit = "rad" if joint.kind == "revolute" else "m"
    return gui.add_slider(f"{joint.name}, {unit}", *_range(joint))
