"""Misalignments, scales, offsets, clocks, noise, and what a marker is on."""

import math

import numpy as np
from mistake import IN_SPACE, ON_TABLE, Groups, Mistake
from recordings import ROBOTS
from wrong_columns import (
    attitude_jump,
    body_turned,
    columns,
    drift,
    in_inertial_axes,
    jump,
    outliers,
    plus,
    times,
    turned,
    vector,
)
from wrong_sensors import clock, flexible, jitter, marker, sensed

GYRO_BIAS = (1e-3, -1e-3, 1e-3)

TURNED = (
    *(
        Mistake(
            f"attitude sensor turned {angle:g} deg",
            body_turned("z", angle),
            "misalign*|turned|rotat*|axes|axis attitude",
            tolerance={"attitude": {"misalignment": math.radians(angle)}},
        )
        for angle in (0.5, 5.0, 90.0)
    ),
    *(
        Mistake(
            f"gyro turned {angle:g} deg",
            vector("gyro", turned("x", angle)),
            "misalign*|turned|rotat* gyro",
            IN_SPACE,
            tolerance={"gyro": {"misalignment": math.radians(angle)}},
        )
        for angle in (0.2, 1.0, 5.0)
    ),
)

INERTIAL = (
    Mistake("gyro in inertial axes", in_inertial_axes, "inertial gyro", IN_SPACE),
)

SCALES = (
    *(
        Mistake(
            f"gyro scale {100 * part:g} %",
            columns("gyro.", times(1 + part)),
            "scale gyro",
            IN_SPACE,
            tolerance={"gyro": {"scale": part}},
        )
        for part in (1e-3, 1e-2)
    ),
    *(
        Mistake(
            f"position scale {100 * part:g} %",
            columns("position.", times(1 + part)),
            "scale position",
            unobservable=ON_TABLE,
            tolerance={"position": {"scale": part}},
        )
        for part in (2e-3, 2e-2)
    ),
    Mistake(
        "joint2 scale 1 %",
        columns("joint.joint2", times(1.01)),
        "scale joint2",
        unobservable=ON_TABLE,
        tolerance={"joints": {"scale": 0.01}},
    ),
    Mistake(
        "all joints scale 1 %",
        columns("joint.", times(1.01)),
        "scale joint",
        tolerance={"joints": {"scale": 0.01}},
    ),
    Mistake(
        "wheels scale 1 %",
        columns("wheel.", times(1.01)),
        "gain|inertia wheel",
        unobservable=ROBOTS,  # with the inertia of all wheels 1 % less
        tolerance={"wheels": {"inertia": 0.01}},
    ),
)

CLOCKS = (
    *(
        Mistake(
            f"{name} {late:g} s late", clock(name, late), f"clock|late|delay* {name}"
        )
        for name in ("position", "attitude", "joint")
        for late in (0.05, 0.5)
    ),
    *(
        Mistake(
            f"gyro {late:g} s late",
            clock("gyro", late),
            "clock|late|delay* gyro",
            IN_SPACE,
        )
        for late in (0.05, 0.5)
    ),
    Mistake("clock of joints 1 % fast", clock("joint", 0.0, 1.01), "clock joint"),
    Mistake(
        "clock of position 1 % slow", clock("position", 0.0, 0.99), "clock position"
    ),
    Mistake(
        "rows 20 % off their times", jitter(0.2), "time|clock jitter|uneven*|spread"
    ),
)

ZEROS = (
    Mistake(
        "joint1 zero off 20 mrad",
        columns("joint.joint1", plus(0.02)),
        "zero|offset joint1",
        tolerance={"joints": {"zero": 0.02}},
    ),
    *(
        Mistake(
            f"joint2 zero off {1000 * zero:g} mrad",
            columns("joint.joint2", plus(zero)),
            "zero|offset joint2",
            tolerance={"joints": {"zero": zero}},
        )
        for zero in (5e-3, 20e-3)
    ),
)

OFFSETS = (
    Mistake(
        "position from another origin",
        columns("position.", plus(3.0)),
        "origin position",
    ),
    Mistake("position drifts 1 mm/s", drift("position.x", 1e-3), "drift* position"),
    Mistake("position jumps 20 mm", jump("position.x", 0.02), "jump*|step position"),
    Mistake("attitude jumps 0.5 deg", attitude_jump(0.5), "jump*|step attitude"),
    Mistake(
        "joint2 slips 20 mrad", jump("joint.joint2", 0.02), "jump*|slip*|step joint2"
    ),
    Mistake(
        "gyro bias 1 mrad/s",
        sensed("gyro", constant_bias=GYRO_BIAS),
        "bias gyro",
        IN_SPACE,
    ),
    Mistake(
        "gyro bias drifts 0.02 mrad/s^2", drift("gyro.x", 2e-5), "drift* gyro", IN_SPACE
    ),
    Mistake("gyro bias jumps 1 mrad/s", jump("gyro.x", 1e-3), "jump* gyro", IN_SPACE),
)

NOISE = (
    Mistake("position noise 1 mm", sensed("position", std=1e-3), "noise position"),
    Mistake(
        "attitude noise 0.2 deg", sensed("attitude", angle=3.5e-3), "noise attitude"
    ),
    Mistake("encoder noise 2 mrad", sensed("joints", position=2e-3), "noise joint"),
    Mistake(
        "gyro noise 10 times",
        sensed("gyro", angle_random_walk=math.radians(0.1) / 60),
        "noise gyro",
        IN_SPACE,
    ),
    Mistake(
        "2 % of positions off by 50 mm",
        outliers("position.x", 0.02, 0.05),
        "outlier|spike position",
    ),
)

FEATURE_POINT = tuple(
    Mistake(
        f"position {1000 * off:g} mm from S",
        marker(off * np.array([0.6, 0.8, 0.0])),
        "marker|offset|distance feature|marker|point",
        unobservable=robots,
        tolerance={"feature_point": off},
    )
    for off, robots in ((1e-3, ON_TABLE), (1e-2, ()), (1e-1, ()))
)

FLEXIBILITY = tuple(
    Mistake(
        f"joints give way at {hz:g} Hz", flexible(hz), "flexib*|elastic|stiff* joint"
    )
    for hz in (3.0, 10.0)
)

IN_SENSORS: Groups = {
    "misalignment": TURNED,
    "gyro in inertial axes": INERTIAL,
    "scale": SCALES,
    "clock": CLOCKS,
    "encoder zero": ZEROS,
    "offset": OFFSETS,
    "noise": NOISE,
    "wrong S": FEATURE_POINT,
    "flexibility": FLEXIBILITY,
}
