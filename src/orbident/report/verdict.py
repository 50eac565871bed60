"""What a report says first: may the result be used, and why."""

from typing import NamedTuple

import numpy as np

from orbident.estimation.check import Check, Level
from orbident.estimation.result import Result
from orbident.report.numbers import interval_text, short, with_std

HEADLINES: dict[Level, str] = {
    "trust": "Trust it",
    "with care": "Usable, with reservations",
    "do not trust": "Do not trust it",
}


class Verdict(NamedTuple):
    """The head of a report."""

    level: Level
    mass: str
    """The mass in words; empty where there is none."""
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """What was done to the recording."""

    @property
    def headline(self) -> str:
        """The level, as an advice."""
        return HEADLINES[self.level]

    @property
    def style(self) -> str:
        """The level, as a style's name."""
        return self.level.replace(" ", "-")


def verdict_of(result: Result) -> Verdict:
    """The checks of a result; this module adds none."""
    return Verdict(result.level, mass_in_words(result), result.checks, result.notes)


def mass_in_words(result: Result) -> str:
    """The mass with its interval."""
    M, std = result.mass.value, result.mass.std
    if not np.isfinite(M):
        return ""
    return f"{with_std(M, std)} ± {short(std, 2)} kg (95 %: {interval_text(M, std)} kg)"
