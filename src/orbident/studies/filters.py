"""The low-pass filters of a study: cut off where the first recording's spectra say."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.cut_off import CutOff, choose_cut_off
from orbident.preprocessing.low_pass import low_pass
from orbident.preprocessing.rates import spline_rates
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

Columns = dict[str, Float[np.ndarray, " n"]]


class Filtered(NamedTuple):
    """A position and its rate, both without their noise."""

    x: Float[np.ndarray, " n"]
    rate: Float[np.ndarray, " n"]


@dataclass(frozen=True)
class Filters:
    """Butterworth filters, each with the cut-off of the first samples it saw.

    As the paper does it (Section 5.3), whose cut-offs were chosen once from FFTs.
    """

    cut_offs: dict[str, CutOff] = field(default_factory=dict)
    """Cut-offs of the filters, by signal."""

    def smooth(
        self, t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], name: str
    ) -> Float[np.ndarray, " n"]:
        """Samples without their noise.

        Args:
            t: times, evenly spaced, s.
            x: any unit, without gaps.
            name: of the signal.

        Raises:
            InputError: there are gaps, or the samples are not evenly spaced.
        """
        if name not in self.cut_offs:
            self.cut_offs[name] = choose_cut_off(t, x, name=name)
        cut_off = self.cut_offs[name].frequency
        return low_pass(t, x[:, None], cut_off, name=name)[:, 0]

    def with_rate(
        self, t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], name: str
    ) -> Filtered:
        """Filtered, differentiated, and filtered again.

        With the position's cut-off both times: noise is white, and so told from the
        signal, only before it is differentiated.
        """
        smooth = self.smooth(t, x, name)
        return Filtered(smooth, self.smooth(t, spline_rates(t, smooth), name))

    def joints_and_wheels(self, robot: Robot, recording: Recording) -> Columns:
        """Positions and rates of joints, and speeds of wheels, from their encoders.

        Raises:
            InputError: a column is missing or has gaps, or the samples are not evenly
                spaced.
        """
        t, columns = recording.t, {}
        for name in robot.joint_names:
            position = f"joint.{name}.position"
            joint = self.with_rate(t, recording.column(position), position)
            columns[position] = joint.x
            columns[f"joint.{name}.velocity"] = joint.rate
        for name in robot.wheel_names:
            angle = f"wheel.{name}.position"
            wheel = self.with_rate(t, recording.column(angle), angle)
            columns[f"wheel.{name}.speed"] = wheel.rate
        return columns
