"""One rule of acceptance, applied: what was found, what that means, what to do."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

from orbident.files.json_parts import JsonPart, NullableNumber

Level = Literal["trust", "with care", "do not trust"]
LEVELS: tuple[Level, ...] = get_args(Level)
"""The levels, from the best to the worst."""

VERDICTS = dict(zip(LEVELS, ("trusted", "with care", "refused"), strict=True))
"""What a result of each level is called, in the terminal and in the report."""


@dataclass(frozen=True, repr=False)
class Check(JsonPart):
    """A rule, and how a result fares under it."""

    name: str
    level: Level
    """`"trust"` where it is passed; else what may be done with the result."""
    reason: str
    """What was found, and what it means."""
    remedy: str = ""
    """What to do. Of a rule that is passed, empty or what to mind all the same."""
    statistic: NullableNumber = float("nan")
    limit: NullableNumber = float("nan")
    """The value of `statistic` beyond which the rule is broken; NaN without one."""

    @property
    def passed(self) -> bool:
        """Whether there is nothing to say against the result."""
        return self.level == "trust"

    @property
    def calls_for_care(self) -> bool:
        """Whether there is something to do or to mind, passed or not."""
        return bool(self.remedy) or not self.passed

    @property
    def words(self) -> str:
        """A sentence: what was found, and what to do."""
        return f"{self.reason}; {self.remedy}" if self.remedy else self.reason

    def of(self, label: str) -> "Check":
        """This check, with the name of the recording that it is of before its words."""
        name, reason = f"{label}: {self.name}", f"{label}: {self.reason}"
        return replace(self, name=name, reason=reason)

    def __repr__(self) -> str:
        """What it says, in a line."""
        return f"{self.name} ({self.level}): {self.words}"


def only_vague(checks: Iterable[Check]) -> bool:
    """Whether nothing refuses a result, or no more than that its mass is vague."""
    return {one.name for one in checks if one.level == "do not trust"} <= {"mass"}


def worst(checks: Iterable[Check]) -> Level:
    """The level of a result with these checks."""
    return LEVELS[max((LEVELS.index(check.level) for check in checks), default=0)]
