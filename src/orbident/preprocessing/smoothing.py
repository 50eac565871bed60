"""Position, rate and acceleration of columns, as smooth as their noise says.

What only the whole of a recording tells, found once and used for its stretches.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.threads import processors

Found = TypeVar("Found")

ORDER = 4
"""Components of the state: value, rate, acceleration and jerk, driven by white snap."""

STRETCHES, STRETCH = 4, 1024
"""The density of the snap is searched on all samples of a column up to 4 x 1024; on 4
stretches of 1024 consecutive samples, evenly spread, of a longer one."""

AVERAGED = 8
"""Neighbouring samples that are averaged before the search where motion is slow."""

SLOW = 64.0
"""Samples that smoothing reaches over. Beyond, a stretch is too short to show how rough
the motion is; and `AVERAGED` of them are as good as one."""

AT_ONCE = 4
"""Columns that the core smooths in the time of one."""

TRIED = 8
"""Densities that are tried at once."""

LARGEST = 1e12
"""The largest ratio tried. The spline then misses no sample by more than some
millionths of what that differs from its prediction; beyond, rounding takes over."""

REMEMBERED = 128
"""Columns whose roughness is kept, 64 kB each at most: while a cause is looked for,
most are smoothed again and again as they were."""

SMALLEST = 1e-100
"""Size that even a column of zeros is taken to have, in any unit."""


class Smoothed(NamedTuple):
    """Columns at the times asked for; NaN where they would be extrapolated."""

    x: Float[np.ndarray, "m columns"]
    rate: Float[np.ndarray, "m columns"]
    """Per second."""
    acceleration: Float[np.ndarray, "m columns"]
    """Per second squared."""
    std_x: Float[np.ndarray, "m columns"]
    std_rate: Float[np.ndarray, "m columns"]
    noise_std: Float[np.ndarray, " columns"]
    """Noise of the samples, as given or as estimated; NaN where 4 say nothing."""


class Rates(NamedTuple):
    """Smoothed values and rates without deviations, in two thirds of the time."""

    x: Float[np.ndarray, "m columns"]
    rate: Float[np.ndarray, "m columns"]
    """Per second."""


class Column(NamedTuple):
    """The valid samples of one column; at least 4."""

    t: Float[np.ndarray, " n"]
    """s."""
    x: Float[np.ndarray, " n"]
    h: float
    """The unit of time, s: what 9 of 10 samples follow each other in."""
    offset: float
    """The mean: it says nothing of the motion, but would cost digits."""


class Roughness(NamedTuple):
    """How rough a column is, and how noisy."""

    ratio: float
    """`q h^7 / noise_std^2`, `q` the two-sided spectral density of the snap."""
    noise_std: float
    """Noise of the samples, in the unit of the column; NaN where only 4 say nothing."""
    h: float
    """As the column's."""
    offset: float
    """As the column's."""

    @property
    def reach(self) -> float:
        """How far smoothing reaches, s."""
        return float(self.h * self.ratio ** (-1 / (2 * ORDER)))


def smooth(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, "samples columns"],
    std: float | Float[np.ndarray, " columns"] | None = None,
    at: Float[np.ndarray, " m"] | None = None,
    name: str = "x",
    fits: Sequence[Roughness] | None = None,
) -> Smoothed:
    """The smoothing spline of degree 7 of each column, with standard deviations.

    `sample = x + N(0, std^2)`, `x''''` white, nothing known at the start: the posterior
    mean is the smoothing spline (Wahba 1978). The density of `x''''` is the most likely
    one, so that the noise alone decides how smooth the result is; of more than 4096
    samples it is found from 4 stretches of 1024, or of averages of 8, or 64, or more.

    The standard deviations hold where the motion is equally smooth throughout. Next to
    a step of the acceleration they are too small.

    Args:
        t: times, s, strictly increasing.
        x: any unit; NaN where there is no sample. Each column is for itself.
        std: of the measurement noise, in the unit of `x`; estimated where it is None.
            Give a coarse encoder's: where its steps show, they do not look like noise.
        at: times to evaluate at, s, in any order; `t` by default.
        name: what `x` is, for messages.
        fits: of each column, where they are known.

    Returns:
        In the unit of `x`, and s.

    Raises:
        InputError: a column has fewer than 4 valid samples or infinite values, times
            do not increase or are not finite, or `std` is not positive.
    """
    _check_times(t, name)
    fits = fits_of(t, x, std, name) if fits is None else fits
    found = _smoothed(_core.smooth_columns, t, x, at, name, fits)
    return Smoothed(*found, noise_std=np.array([fit.noise_std for fit in fits]))


