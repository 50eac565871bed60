"""What was measured and what is predicted of it: what people judge by.

Of sensors maximum likelihood predicts it (`output_error/noise_scaling.py`), and of the
linear equations what is here.
"""

from typing import Annotated, NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import AfterValidator
from typing_extensions import TypedDict

from orbident.estimation.linear_fits import (
    InitialMomentum,
    batches_with_drift,
    known_momentum,
    rows_of,
)
from orbident.files.json_parts import Count, NumberOrNone
from orbident.files.schema_parts import WrongValueError
from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

SIGNAL_UNITS = {
    "gyro": "rad/s",
    "accelerometer": "m/s^2",
    "attitude": "rad",
    "position": "m",
    "velocity": "m/s",
    "joints": "rad or m",
    "torques": "N m or N",
    "momentum": "N m s",
}
"""The units of the signals that may be predicted, by sensor or equation."""


class Signal(NamedTuple):
    """One sensor, or one equation, at its own times.

    Of an attitude the measured one is the turn by which it is off the predicted one,
    which is zero: rotation vectors in base axes.
    """

    name: str
    axes: tuple[str, ...]
    units: tuple[str, ...]
    """Units of the axes."""
    t: Float[np.ndarray, " n"]
    """s."""
    measured: Float[np.ndarray, "n axes"]
    predicted: Float[np.ndarray, "n axes"]
    std: float
    """Deviation of the noise that the residuals show."""

    def __repr__(self) -> str:
        """Which axes, and how often."""
        axes = zip(self.axes, self.units, strict=True)
        named = ", ".join(f"{axis} ({unit})" for axis, unit in axes)
        return f"{self.name}: {named}; {self.t.size} samples, noise {self.std:.2g}"

    @property
    def sensor(self) -> str:
        """The name, without that of its recording where there are several."""
        return sensor_of(self.name)


def sensor_of(name: str) -> str:
    """`gyro` of `second flight: gyro`."""
    return name.rpartition(": ")[2]


Signals = tuple[Signal, ...]


def _equation(name: str) -> str:
    if sensor_of(name) not in SIGNAL_UNITS:
        raise WrongValueError(f"one of {', '.join(SIGNAL_UNITS)} is expected")
    return name


Equation = Annotated[str, AfterValidator(_equation)]
"""Name of an equation; where there are several recordings, as in `flight 2: gyro`."""


class SensorResidual(TypedDict):
    """How well a sensor, or an equation, was predicted, as `SensorFit`; SI."""

    rms: NumberOrNone
    noise: NumberOrNone
    declared: NumberOrNone
    whiteness: NumberOrNone
    samples: Count


class Residual(TypedDict, total=False):
    """What the estimate leaves of what was measured; SI."""

    rms: dict[Equation, NumberOrNone]
    """Root mean squares."""
    chi2_per_dof: NumberOrNone
    sensors: dict[Equation, SensorResidual]


def equation_signals(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
    pi: Float[np.ndarray, " pi"],
    phi: Float[np.ndarray, " phi"],
) -> Signals:
    """What the linear equations predict of momentum and velocity, base axes.

        R_0^T h_cm - A_rw qd_rw = Y pi                                     (Eq. 24)
        R_0^T (v_S - v_cm) = W phi                                         (Eq. 31)

    `h_cm`, where it is not known, and `v_cm` are those that fit best.

    Args:
        robot: that was recorded.
        sets: its minimal sets.
        samples: of the recording.
        initial_momentum: what is known of `h_cm`.
        pi: as estimated, kg m^2,
        phi: and m.
    """
    wheels, regressors = wheels_of(robot), sets.regressors
    known = known_momentum(robot, sets, samples, initial_momentum)
    turning, moving, momenta, velocities = [], [], [], []
    for batch, drift in batches_with_drift(samples):
        both = rows_of(regressors, wheels, known, batch, drift)
        n = batch.turning.size
        h, v = (np.asarray(rows).reshape(n, -1, rows.shape[-1]) for rows in both)
        turning.append(batch.turning)
        moving.append(batch.moving)
        free = h.shape[1] if known is None else 0
        momenta.append(_sides(h[batch.turning], free, pi))
        velocities.append(_sides(v[batch.moving], v.shape[2] - 1 - phi.size, phi))
    signals = []
    for name, axes, seen, sides in (
        ("momentum", regressors.momentum_axes, turning, momenta),
        ("velocity", regressors.velocity_axes, moving, velocities),
    ):
        at = np.concatenate(seen)
        if at.any():
            labels = tuple("xyz"[k] for k in axes)
            signals.append(_fitted(name, labels, samples.t[at], sides))
    return tuple(signals)


class _Sides(NamedTuple):
    """Both sides of an equation, `known = predicted + nuisances n`."""

    known: Float[np.ndarray, "n axes"]
    predicted: Float[np.ndarray, "n axes"]
    nuisances: Float[np.ndarray, "n axes free"]


def _sides(
    rows: Float[np.ndarray, "n axes columns"],
    free: int,
    parameters: Float[np.ndarray, " k"],
) -> _Sides:
    own = rows[..., free : free + parameters.size]
    return _Sides(rows[..., -1], own @ parameters, rows[..., :free])


def _fitted(
    name: str,
    axes: tuple[str, ...],
    t: Float[np.ndarray, " n"],
    batches: list[_Sides],
) -> Signal:
    """The prediction with the nuisances that fit best."""
    known, predicted, N = (
        np.concatenate(parts) for parts in zip(*batches, strict=True)
    )
    free = N.shape[-1]
    off = (known - predicted).ravel()
    n = np.linalg.lstsq(N.reshape(-1, free), off)[0] if free else np.zeros(0)
    measured = known - N @ n
    std = float(np.sqrt(np.mean((measured - predicted) ** 2)))
    units = len(axes) * (SIGNAL_UNITS[name],)
    return Signal(name, axes, units, t, measured, predicted, std)
