"""sensor_msgs/Imu: gyro, accelerometer, attitude."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float

from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import Extraction, PlacedEntry, Take, header_stamp


class ImuTake(Take):
    """Some of the three."""

    gyro: Annotated[Unit, unit("angular rate")] | None = None
    accelerometer: Annotated[Unit, unit("acceleration")] | None = None
    attitude: Literal["quaternion"] | None = None


class Imu(PlacedEntry[ImuTake]):
    """`w_B = R_BS w_S`, `f_B = R_BS f_S`, `R_WB = R_WS R_BS^T`."""

    @property
    def quaternion(self) -> slice | None:
        """The sensor's orientation, which many units leave zero."""
        return slice(0, 4) if self.take.attitude else None

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Orientation, angular velocity, specific force."""
        x, w, f = (
            message.orientation,
            message.angular_velocity,
            message.linear_acceleration,
        )
        yield Extraction(
            header_stamp(message.header),
            (x.x, x.y, x.z, x.w, w.x, w.y, w.z, f.x, f.y, f.z),
        )

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI and base axes."""
        parts = []
        if self.take.gyro:
            parts.append(self.in_base(raw[:, 4:7]) * self.take.gyro.si)
        if self.take.accelerometer:
            parts.append(self.in_base(raw[:, 7:10]) * self.take.accelerometer.si)
        if self.take.attitude:
            parts.append(self.of_base(raw[:, :4]))
        return np.hstack(parts)