def smooth_rates(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, "samples columns"],
    at: Float[np.ndarray, " m"],
    name: str,
    fits: Sequence[Roughness],
) -> Rates:
    """Values and rates as `smooth` finds them; its arguments and errors."""
    _check_times(t, name)
    return Rates(*_smoothed(_core.smooth_rates, t, x, at, name, fits))


def _smoothed(
    columns: Callable[..., tuple[np.ndarray, ...]],
    t: np.ndarray,
    x: np.ndarray,
    at: np.ndarray | None,
    name: str,
    fits: Sequence[Roughness],
) -> list[Float[np.ndarray, "m columns"]]:
    """What a function of the core makes of the columns."""
    # Times of samples alone need no others among them.
    at = None if at is None or np.array_equal(at, t) else at
    grid, samples = (t, x) if at is None else _with_times(t, x, at, name)
    found = columns(
        grid,
        np.ascontiguousarray(samples),
        np.array([fit.ratio for fit in fits]),
        np.array([fit.h for fit in fits]),
        np.array([fit.noise_std for fit in fits]),
        np.array([fit.offset for fit in fits]),
        processors(),
    )
    if at is None:
        return [values.T for values in found]
    rows = np.searchsorted(grid, at)
    return [values[:, rows].T for values in found]


def fits_of(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, "samples columns"],
    std: float | Float[np.ndarray, " columns"] | None = None,
    name: str = "x",
) -> list[Roughness]:
    """How rough and how noisy each column is; arguments and errors of `smooth`."""
    columns = [_column(t, column, name) for column in x.T]
    given = _stds(std, len(columns), name)
    return [most_likely(column, s) for column, s in zip(columns, given, strict=True)]


def _check_times(t: np.ndarray, name: str) -> None:
    with np.errstate(invalid="ignore"):
        good = np.isfinite(t) & (np.diff(t, prepend=-np.inf) > 0)
    bad = np.flatnonzero(~good)
    if bad.size:
        raise InputError(
            f"{name}: time {bad[0] + 1} is {t[bad[0]]} s; give finite, strictly "
            "increasing times"
        )


def _column(t: np.ndarray, x: np.ndarray, label: str) -> Column:
    valid = ~np.isnan(x)
    t, x = t[valid], x[valid]
    if t.size < 4:
        raise InputError(f"{label} has {t.size} samples; smoothing needs at least 4")
    if np.isinf(x).any():
        raise InputError(f"{label} has infinite values; give finite samples or NaN")
    # Neither long gaps nor samples that all but coincide set the unit of time.
    h = float(np.quantile(np.diff(t), 0.9))
    return Column(t, x, h, offset=float(x.mean()))


def _stds(
    std: float | np.ndarray | None, columns: int, name: str
) -> Sequence[float | None]:
    if std is None:
        return [None] * columns
    values = np.broadcast_to(std, (columns,))
    if not (np.isfinite(values) & (values > 0)).all():
        raise InputError(f"{name}: std {std}; give positive numbers, or None")
    return [float(value) for value in values]


