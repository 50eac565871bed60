"""geometry_msgs/WrenchStamped: the thrusters' net force and moment."""

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float

from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import Extraction, PlacedEntry, Take, header_stamp


class WrenchTake(Take):
    """Either or both."""

    force: Annotated[Unit, unit("force")] | None = None
    torque: Annotated[Unit, unit("torque")] | None = None


class WrenchStamped(PlacedEntry[WrenchTake]):
    """`f_B = R_BS f_S`, `n_B = R_BS n_S`, the moment about S."""

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Force, torque."""
        f, n = message.wrench.force, message.wrench.torque
        yield Extraction(header_stamp(message.header), (f.x, f.y, f.z, n.x, n.y, n.z))

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI and base axes."""
        parts = []
        if self.take.force:
            parts.append(self.in_base(raw[:, :3]) * self.take.force.si)
        if self.take.torque:
            parts.append(self.in_base(raw[:, 3:]) * self.take.torque.si)
        return np.hstack(parts)
