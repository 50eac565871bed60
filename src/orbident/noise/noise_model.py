"""The noise of one axis at rest, by maximum likelihood.

    y = c + x_1 + x_2 + e

with an unknown constant `c`, white noise `e`, a first-order Gauss-Markov process `x_1`
and a random walk `x_2` (`robot/sensor_schema.py`). Of a filter's innovations `v_k` of
the samples, `u_k` of a constant one, and their variances `S_k`, the likelihood is

    -2 ln L = sum (v_k - c u_k)^2 / S_k + sum ln S_k + ln sum u_k^2 / S_k

The last term is there because `c` is estimated from the same samples (restricted
likelihood; Harvey 1989, section 3.4). A scale of all noise together has its most likely
value in closed form; the ratios, logarithms all, are searched for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from orbident import _core
from orbident.gaussian import NINETY_FIVE, noisiest_std

Samples = Float[np.ndarray, " n"]
"""Samples of one axis of a sensor, or the times of samples, s."""

FEWEST = 200
"""Samples: with less the parts cannot be told apart."""

STEP = 1e-3
"""Step of a logarithm, for second differences of the likelihood: the likelihood is
smooth, and rounding is below 1e-9."""

STARTS = 8
"""Correlation times that are tried first, from some samples to a tenth of all time."""

AT_A_LIMIT = 1e-6
"""Distance of a logarithm from its limit that counts as none."""

MOST = 300.0
"""Half of the longest interval of a logarithm: where samples say nothing, any number
may be true."""

LEAST_INFORMATION = 1e-6
"""Least information of a logarithm: with less its deviation is unknown."""

MARKOV, WALK = ("markov_std", "correlation_time"), ("random_walk",)
PARTS = ((), MARKOV, WALK, MARKOV + WALK)
"""The parts that noise may have beside its white part."""


class Level(NamedTuple):
    """A parameter of the noise; its interval is that of its logarithm."""

    value: float
    log_std: float

    @property
    def std(self) -> float:
        """Standard deviation of the value, to first order."""
        return self.value * self.log_std

    @property
    def interval(self) -> tuple[float, float]:
        """95 %."""
        reach = float(np.exp(min(NINETY_FIVE * self.log_std, MOST)))
        return self.value / reach, self.value * reach


@dataclass(frozen=True)
class NoiseModel:
    """The noise of one axis."""

    levels: dict[str, Level]
    """`white`, and of what lasts `markov_std`, `correlation_time`, `random_walk`."""
    misfit: float
    """-2 ln L."""
    samples: int
    innovations: Samples
    """Over their deviations: white if the model holds."""

    def value(self, name: str) -> float:
        """A parameter; zero where the noise has no such part."""
        return self.levels[name].value if name in self.levels else 0.0

    @property
    def bic(self) -> float:
        """Bayesian information criterion (Schwarz 1978): less is better."""
        return self.misfit + len(self.levels) * float(np.log(self.samples))


def best_model(
    t: Samples, y: Samples, parts: Sequence[tuple[str, ...]] = PARTS
) -> NoiseModel:
    """The model with the least information criterion: a part that is not there costs.

    Of 10,000 samples a part with one parameter must explain what chance does once in
    400 times, and with two (of which the time is unknown) much less often.

    Args:
        t: of the samples, s, increasing; gaps and uneven times are allowed.
        y: the samples.
        parts: which combinations are tried.
    """
    found = [noise_model(t, y, names) for names in parts]
    return min((model for model in found if model), key=lambda model: model.bic)


def noise_model(t: Samples, y: Samples, parts: tuple[str, ...]) -> NoiseModel | None:
    """The most likely noise with these parts beside the white one.

    Returns:
        None where the search ends at a limit: the samples do not show these parts.
    """
    names = ("white", *parts)
    likelihood = _Likelihood(t, y, names)
    ratios = _most_likely(likelihood, _starts(t, y, parts)) if parts else np.zeros(0)
    if ratios is None:
        return None
    logs = likelihood.logs(ratios)
    misfit, innovations = likelihood(logs)
    information, V = np.linalg.eigh(_hessian(lambda x: likelihood(x)[0], logs) / 2)
    std = np.sqrt(np.sum(V**2 / np.maximum(information, LEAST_INFORMATION), axis=1))
    levels = {
        name: Level(float(np.exp(value)), float(each))
        for name, value, each in zip(names, logs, std, strict=True)
    }
    return NoiseModel(levels, misfit, t.size, innovations)


def _most_likely(
    likelihood: "_Likelihood", starts: list[Float[np.ndarray, " parts"]]
) -> Float[np.ndarray, " parts"] | None:
    """The ratios; None where a part is absent, or its time at a limit.

    Where there is no white noise, the others over it are at their upper limits.
    """
    limits = likelihood.limits
    start = min(starts, key=likelihood.of_ratios)
    best = minimize(likelihood.of_ratios, start, method="L-BFGS-B", bounds=limits).x
    low, high = np.transpose(limits)
    high = np.where(likelihood.times, high, np.inf)
    return None if np.minimum(best - low, high - best).min() < AT_A_LIMIT else best


class _Likelihood:
    """-2 ln L of logarithms of the parameters, in the order of `names`."""

    def __init__(self, t: Samples, y: Samples, names: tuple[str, ...]) -> None:
        self._t, self._names = t, names
        # In units of its own size: rounding is the same for metres and radians.
        self._unit = float(y.std())
        self._rows = np.column_stack([(y - y.mean()) / self._unit, np.ones(y.size)])
        dt, span = float(np.median(np.diff(t))), float(t[-1] - t[0])
        ends = {
            "markov_std": (1e-3, 1e2),
            "correlation_time": (dt / 2, span),
            "random_walk": (1e-5 / np.sqrt(dt), 1e2 / np.sqrt(dt)),
        }
        self.limits = [tuple(np.log(ends[name])) for name in names[1:]]
        self.times = np.array([name == "correlation_time" for name in names[1:]])

    def __call__(self, logs: Float[np.ndarray, " names"]) -> tuple[float, Samples]:
        v, S, misfit = self._innovations(logs - self._in_units)
        return misfit + float(np.sum(v**2 / S)), v / np.sqrt(S)

    @property
    def _in_units(self) -> Float[np.ndarray, " names"]:
        """What the logarithms are less in units of the samples' size."""
        unit = np.log(self._unit)
        return np.append(unit, np.where(self.times, 0.0, unit))

    def of_ratios(self, ratios: Float[np.ndarray, " parts"]) -> float:
        """-2 ln L with the most likely scale, of parameters over the white one."""
        v, S, misfit = self._innovations(np.append(0.0, ratios))
        free = v.size - 1
        return misfit + free * float(np.log(np.sum(v**2 / S) / free))

    def logs(self, ratios: Float[np.ndarray, " parts"]) -> Float[np.ndarray, " names"]:
        """The parameters, with the most likely scale."""
        relative = np.append(0.0, ratios)
        v, S, _ = self._innovations(relative)
        scale = 0.5 * np.log(np.sum(v**2 / S) / (v.size - 1))
        scales = np.append(scale, np.where(self.times, 0.0, scale))
        return relative + scales + self._in_units

    def _innovations(
        self, logs: Float[np.ndarray, " names"]
    ) -> tuple[Samples, Samples, float]:
        """Those of the samples less the constant, their variances, and ln |S|."""
        given = dict(zip(self._names, np.exp(logs), strict=True))
        coloured = [*(given.get(name, 0.0) for name in MARKOV + WALK), 0.0]
        variance = np.full(self._t.size, given["white"] ** 2)
        both, S = _core.innovations(
            self._t, self._rows, variance, np.array(coloured, dtype=np.float64)
        )
        v, u = both.T
        known = float(np.sum(u**2 / S))
        c = float(np.sum(u * v / S)) / known
        return v - c * u, S, float(np.sum(np.log(S)) + np.log(known))


