"""How much each sensor's times are behind those of the base rate."""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

from pydantic import Field

from orbident.files.json_parts import NullableNumber, NullableStd
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

LEAST = 1e-4
"""s: smaller delays do not matter, and need not be corrected."""

SURE = 5.0
"""Standard deviations that a delay must have."""

WORTH = 0.9
"""A delay is believed where it makes the squared residual smaller than this times."""

LONGEST = 1.0
"""s: sensors, buses and cameras are late by tenths of a second. Clocks that are further
apart were never set together; such clocks drift too, and no constant corrects that."""

EXPLAINED = 0.1
"""A delay that is refused must be what is wrong: it leaves so little of the squared
residual. The last round of its search changed it by so little of itself."""

SETTLED = 1e-6
"""s: changes of the last round below this are none."""


class Delay(NamedTuple):
    """How much the times of a sensor are behind those of the base rate."""

    late: NullableNumber
    """s."""
    std: NullableStd
    believed: Annotated[bool, Field(strict=True, alias="corrected")]
    """Whether it is more than chance, matters, and is short enough to be corrected."""
    apart: Annotated[bool, Field(exclude=True)] = False
    """Whether it is certain, but longer than any sensor is late."""


def delay_of(
    late: float, std: float, change: float, before: float, after: float
) -> Delay:
    """What an iteration found, and whether to believe it.

    Args:
        late: the delay, s.
        std: its standard deviation, s.
        change: of the delay in the last round, s.
        before: norm of the residual without a delay.
        after: with it.
    """
    settled = abs(change) < max(SETTLED, std)
    matters = abs(late) > max(LEAST, SURE * std)
    better = after**2 < WORTH * before**2
    if abs(late) > LONGEST:
        # Near enough to be named.
        near = abs(change) < EXPLAINED * abs(late)
        apart = near and matters and after**2 < EXPLAINED * before**2
        return Delay(float(late), float(std), False, bool(apart))
    return Delay(float(late), float(std), bool(settled and matters and better))


SENSORS = ("joints", "wheels", "gyro", "accelerometer", "attitude", "position")


def delays(
    robot: Robot, recording: Recording, found: Mapping[str, float]
) -> dict[str, float]:
    """Declared latencies and what was found beside them, s.

    A sample with the time `t` shows the world as it was at `t - delay`, on the clock of
    the gyro; without a gyro on that of the attitude.

    Args:
        robot: whose file declares latencies.
        recording: which sensors there are.
        found: by sensor, on top of the declared latencies.
    """
    total = {
        sensor: (robot.sensors.of(sensor).latency or 0.0) + found.get(sensor, 0.0)
        for sensor in SENSORS
    }
    reference = total["gyro" if recording.has("gyro.x") else "attitude"]
    return {sensor: delay - reference for sensor, delay in total.items()}


def corrections(clocks: Mapping[str, Delay]) -> dict[str, float]:
    """The delays that are believed, s, by sensor; what shares a clock shares them.

    Args:
        clocks: of `"joints"` (and wheels) and of `"attitude"` (and position); those of
            one of several recordings say nothing of another.
    """
    shared = {"joints": ("joints", "wheels"), "attitude": ("attitude", "position")}
    return {
        sensor: clocks[name].late
        for name, sensors in shared.items()
        if name in clocks and clocks[name].believed
        for sensor in sensors
    }
