"""What only the whole of a recording tells, found once and used for its stretches."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from orbident.preprocessing.smoothing import ORDER, Roughness

Found = TypeVar("Found")

FORGOTTEN = 60
"""Times the reach of a smoother: so far away a sample counts by 1e-10 of its noise, and
that in the rows where stretches meet alone.

The slowest root of the smoothing spline of order 4 decays by `exp(-sin(pi/8) d)`, `d`
in units of the reach."""

LONGEST = 256.0
"""Samples that a smoother of a stretch may reach over."""

BESIDE = 192
"""Samples that screening and cubic splines look at beside a sample, and more."""


class Settings:
    """Settings of preprocessing, by name: first come those of a digest."""

    def __init__(self, longest: float = float("inf")) -> None:
        """Smoothers reach over so many samples at most."""
        self._least = longest ** (-2 * ORDER)
        self._found: dict[str, Any] = {}
        self.locked: Mapping[str, float] | None = None
        """Where joints that did not move are held; None: the samples show it."""

    def once(self, name: str, find: Callable[[], Found]) -> Found:
        """What was found under this name before; or what is found now."""
        if name not in self._found:
            self._found[name] = find()
        return self._found[name]

    def knows(self, name: str) -> bool:
        """Whether something was found under this name."""
        return name in self._found

    def smoothers(
        self, name: str, find: Callable[[], list[Roughness]]
    ) -> list[Roughness]:
        """The same of smoothers, which do not reach too far."""

        def limited() -> list[Roughness]:
            return [fit._replace(ratio=max(fit.ratio, self._least)) for fit in find()]

        return self.once(name, limited)

    def beside(self, column: str) -> int:
        """How many samples a stretch must have beside its own."""
        sensor = column.split(".", 1)[0]
        fits = self._found.get(column, self._found.get(sensor, []))
        reach = max((fit.ratio ** (-1 / (2 * ORDER)) for fit in fits), default=0.0)
        return BESIDE + int(FORGOTTEN * reach)
