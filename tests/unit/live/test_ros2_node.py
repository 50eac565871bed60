"""The node of ROS 2 in `examples`, on messages of a flight and a stub of rclpy."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

import sys
from collections.abc import Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from examples import identifying
from live_streams import NAME, VELOCITY_STD, robot, samples
from mujoco_model import mujoco_model
from scipy.spatial.transform import Rotation

from orbident.model.minimal_sets import minimal_sets
from orbident.robot.parameters import cross_matrix, inertia_about_com, inertia_matrix

PARAMETERS = {"robot": NAME, "velocity_std": VELOCITY_STD, "every": 5.0}


class Message(SimpleNamespace):
    """A message whose parts are made when they are named."""

    def __getattr__(self, name: str) -> "Message":
        if name.startswith("__"):
            raise AttributeError(name)
        setattr(self, name, [] if name == "dim" else Message())
        return getattr(self, name)


class Node:
    """What the node uses of `rclpy.node.Node`."""

    def __init__(self, name: str) -> None:
        self.published: dict[str, list[Any]] = {}
        assert name == "orbident"

    def declare_parameter(self, name: str, value: Any) -> Any:
        return SimpleNamespace(value=PARAMETERS.get(name, value))

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        kept = self.published.setdefault(topic, [])
        return SimpleNamespace(publish=kept.append)


class Synchronizer:
    """Hands what comes to its callback."""

    def __init__(self, subscribers: list[str], queue: int, slop: float) -> None:
        assert subscribers == ["imu", "joint_states", "odom"]

    def registerCallback(self, callback: Any) -> None:
        self.callback = callback


STUBS: dict[str, dict[str, Any]] = {
    "rclpy": {},
    "rclpy.node": {"Node": Node},
    "message_filters": {
        "Subscriber": lambda node, kind, topic: topic,
        "ApproximateTimeSynchronizer": Synchronizer,
    },
    "geometry_msgs.msg": {"InertiaStamped": Message},
    "nav_msgs.msg": {"Odometry": Message},
    "sensor_msgs.msg": {"Imu": Message, "JointState": Message},
    "std_msgs.msg": {"Float64MultiArray": Message, "MultiArrayDimension": Message},
}


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    for name, content in STUBS.items():
        stub = ModuleType(name)
        vars(stub).update(content)
        monkeypatch.setitem(sys.modules, name, stub)
        if name.endswith(".msg"):
            package = name.removesuffix(".msg")
            monkeypatch.setitem(sys.modules, package, ModuleType(package))
    return identifying("ros2")


def vector(values: np.ndarray) -> Message:
    return Message(**dict(zip("xyzw", values.tolist(), strict=False)))


def messages() -> Iterator[tuple[Message, Message, Message]]:
    """The stream of a laboratory as its drivers publish it."""
    flight = samples()
    names = [*robot().joint_names, *robot().wheel_names]
    for k, t in enumerate(flight["t"]):
        of = {name: values[k] for name, values in flight.items()}
        gyro, v_W = (
            np.array([of[f"{n}.{a}"] for a in "xyz"]) for n in ("gyro", "velocity")
        )
        x_WB = np.array([of[f"attitude.{a}"] for a in "xyzw"])
        imu = Message(orientation=vector(x_WB), angular_velocity=vector(gyro))
        ns = round(1e9 * t)
        imu.header.stamp = Message(sec=ns // 10**9, nanosec=ns % 10**9)
        position = [of.get(f"joint.{name}.position", np.nan) for name in names]
        rates = [
            of.get(f"joint.{n}.velocity", of.get(f"wheel.{n}.speed")) for n in names
        ]
        # Drivers have orders of their own.
        joints = Message(
            name=names[::-1], position=position[::-1], velocity=rates[::-1]
        )
        odometry = Message()
        odometry.twist.twist.linear = vector(Rotation.from_quat(x_WB).inv().apply(v_W))
        yield imu, joints, odometry


def test_estimates_of_a_flight(example: ModuleType):
    node = example.Identification()
    for each in messages():
        node._together.callback(*each)
    beta = minimal_sets(robot()).beta(robot().theta)
    estimates, n = node.published["estimate"], beta.size
    assert len(estimates) == 5
    rows = np.reshape(estimates[-1].data, (1 + n, n))
    assert [d.size for d in estimates[-1].layout.dim] == [1 + n, n]
    assert estimates[-1].layout.dim[0].stride == (1 + n) * n
    np.testing.assert_allclose(rows[1:], rows[1:].T, rtol=1e-9)
    # Of 18 parameters one beyond 4 deviations has a probability of 0.1 %.
    off = rows[0] - beta
    assert np.all(np.abs(off) < 4 * np.sqrt(np.diag(rows[1:])))
    q = np.array([samples()[f"joint.{j}.position"][-1] for j in robot().joint_names])

    def published(beta: np.ndarray) -> np.ndarray:
        whole = example.as_one_body(robot(), beta, q)
        I = inertia_about_com(whole)
        return np.r_[whole[0], whole[1:4] / whole[0], I[np.triu_indices(3)]]

    of = node.published["inertia"][-1].inertia
    found = [of.m, of.com.x, of.com.y, of.com.z]
    found += [of.ixx, of.ixy, of.ixz, of.iyy, of.iyz, of.izz]
    J = (
        np.column_stack([published(rows[0] + h) - found for h in 1e-4 * np.eye(n)])
        / 1e-4
    )
    std = np.sqrt(np.diag(J @ rows[1:] @ J.T))
    # Of ten numbers one beyond 4 deviations has a probability below 0.1 %.
    assert np.all(np.abs(found - published(beta)) < 4 * std)


def test_the_robot_as_one_body_in_mujoco(example: ModuleType):
    random = np.random.default_rng(2)
    model = mujoco_model(robot(), random.standard_normal((3, 3)))
    data, M = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    for q in random.standard_normal((5, 3)):
        for name, angle in zip(robot().joint_names, q, strict=True):
            data.qpos[model.joint(name).qposadr] = angle
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        whole = example.as_one_body(
            robot(), minimal_sets(robot()).beta(robot().theta), q
        )
        # The base is at the origin, unturned: its block is that of one body about S.
        expected = np.block(
            [
                [whole[0] * np.eye(3), -cross_matrix(whole[1:4])],
                [cross_matrix(whole[1:4]), inertia_matrix(whole)],
            ]
        )
        # Rounding, of a matrix of some thousand kg m^2.
        np.testing.assert_allclose(M[:6, :6], expected, rtol=0, atol=1e-9)
