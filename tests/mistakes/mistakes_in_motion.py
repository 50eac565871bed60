"""What acts on a robot that should float free, and robots that change on the way."""

from mistake import IN_SPACE, ON_TABLE, Groups, Mistake
from recordings import ROBOTS
from wrong_motions import (
    acceleration,
    burst,
    changing,
    drag,
    loose,
    spun_down,
    torque,
    turning_already,
)

BASE, LAST = 0, -1
FIRED = "thrust*|burst|force|push|pull|impuls*"
TURNED = "torque|disturb*|external"

BURSTS = (
    Mistake("1 N for 0.2 s", burst(1.0, 10.0, 0.2), FIRED),
    Mistake("5 N for 2 s", burst(5.0, 10.0, 2.0), FIRED),
    Mistake("0.1 N for 1 s, at the end", burst(0.1, 19.0, 1.0), FIRED, ON_TABLE),
    Mistake("0.1 N for 0.2 s", burst(0.1, 10.0, 0.2), FIRED),
)

TORQUES = (
    *(
        Mistake(f"steady torque {size:g} N m", torque(size), TURNED, robots)
        for size, robots in (
            (1e-5, ON_TABLE),
            (1e-4, ON_TABLE),
            (1e-3, ROBOTS),
            (1e-2, IN_SPACE),
        )
    ),
    *(
        Mistake(f"torque {size:g} N m over 30 s", torque(size, 30.0), TURNED, IN_SPACE)
        for size in (1e-2, 1e-1)
    ),
    *(
        Mistake(f"torque {size:g} N m over 10 s", torque(size, 10.0), TURNED, ON_TABLE)
        for size in (1e-4, 1e-3)
    ),
)

PULLS = (
    Mistake(
        "table 10 urad off level", acceleration(1e-4), "force|pull|level", ON_TABLE
    ),
    Mistake(
        "table 0.1 mrad off level", acceleration(1e-3), "force|pull|level", ON_TABLE
    ),
    Mistake("steady pull of 0.1 N", acceleration(1e-4), "force|pull|thrust*", IN_SPACE),
)

DRAGS = tuple(
    Mistake(
        f"drag over {time:g} s", drag(time), "drag|friction|torque|disturb*|external"
    )
    for time in (1e2, 2e3, 5e4)
)

CAPTURES = (
    *(
        Mistake(
            f"last link {100 * part:g} % heavier from the middle on",
            changing(LAST, part),
            "chang*|captur*",
        )
        for part in (0.02, 0.2)
    ),
    Mistake(
        "base 2 % lighter from the middle on", changing(BASE, -0.02), "chang*|releas*"
    ),
)

LOOSE = (
    Mistake(
        "2 % of the base slides 20 mm",
        loose(0.02, 0.02, 8.0),
        "loose|moves|moving|slosh*",
    ),
    Mistake(
        "0.5 % of the base slides 20 mm",
        loose(5e-3, 0.02, 8.0),
        "loose|moves|moving|slosh*",
    ),
)

STARTS = (
    Mistake(
        "turning before the wheels spun up",
        turning_already(0.05),
        "rest",
        unobservable=ON_TABLE,
    ),
    Mistake(
        "turning a little before", turning_already(0.005), "rest", unobservable=ON_TABLE
    ),
    Mistake(
        "wheels lose 10 %, recorded as constant",
        spun_down(0.1),
        "wheel speed",
    ),
    Mistake(
        "wheels lose 1 %, recorded as constant",
        spun_down(0.01),
        "wheel speed",
    ),
)

IN_MOTION: Groups = {
    "burst": BURSTS,
    "slow torque": TORQUES,
    "pull": PULLS,
    "drag": DRAGS,
    "capture in mid-run": CAPTURES,
    "second body loose": LOOSE,
    "start": STARTS,
}
