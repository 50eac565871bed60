"""What the columns of a recording may hold: one line for what is none.

All that is wrong is told with its column and row, counted from 1.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.files.bounds import FAINTEST, LARGEST, SHORTEST, TOGETHER
from orbident.files.names import listed
from orbident.recordings.columns import is_known
from orbident.recordings.no_measurements import sensor_groups

MATTERS = 1e-3
"""Of the time from row to row: a wheel of 100 rad/s turns 1 mrad in 1e-4 of 0.1 s."""

FIRST = 100_000
"""Times that are looked at: the first ones tell it."""

UNEVEN = 0.1
"""Part of the steps that differ: those that a float32 holds exactly are all alike."""


def float32_step(t: Float[np.ndarray, " samples"]) -> float:
    """What times were rounded to as float32, s; 0 where they were not, or hardly.

    The times are in s, in any order.
    """
    t = t[:FIRST]
    if not np.array_equal(t, t.astype(np.float32)):
        return 0.0
    step, steps = float(np.spacing(np.float32(np.abs(t).max()))), np.diff(t)
    uneven = np.mean(steps != np.median(steps)) > UNEVEN
    return step if uneven and step > MATTERS * np.mean(np.abs(steps)) else 0.0


QUATERNION_TOLERANCE = 0.01
"""Loggers that print few digits stay well inside; another convention does not."""


def as_column(source: str, name: str, values: object) -> np.ndarray:
    """A column as read-only numbers.

    Raises:
        InputError: it holds no numbers, or more than one a sample.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise InputError(
            f"{source}: column '{name}' holds {array.dtype} values; give numbers"
        )
    if array.ndim != 1:
        raise InputError(
            f"{source}: column '{name}' has shape {array.shape}; "
            "give one number a sample"
        )
    column = array.astype(np.float64, copy=False).view()
    column.flags.writeable = False
    return column


def _first(bad: Bool[np.ndarray, " n"]) -> int | None:
    """The first of the bad ones; numbers of all might be as large as the column."""
    return int(bad.argmax()) if bad.any() else None


def check_time(source: str, t: np.ndarray) -> None:
    """Refuse times that are no times of samples, s.

    Raises:
        InputError: there are fewer than two, or one is missing, far off, or no later
            than the one before.
    """
    if t.size < 2:
        raise InputError(f"{source}: has {t.size} samples; at least 2 are needed")
    if (k := _first(~np.isfinite(t))) is not None:
        raise InputError(
            f"{source}: column 't', row {k + 1}: found {t[k]}; "
            "every row needs a time in seconds"
        )
    if (k := _first(np.abs(t) > LARGEST)) is not None:
        raise InputError(
            f"{source}: column 't', row {k + 1}: found {t[k]:g} s; give at "
            f"most {LARGEST:g}: is it in nanoseconds? divide it by 1e9"
        )
    steps = np.diff(t)
    if (k := _first(steps <= 0)) is not None:
        step = float32_step(t)
        remedy = (
            "times must be strictly increasing: sort the rows and drop repeated "
            "ones, or cut the recording here if its clock was set or restarted"
        )
        if step:
            remedy = (
                f"they were kept as float32, in steps of {step:.2g} s: write float64"
            )
        raise InputError(
            f"{source}: column 't', row {k + 2}: {t[k + 1]} s does not come after "
            f"{t[k]} s; {remedy}"
        )
    if (k := _first(steps < SHORTEST)) is not None:
        raise InputError(
            f"{source}: column 't', row {k + 2}: {steps[k]:.3g} s after the row "
            f"before; give times in seconds, at least {SHORTEST:g} s apart"
        )
    step = (t[-1] - t[0]) / (t.size - 1)
    if step < TOGETHER:
        raise InputError(
            f"{source}: column 't': rows are {step:.2g} s apart in the mean, and no "
            f"sensor samples faster than every {TOGETHER:g} s; give times in seconds"
        )


def check_column(source: str, name: str, values: np.ndarray, samples: int) -> None:
    """Refuse a column of another length, or with a value that is infinite.

    Raises:
        InputError: so.
    """
    if name == "t":
        raise InputError(f"{source}: column 't' is given twice; remove one")
    if values.size != samples:
        raise InputError(
            f"{source}: column '{name}' has {values.size} rows but 't' has {samples}; "
            "give NaN where there is no sample"
        )
    if (k := _first(np.isinf(values))) is not None:
        raise InputError(
            f"{source}: column '{name}', row {k + 1}: found {values[k]}; "
            "leave the cell empty where there is no sample"
        )


def check_size(source: str, name: str, values: np.ndarray) -> None:
    """Refuse values of known columns that no sensor shows.

    Raises:
        InputError: one is larger or fainter than anything that is measured.
    """
    if not is_known(name):
        return
    size = np.abs(values)
    largest = np.fmax.reduce(size, initial=0.0)
    if 0.0 < largest < FAINTEST:
        raise InputError(
            f"{source}: column '{name}': nothing in it is above {largest:.3g}, which "
            "no sensor measures; give SI units, or 0 where nothing moves"
        )
    if (k := _first(size > LARGEST)) is not None:
        raise InputError(
            f"{source}: column '{name}', row {k + 1}: found {values[k]:g}; give at "
            f"most {LARGEST:g} in SI units, or leave the cell empty where there is no "
            "sample"
        )


def check_filled(source: str, columns: Mapping[str, np.ndarray]) -> None:
    """Refuses a sensor of which a column has no number at all.

    Raises:
        InputError: the column, and which belong to it.
    """
    for names in sensor_groups(columns).values():
        empty = next((name for name in names if np.isnan(columns[name]).all()), None)
        if empty:
            # The position of a joint is needed.
            needed = empty.startswith("joint.") and empty.endswith(".position")
            without = "" if needed else f", or leave out {listed(names)}"
            raise InputError(
                f"{source}: column '{empty}' has no number in any row; fill it{without}"
            )


def check_attitude(source: str, components: Sequence[np.ndarray]) -> None:
    """Refuse attitudes that are no unit quaternions, by more than printed digits.

    Raises:
        InputError: one is not.
    """
    norm = np.zeros_like(components[0])
    with np.errstate(over="ignore"):
        for component in components:
            norm += np.square(component)
    np.sqrt(norm, out=norm)
    if (k := _first(np.abs(norm - 1.0) > QUATERNION_TOLERANCE)) is not None:
        raise InputError(
            f"{source}: columns 'attitude.x' to '.w', row {k + 1}: norm "
            f"{norm[k]:.6g}; give unit quaternions, scalar last"
        )
