"""Burns of one rigid body, whose motion SciPy integrates."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from orbident.recordings.recording import Recording

RATE = 100.0
ON, OFF = 1.0, 1.5


@dataclass(frozen=True)
class Body:
    """A body that turns at a constant rate while it is pushed."""

    joints: tuple[str, ...]
    mass: float
    force: np.ndarray = field(default_factory=lambda: np.array([0.3, -0.5, 0.0]))
    """Base axes, N, from `ON` to `OFF`."""
    p_S_cm: np.ndarray = field(default_factory=lambda: np.array([0.05, 0.12, 0.0]))
    """Base axes, m."""
    rate: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 0.1]))
    """Base axes, rad/s."""
    duration: float = 4.0

    def turning(self, rate: float) -> "Body":
        return replace(self, rate=np.array([0.0, 0.0, rate]))


def burn(body: Body, start: float = 0.3) -> Recording:
    """As ideal sensors of everything would record it; attitude `start` rad about z."""
    t = np.arange(round(body.duration * RATE) + 1) / RATE
    first = Rotation.from_rotvec([0.0, 0.0, start])

    def R_WB(t: np.ndarray) -> Rotation:
        return first * Rotation.from_rotvec(np.outer(t, body.rate))

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        push = R_WB(np.array([t])).apply(body.force)[0] / body.mass
        return np.concatenate([state[3:], push])

    # In three parts, so that no step straddles an edge of the burn.
    state = np.array([0.1, -0.2, 0.0, 0.01, 0.02, 0.0])
    coast = np.minimum(t, ON)[:, None]
    r_cm, v_cm = state[:3] + coast * state[3:], np.tile(state[3:], (t.size, 1))
    state = np.concatenate([state[:3] + ON * state[3:], state[3:]])
    pushed = solve_ivp(
        rates, (ON, OFF), state, "DOP853", dense_output=True, rtol=1e-12, atol=1e-14
    )
    later = t > ON
    during = pushed.sol(np.minimum(t[later], OFF)).T
    after = np.maximum(t[later] - OFF, 0)[:, None]
    r_cm[later], v_cm[later] = during[:, :3] + after * during[:, 3:], during[:, 3:]

    R, c = R_WB(t), body.p_S_cm
    on = ((t >= ON) & (t < OFF))[:, None]
    turning = np.cross(body.rate, np.cross(body.rate, c))
    vectors = {
        "force": on * body.force,
        "gyro": np.tile(body.rate, (t.size, 1)),
        "attitude": R.as_quat(),
        "position": r_cm - R.apply(c),
        "velocity": v_cm - R.apply(np.cross(body.rate, c)),
        "accelerometer": on * body.force / body.mass - turning,
    }
    columns = {f"joint.{name}.position": np.full(t.size, 0.7) for name in body.joints}
    for name, values in vectors.items():
        for k, axis in enumerate("xyzw"[: values.shape[1]]):
            columns[f"{name}.{axis}"] = np.ascontiguousarray(values[:, k])
    return Recording(t, columns, source="burn.csv")


def without(recording: Recording, *starts: str) -> Recording:
    """The recording but for the columns that begin so."""
    columns = {
        name: values
        for name, values in recording.columns.items()
        if not name.startswith(starts)
    }
    return Recording(recording.t, columns, source=recording.source)


def changed(recording: Recording, **vectors: np.ndarray) -> Recording:
    """The recording with some vectors replaced."""
    columns = dict(recording.columns)
    for name, values in vectors.items():
        for k, axis in enumerate("xyzw"[: values.shape[1]]):
            columns[f"{name}.{axis}"] = np.ascontiguousarray(values[:, k])
    return Recording(recording.t, columns, source=recording.source)