def _starts(
    t: Samples, y: Samples, parts: tuple[str, ...]
) -> list[Float[np.ndarray, " parts"]]:
    """Where the search begins: logarithms over the white part."""
    dt, span = float(np.median(np.diff(t))), float(t[-1] - t[0])
    white = max(noisiest_std(y[:, None]), 1e-3 * float(y.std()))
    rest = max(float(y.std()) / white, 0.3)
    tries = {
        "markov_std": [0.3 * rest, rest],
        "correlation_time": list(np.geomspace(5 * dt, span / 10, STARTS)),
        "random_walk": list(rest / np.sqrt(span) * np.array([0.1, 0.5, 2.0])),
    }
    return [
        np.log(np.array(each, dtype=np.float64))
        for each in product(*(tries[name] for name in parts))
    ]


def _hessian(f, x: Samples) -> Float[np.ndarray, "n n"]:
    """The Hessian by central differences."""
    n = x.size
    H = np.empty((n, n))
    e = STEP * np.eye(n)
    for i in range(n):
        for j in range(i, n):
            four = f(x + e[i] + e[j]) - f(x + e[i] - e[j])
            four += f(x - e[i] - e[j]) - f(x - e[i] + e[j])
            H[i, j] = H[j, i] = four / (4 * STEP**2)
    return H
