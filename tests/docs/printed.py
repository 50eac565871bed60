"""Whether a command prints what a page says it prints."""

import re

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
TOKEN = re.compile(NUMBER.pattern + r"|\.\.\.|[^\s\d+-]+|[+-]")
ROUNDING = 1e-9
"""Errors that are smaller are those of rounding, which differ between machines."""


def is_printed(shown: str, printed: str) -> bool:
    """Whether these words and numbers are printed, in this order, one after another.

    Spaces and ends of lines do not count. `...` stands for anything. A number with
    decimals or an exponent may be off by one in its last digit, which depends on the
    machine.
    """
    parts = re.split(r"\.\.\.", shown)
    words, start = TOKEN.findall(printed), 0
    for part in map(TOKEN.findall, parts):
        places = range(start, len(words) - len(part) + 1)
        found = (k for k in places if all(map(_alike, part, words[k:])))
        if (place := next(found, None)) is None:
            return False
        start = place + len(part)
    return True


def _alike(shown: str, printed: str) -> bool:
    if shown == printed:
        return True
    if not (NUMBER.fullmatch(shown) and NUMBER.fullmatch(printed)):
        return False
    a, b = float(shown), float(printed)
    if abs(a) < ROUNDING and abs(b) < ROUNDING:
        return True
    # Whole numbers are counts, or belong to names.
    return not shown.lstrip("+-").isdigit() and abs(a - b) < 1.5 * _last_digit(shown)


def _last_digit(number: str) -> float:
    """What one in the last digit is worth."""
    mantissa, _, exponent = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals)