def _with_times(
    t: np.ndarray, x: np.ndarray, at: np.ndarray, name: str
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n columns"]]:
    """The times of samples and those asked for together; no sample at the others."""
    if not np.isfinite(at).all():
        raise InputError(f"{name}: asked for a time that is not finite; give seconds")
    grid = np.union1d(t, at)
    samples = np.full((grid.size, x.shape[1]), np.nan)
    samples[np.searchsorted(grid, t)] = x
    return grid, samples


def most_likely(column: Column, std: float | None) -> Roughness:
    """The density of the snap under which the samples are most likely.

    `-2 log L = misfit / R + log_det + freedom log R`, `R = std^2`, is least, with the
    state at the start integrated out. Where `std` is None, `R = misfit / freedom`.
    Searched on a grid from "a cubic" to "through every sample", then on two finer ones;
    of more than 4096 samples, 4 stretches of 1024 stand for all, of averages where
    samples follow each other fast.

    Args:
        column: samples, any unit.
        std: of the measurement noise, in the unit of the column; None if unknown.
    """
    t, x = _stretches(column)
    # Samples are no better than their last bit, even of a joint that stands still.
    bit = np.finfo(np.float64).eps * max(np.abs(column.x).max(), SMALLEST)
    samples = (t.tobytes(), x.tobytes(), len(t))
    fit = Roughness(*_likeliest(*samples, bit, std), column.h, column.offset)
    reach = fit.ratio ** (-1 / (2 * ORDER))
    if column.t.size <= STRETCHES * STRETCH or reach < SLOW:
        return fit
    slow = most_likely(_averaged(column), fit.noise_std / np.sqrt(AVERAGED))
    return fit._replace(ratio=slow.ratio / float(AVERAGED) ** (2 * ORDER))


def _averaged(column: Column) -> Column:
    """Averages of neighbours, but for those across a gap."""
    n = column.t.size // AVERAGED * AVERAGED
    t, x = (each[:n].reshape(-1, AVERAGED) for each in (column.t, column.x))
    h = AVERAGED * column.h
    close = np.ptp(t, axis=1) < 2 * h
    return Column(t[close].mean(axis=1), x[close].mean(axis=1), h, column.offset)


@lru_cache(REMEMBERED)
def _likeliest(
    times: bytes, samples: bytes, stretches: int, bit: float, std: float | None
) -> tuple[float, float]:
    """The ratio, and the noise of the samples."""
    t, x = (np.frombuffer(each).reshape(stretches, -1) for each in (times, samples))
    freedom = t.size - ORDER * stretches
    span = (-2 * ORDER * np.log10(4 * np.ptp(t, axis=1).max()), np.log10(LARGEST))

    def tried(low: float, high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        grid = np.linspace(low, high, TRIED)
        parts = _core.smoothing_evidence(t, x, 10**grid, processors())
        misfit, log_det = (part.sum(axis=0) for part in parts)
        R = np.maximum(misfit / max(freedom, 1), bit**2)
        if std is not None:
            R[:] = std**2
        return grid, R, misfit / R + log_det + freedom * np.log(R)

    for _ in range(2):
        grid, _, cost = tried(*span)
        step, best = grid[1] - grid[0], grid[np.argmin(cost)]
        span = (max(span[0], best - step), min(span[1], best + step))
    grid, R, cost = tried(*span)
    ratio = _vertex(grid, cost)
    if std is None:
        found = np.exp(np.interp(ratio, grid, np.log(R)) / 2) if freedom else np.nan
        std = float(found)
    return 10**ratio, std


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Vertex of the parabola through the least `y` and its neighbours; `x` is even."""
    k = int(np.argmin(y))
    if k in {0, x.size - 1}:
        return float(x[k])
    slope, bend = (y[k + 1] - y[k - 1]) / 2, y[k + 1] - 2 * y[k] + y[k - 1]
    return float(x[k] - (x[1] - x[0]) * slope / bend) if bend > 0 else float(x[k])


def _stretches(
    column: Column,
) -> tuple[Float[np.ndarray, "stretches n"], Float[np.ndarray, "stretches n"]]:
    """Times in units of `h`, and samples about their mean."""
    t, x = column.t / column.h, column.x - column.offset
    if t.size <= STRETCHES * STRETCH:
        return t[None], x[None]
    starts = np.linspace(0, t.size - STRETCH, STRETCHES).astype(int)
    rows = starts[:, None] + np.arange(STRETCH)
    return t[rows], x[rows]


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
        self.whole = np.isinf(longest)
        """Whether they are found from all samples."""
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
