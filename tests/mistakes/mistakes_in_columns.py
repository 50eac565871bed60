"""Signs, units, orders of axes, quaternions, rows and times."""

import numpy as np
from mistake import IN_SPACE, Groups, Mistake
from recordings import ROBOTS
from wrong_columns import (
    columns,
    exchanged,
    first_wheel,
    held,
    quaternion,
    rows_lost,
    stamped,
    times,
    vector,
    world_turned,
)

NEGATED, DEGREES, TURNS = times(-1), times(180 / np.pi), times(0.5 / np.pi)
CONJUGATE = np.array([-1, -1, -1, 1])
SWAPPED = [[0, 1, 0], [1, 0, 0], [0, 0, 1]]
CYCLED = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
Y_UP = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
Z_DOWN = np.diag([1, -1, -1])


def scalar_first(x: np.ndarray) -> np.ndarray:
    return np.roll(x, 1, axis=1)


def joints(one: int, other: int) -> tuple[str, str]:
    return f"joint.joint{one}.position", f"joint.joint{other}.position"


def wheels(one: str, other: str) -> tuple[str, str]:
    return f"wheel.rw_{one}.position", f"wheel.rw_{other}.position"


SIGNS = (
    Mistake("joint1 negated", columns("joint.joint1", NEGATED), "sign joint1"),
    Mistake("joint2 negated", columns("joint.joint2", NEGATED), "sign joint2"),
    Mistake("all joints negated", columns("joint.", NEGATED), "sign joint"),
    Mistake("one wheel negated", first_wheel(NEGATED), "sign wheel"),
    Mistake("all wheels negated", columns("wheel.", NEGATED), "sign wheel", IN_SPACE),
    Mistake("gyro x negated", columns("gyro.x", NEGATED), "sign gyro", IN_SPACE),
    Mistake("gyro negated", columns("gyro.", NEGATED), "sign gyro", IN_SPACE),
    Mistake("position x negated", columns("position.x", NEGATED), "sign position"),
    Mistake("position negated", columns("position.", NEGATED), "sign position"),
)

UNITS = (
    Mistake("joint1 in degrees", columns("joint.joint1", DEGREES), "degree|deg joint1"),
    Mistake("all joints in degrees", columns("joint.", DEGREES), "degree|deg joint"),
    Mistake(
        "wheels in degrees",
        columns("wheel.", DEGREES),
        "degree|deg wheel",
        unobservable=ROBOTS,  # a gain of the wheels' momentum, as the next
    ),
    Mistake(
        "wheels in turns",
        columns("wheel.", TURNS),
        "turn|revolution|rpm wheel",
        unobservable=ROBOTS,
    ),
    Mistake(
        "gyro in degrees/s", columns("gyro.", DEGREES), "degree|deg gyro", IN_SPACE
    ),
    Mistake("position in mm", columns("position.", times(1000)), "mm|milli* position"),
    Mistake("time in ms", stamped(times(1000)), "time ms|milli*"),
    Mistake("time in minutes", stamped(times(1 / 60)), "time unit|minute|second"),
)

AXES = (
    Mistake(
        "position x, y swapped",
        vector("position", SWAPPED),
        "axes|axis|order|sequence position",
    ),
    Mistake(
        "position y, z, x",
        vector("position", CYCLED),
        "axes|axis|order|sequence position",
        IN_SPACE,
    ),
    Mistake(
        "position y up", vector("position", Y_UP), "axes|axis|frame position", IN_SPACE
    ),
    Mistake(
        "gyro x, y swapped",
        vector("gyro", SWAPPED),
        "axes|axis|order|sequence gyro",
        IN_SPACE,
    ),
    Mistake("gyro z down", vector("gyro", Z_DOWN), "axes|axis|sign gyro", IN_SPACE),
    Mistake(
        "rw_x, rw_y swapped",
        exchanged(*wheels("x", "y")),
        "order|sequence|swap*|exchang*|axes|axis wheel",
        IN_SPACE,
    ),
)

JOINT_ORDER = (
    Mistake(
        "joint1, joint2 swapped",
        exchanged(*joints(1, 2)),
        "order|sequence|swap*|exchang* joint",
    ),
    Mistake(
        "joint2, joint3 swapped",
        exchanged(*joints(2, 3)),
        "order|sequence|swap*|exchang* joint",
        IN_SPACE,
    ),
)

QUATERNIONS = (
    Mistake(
        "quaternion scalar first",
        quaternion(scalar_first),
        "scalar attitude|quaternion",
    ),
    Mistake(
        "quaternion conjugated",
        quaternion(lambda x: CONJUGATE * x),
        "conjugat*|invers* attitude|quaternion",
    ),
    Mistake(
        "quaternion conjugated, scalar first",
        quaternion(lambda x: scalar_first(CONJUGATE * x)),
        "scalar attitude|quaternion",
    ),
    Mistake(
        "attitude in other inertial axes, 90 deg",
        world_turned("z", 90.0),
        "axes|axis|frame attitude position",
    ),
    Mistake(
        "attitude in other inertial axes, 5 deg",
        world_turned("z", 5.0),
        "axes|axis|frame attitude position",
    ),
)

REPEATED = (
    Mistake("every row twice", held("", 2), "repeat*|stale|held|same"),
    Mistake(
        "position every 5th row new", held("position", 5), "repeat*|stale|held position"
    ),
    Mistake("joints every 5th row new", held("joint.", 5), "repeat*|stale|held joint"),
    Mistake(
        "attitude stuck for 2 s",
        held("attitude", 10**6, 8.0, 10.0),
        "repeat*|stale|held|stuck attitude",
    ),
    Mistake(
        "joint2 stuck for 2 s",
        held("joint.joint2", 10**6, 8.0, 10.0),
        "repeat*|stale|held|stuck joint2",
    ),
)

TIMES = (
    Mistake("time 1 % fast", stamped(times(1.01)), "time|clock rate|fast|scale"),
    Mistake("time 0.1 % fast", stamped(times(1.001)), "time|clock rate|fast|scale"),
    Mistake(
        "1 s of rows lost, times closed up",
        rows_lost(9.0, 10.0),
        "time gap|lost|missing",
    ),
)

IN_COLUMNS: Groups = {
    "sign": SIGNS,
    "unit": UNITS,
    "axis order": AXES,
    "joint order": JOINT_ORDER,
    "quaternion": QUATERNIONS,
    "rows repeated": REPEATED,
    "time": TIMES,
}
