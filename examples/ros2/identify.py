"""A node of ROS 2 that identifies the robot while it moves, as `orbident live` does.

It hears `imu` (gyro and attitude in base axes), `joint_states` (joints and wheels by
their names) and `odom` (the velocity of S in base axes, child_frame_id the base), three
messages of one time. It publishes

- `inertia` (geometry_msgs/InertiaStamped): the whole robot as one body as its joints
  are now: its mass, the centre of mass from S, and the inertia about that centre, base
  axes; not before a wheel's momentum has fixed the scale;
- `estimate` (std_msgs/Float64MultiArray): the base parameters, then the rows of their
  covariance. The label of the second dimension has their names.

python examples/ros2/identify.py --ros-args -p robot:=servicer.yaml
"""

from typing import Any

import message_filters  # pyright: ignore[reportMissingImports]
import numpy as np
import rclpy  # pyright: ignore[reportMissingImports]
from geometry_msgs.msg import InertiaStamped  # pyright: ignore[reportMissingImports]
from nav_msgs.msg import Odometry  # pyright: ignore[reportMissingImports]
from rclpy.node import Node  # pyright: ignore[reportMissingImports]
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu, JointState  # pyright: ignore[reportMissingImports]
from std_msgs.msg import (  # pyright: ignore[reportMissingImports]
    Float64MultiArray,
    MultiArrayDimension,
)

from orbident.live.live_filter import LiveEvent, LiveFilter
from orbident.live.session import nothing_carried
from orbident.model.formulas import formulas_of
from orbident.model.kinematics import poses
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com, transformed
from orbident.robot.robot_file import load_robot

QUEUE = 100
"""Messages that wait for those of their time."""


def as_one_body(robot: Robot, beta: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Ten parameters of the whole robot about S, base axes.

    They depend on `beta` alone: any bodies that have it will do.
    """
    theta = (minimal_sets(robot).base.theta_of @ beta).reshape(robot.theta.shape)
    at = poses(robot, q[None])
    return sum(map(transformed, theta, at.R[0], at.d[0]), np.zeros(10))


def xyz(vector: Any) -> list[float]:
    """A message's vector as numbers."""
    return [vector.x, vector.y, vector.z]


class Identification(Node):
    """Hears the sensors, and publishes estimates every `every` seconds."""

    def __init__(self) -> None:
        """Begin from the CAD values, 30 % uncertain."""
        super().__init__("orbident")
        file = self.declare_parameter("robot", "robot.yaml").value
        std = self.declare_parameter("velocity_std", 1e-3).value
        every = self.declare_parameter("every", 1.0).value
        slop = self.declare_parameter("slop", 1e-3).value
        self._robot = load_robot(file)
        self._filter = LiveFilter(self._robot, std, every, nothing_carried(self._robot))
        self._inertia = self.create_publisher(InertiaStamped, "inertia", 10)
        self._estimate = self.create_publisher(Float64MultiArray, "estimate", 10)
        topics = {"imu": Imu, "joint_states": JointState, "odom": Odometry}
        self._together = message_filters.ApproximateTimeSynchronizer(
            [
                message_filters.Subscriber(self, kind, name)
                for name, kind in topics.items()
            ],
            QUEUE,
            slop,
        )
        self._together.registerCallback(self.hear)

    def hear(self, imu: Any, joints: Any, odometry: Any) -> None:
        """Take one sample in, and publish what it shows."""
        stamp, x = imu.header.stamp, imu.orientation
        x_WB = [*xyz(x), x.w]
        positions = dict(zip(joints.name, joints.position, strict=True))
        rates = dict(zip(joints.name, joints.velocity, strict=True))
        robot, gyro = self._robot, xyz(imu.angular_velocity)
        q = np.array([positions[name] for name in robot.joint_names])
        qd = [rates[name] for name in robot.joint_names]
        qd_rw = [rates[name] for name in robot.wheel_names]
        v_W = Rotation.from_quat(x_WB).apply(xyz(odometry.twist.twist.linear))
        t = [stamp.sec + 1e-9 * stamp.nanosec]
        # The last three are the rate again, for `live` to smooth.
        row = np.concatenate([t, q, qd, gyro, x_WB, qd_rw, v_W, gyro])
        for event in self._filter.take(row[None]):
            if event.kind == "estimate":
                self._publish(event, q, imu.header)
            else:
                self.get_logger().warning(f"{event.kind} at {event.t} s")

    def _publish(self, event: LiveEvent, q: np.ndarray, header: Any) -> None:
        running = self._filter.carried.running
        assert running is not None
        # The filter carries R with C = inv(R^T R).
        root = np.linalg.inv(running.state.root)
        beta, C = np.array(event.of["beta"]), root @ root.T
        message = Float64MultiArray()
        words = formulas_of(self._robot, minimal_sets(self._robot))
        names = ",".join(words.base.names)
        for label, size, stride in (
            ("beta and covariance", 1 + beta.size, (1 + beta.size) * beta.size),
            (names, beta.size, beta.size),
        ):
            dimension = MultiArrayDimension()
            dimension.label, dimension.size, dimension.stride = label, size, stride
            message.layout.dim.append(dimension)
        message.data = np.vstack([beta, C]).ravel().tolist()
        self._estimate.publish(message)
        if not event.of["scale"]:
            return
        whole = as_one_body(self._robot, beta, q)
        I, of_all = inertia_about_com(whole), InertiaStamped()
        of_all.header = header
        of_all.inertia.m = float(whole[0])
        com, inertia = of_all.inertia.com, of_all.inertia
        com.x, com.y, com.z = (whole[1:4] / whole[0]).tolist()
        inertia.ixx, inertia.ixy, inertia.ixz = I[0].tolist()
        inertia.iyy, inertia.iyz, inertia.izz = I[[1, 1, 2], [1, 2, 2]].tolist()
        self._inertia.publish(of_all)


def main() -> None:
    """Until Ctrl-C."""
    rclpy.init()
    rclpy.spin(Identification())


if __name__ == "__main__":
    main()
