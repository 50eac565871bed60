"""Numbers for people: as many digits as the deviation leaves, and no more."""

import math
from typing import TypeGuard

from orbident.data_table import Cell, Interval
from orbident.gaussian import NINETY_FIVE

DIGITS = 6
"""The most significant ones, also where the deviation is smaller."""

SMALLEST, LARGEST = -4, 5
"""Powers of ten beyond which a number is written with one,"""

FINEST = -9
"""and so where its last digit is beyond this."""

NONE = "\N{EN DASH}"
"""Instead of what is not known."""

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def known(value: float | int | None) -> TypeGuard[float]:
    """Whether it is a number at all."""
    return value is not None and math.isfinite(value)


def with_std(value: float, std: float) -> str:
    """A value with the digits that its deviation leaves."""
    return _to(value, _last(value, std)) if known(value) else NONE


def interval_text(value: float, std: float) -> str:
    """The 95 % interval, with the digits of the value."""
    if not (known(value) and known(std)):
        return NONE
    last, half = _last(value, std), NINETY_FIVE * std
    return f"{_to(value - half, last)} to {_to(value + half, last)}"


def short(value: float | None, digits: int = 3) -> str:
    """So many significant digits."""
    if value is None or not known(value):
        return NONE
    return _to(value, _power(value) - digits + 1)


def signed(difference: float) -> str:
    """A difference with its sign, two digits."""
    if not known(difference):
        return NONE
    return ("+" if difference > 0 else "") + short(difference, 2)


def typeset(cell: Cell) -> str:
    """A cell of a table as a report shows it."""
    if isinstance(cell, str):
        return cell.replace(" m^2", " m²")
    if isinstance(cell, Interval):
        return interval_text(cell.value, cell.std)
    if not known(cell.value):
        return NONE
    if cell.std is not None:
        return with_std(cell.value, cell.std)
    if cell.form[0] == "+":
        return signed(cell.value)
    if cell.form[-1] in "fd":
        return f"{cell.value:{cell.form}}".replace("-", "\N{MINUS SIGN}")
    return short(cell.value, int(cell.form[1:-1]))


def _last(value: float, std: float) -> int:
    """The power of ten of the last digit: two digits of the deviation."""
    last = _power(value) - DIGITS + 1
    return max(_power(std) - 1, last) if known(std) and std else last


def _power(value: float) -> int:
    return math.floor(math.log10(abs(value))) if value else 0


def _to(value: float, last: int) -> str:
    power = _power(value)
    beyond = power >= last and not SMALLEST <= power <= LARGEST
    if beyond or last < FINEST:
        mantissa, exponent = f"{value:.{max(power - last, 0)}e}".split("e")
        text = f"{mantissa}·10{str(int(exponent)).translate(_RAISED)}"
    else:
        # Without a sign where nothing is left.
        text = f"{round(value, -last) + 0.0:.{max(-last, 0)}f}"
    return text.replace("-", "\N{MINUS SIGN}")
