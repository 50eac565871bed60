import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.studies.paper_method import Filters, from_mocap, yaw_of

ROBOT = load_robot("cepheus-like")
T = np.arange(2001) / 100
YAW = 2.0 * T + 0.1 * np.sin(T)
ENCODER, ANGLE, POINT = 2e-4, 3.5e-4, 1e-4
"""The robot file's noise, rad, rad and m."""


def moved() -> Recording:
    random = np.random.default_rng(0)

    def noisy(x: np.ndarray, std: float) -> np.ndarray:
        return x + std * random.standard_normal(x.shape)

    x_WB = Rotation.from_euler("z", noisy(YAW, ANGLE)[:, None]).as_quat()
    x_WB[::3] *= -1
    columns = {
        "joint.joint1.position": noisy(np.sin(0.5 * T), ENCODER),
        "joint.joint2.position": noisy(np.cos(0.7 * T), ENCODER),
        "wheel.rw.position": noisy(-170 * T, ENCODER),
        "position.x": noisy(0.1 * np.sin(2 * T), POINT),
        "position.y": noisy(0.1 * np.cos(2 * T), POINT),
        "position.z": np.zeros(T.size),
        **{f"attitude.{k}": x_WB[:, i].copy() for i, k in enumerate("xyzw")},
    }
    return Recording(T, columns, source="r.csv")


def test_rates_of_everything():
    ready = from_mocap(ROBOT, moved(), Filters())
    for name, rate, std in (
        ("joint.joint1.velocity", 0.5 * np.cos(0.5 * T), ENCODER),
        ("joint.joint2.velocity", -0.7 * np.sin(0.7 * T), ENCODER),
        ("wheel.rw.speed", np.full(T.size, -170.0), ENCODER),
        ("gyro.z", 2.0 + 0.1 * np.cos(T), ANGLE),
        ("velocity.x", 0.2 * np.cos(2 * T), POINT),
        ("velocity.y", -0.2 * np.sin(2 * T), POINT),
    ):
        # A second's worth of samples, a hundred, averages the noise over 1 rad/s.
        error = np.sqrt(np.mean((ready.column(name) - rate) ** 2))
        assert error < 2 * std, name
    for name in ("gyro.x", "gyro.y", "velocity.z", "attitude.x", "attitude.y"):
        assert not ready.column(name).any()
    seen = yaw_of(ready.vector("attitude", "xyzw"))
    # Ten samples at least share their noise.
    assert np.std(seen - YAW) < ANGLE / 3


def test_yaw_over_full_turns():
    x_WB = Rotation.from_euler("z", YAW[:, None]).as_quat()
    x_WB[::3] *= -1
    yaw = yaw_of(x_WB)
    # Rounding of an angle of 40 rad.
    np.testing.assert_allclose(yaw - yaw[0], YAW - YAW[0], atol=1e-12)


def test_gaps_are_refused():
    recording = moved()
    columns = dict(recording.columns)
    columns["position.y"] = np.where(T == 1.0, np.nan, columns["position.y"])
    with pytest.raises(InputError, match=r"position\.y"):
        from_mocap(ROBOT, Recording(T, columns), Filters())
    del columns["wheel.rw.position"]
    columns["position.y"] = recording.columns["position.y"]
    with pytest.raises(InputError, match=r"'wheel\.rw\.position' is missing"):
        from_mocap(ROBOT, Recording(T, columns), Filters())
