"""What gears, drives, encoders and tachometers do, from just visible to gross."""

import numpy as np
from edited_recordings import changed
from flown import flown
from mistake import ON_TABLE, Groups, Mistake, twice
from recordings import Clean
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import (
    Change,
    columns,
    drift,
    filtered,
    low_passed,
    plus,
    rounded,
    times,
)


def ripple(size: float, a_turn: float) -> Change:
    """An error with a period in the joint's own angle; rad, periods a turn."""
    return lambda q: q + size * np.sin(a_turn * q)


def backlash(width: float) -> Change:
    """The motor's angle is ahead of the link by half the play, in either direction."""

    def change(q: np.ndarray) -> np.ndarray:
        out, at = np.empty_like(q), q[0]
        for k, motor in enumerate(q):
            at = min(max(at, motor - width / 2), motor + width / 2)
            out[k] = q[k] + (q[k] - at)
        return out

    return change


def dead_sector(width: float) -> Change:
    """A scratch on the disc: the angle stands still there, and then jumps, rad."""

    def change(q: np.ndarray) -> np.ndarray:
        start = q[q.size // 3]
        inside = (q >= start) & (q < start + width)
        return np.where(inside, start, q)

    return change


def lost_counts(size: float) -> Change:
    """So much is lost whenever the joint turns back, rad."""

    def change(q: np.ndarray) -> np.ndarray:
        # The noise of an encoder does not turn a joint back.
        rate = np.convolve(np.gradient(q), np.ones(9) / 9, "same")
        back = np.append(0, np.diff(np.sign(rate)) != 0)
        return q - size * np.cumsum(back)

    return change


def one_turn(q: np.ndarray) -> np.ndarray:
    """An absolute encoder of one turn, whose end is where the joint moves."""
    middle = np.median(q)
    return middle + np.mod(q - middle, 2 * np.pi)


def tachometers(sensors: str, change: Change) -> Spoil:
    """Of `joints` or `wheels`; the latter are known by their speeds alone."""
    return lambda clean: shown(clean, sensors, change)


def shown(clean: Clean, sensors: str, change: Change) -> Spoiled:
    declared = {
        "joints": {"tachometer": 1e-3},
        "wheels": {"tachometer": 1e-2, "position": None},
    }
    fitted = {sensors: declared[sensors]}
    recording = clean.recorded(sensors=fitted)
    new = {
        name: change(column)
        for name, column in recording.columns.items()
        if name.startswith(sensors[:-1]) and name.endswith(("velocity", "speed"))
    }
    return spoiled(clean, clean.with_sensors(fitted), changed(recording, new))


def late_tachometers(time: float) -> Spoil:
    """Behind filters, s, while the wheels' speeds rise and fall by a third."""
    return lambda clean: shown(
        flown(clean, breath=0.3), "wheels", filtered(clean.t, time)
    )


GEARS: Groups = {
    "gear": (
        *twice("gear ripple of {:g} rad, 200 a turn",
               lambda size: columns("joint.joint2", ripple(size, 200.0)),
               5e-4, 5e-3, cause="noise|ripple|scale|zero|lasting joint"),
        *twice("encoder off centre by {:g} rad",
               lambda size: columns("joint.joint2", ripple(size, 1.0)),
               1e-3, 1e-2, cause="zero|scale|centre|ripple|drift* joint2",
               unobservable=ON_TABLE),
        *twice("backlash of {:g} rad",
               lambda size: columns("joint.joint2", backlash(size)),
               1e-3, 1e-2, cause="backlash|slip*|flexib*|noise|late|clock|jump* joint"),
        *twice("zero of joint2 drifts {:g} rad/s",
               lambda size: drift("joint.joint2", size),
               2e-5, 1e-3, cause="drift* joint2"),
        *twice("drive's filter on all joints, {:g} s",
               lambda size: low_passed("joint.", size),
               0.02, 0.3, cause="late|clock|delay*|filter*|flexib* joint"),
    ),
    "encoder": (
        *twice("encoders rounded to {:g} rad",
               lambda size: columns("joint.", rounded(size)), 1e-3, 1e-2,
               cause="noise|round*|resol*|step|quanti* joint"),
        *twice("encoder of joint2 stands still within {:g} rad",
               lambda size: columns("joint.joint2", dead_sector(size)), 5e-3, 5e-2,
               cause="stuck|still|held|jump*|step|slip*|repeat*|outlier|spike|ripple "
                     "joint"),
        *twice("encoder of joint2 loses {:g} rad when it turns back",
               lambda size: columns("joint.joint2", lost_counts(size)), 2e-4, 5e-3,
               cause="slip*|jump*|step|drift*|lost|backlash joint"),
        Mistake("encoder of joint2 ends where it moves",
                columns("joint.joint2", one_turn), "turn|wrap*|jump*|step|slip* joint"),
        *twice("rates of joints {:g} too small",
               lambda size: tachometers("joints", times(1 - size)), 0.01, 0.1,
               cause="velocity|rate|speed|tacho* joint"),
    ),
    "tachometer": (
        *twice("tachometers off by {:g} rad/s",
               lambda size: tachometers("wheels", plus(size)), 0.05, 2.0,
               # Where it turns evenly: a gain, as that of its momentum.
               cause="offset|zero|tacho*|speed|rest wheel", unobservable=ON_TABLE),
        *twice("tachometers rounded to {:g} rad/s",
               lambda size: tachometers("wheels", rounded(size)), 0.3, 30.0,
               cause="round*|resol*|quanti*|tacho*|speed|step wheel",
               unobservable=ON_TABLE),
        *twice("tachometers behind filters of {:g} s", late_tachometers, 0.05, 1.0,
               cause="late|clock|delay*|filter* wheel"),
    ),
}  # fmt: skip
