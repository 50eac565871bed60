"""The Allan deviation of noise at rest, beside that of its model.

    sigma^2(tau) = < (mean over tau - mean over the tau before)^2 > / 2

of the samples themselves. White noise falls as `1/sqrt(tau)`, a random walk rises as
`sqrt(tau)`, and a Gauss-Markov process has a hill at 1.9 of its correlation times.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from orbident.estimation.checks import worst
from orbident.files.replacing import write_text
from orbident.noise.noise_model import NoiseModel
from orbident.noise.rest_noise import AxisNoise, noise_table
from orbident.report.charts import (
    MEASURED,
    PREDICTED,
    Figure,
    Panel,
    decades,
    line,
    stacked,
)
from orbident.report.page import Chart, Section, Verdict, page

PER_DECADE = 10
"""Points of a chart."""

WORDS = (
    "The noise of every axis at rest, by maximum likelihood; a part that lasts is "
    "there where the samples ask for it (Bayesian information criterion).",
    "Charts show the Allan deviation of the samples beside that of the model. Where "
    "the averages are long there are few of them, and they scatter.",
)


def write_allan(found: Sequence[AxisNoise], title: str, path: Path) -> None:
    """A page with the noise of a recording at rest.

    An existing file is replaced.

    Raises:
        InputError: it cannot be written.
    """
    checks = tuple(each.check for each in found)
    section = Section(
        name="noise",
        title="Noise at rest",
        words=WORDS,
        tables=(noise_table(found),),
        charts=tuple(
            Chart(each.name, f"{each.name}: Allan deviation", figure_of(each))
            for each in found
        ),
    )
    verdict = Verdict(worst(checks), "", checks, ())
    write_text(path, page(title, "Noise of sensors at rest", verdict, [section]))


def figure_of(each: AxisNoise) -> Figure:
    """The Allan deviation of an axis, measured and modelled."""
    dt = float(np.median(np.diff(each.t)))
    longest = each.samples.size // 4
    decades_of = max(np.log10(longest), 1)
    means = np.unique(
        np.round(np.geomspace(1, longest, int(PER_DECADE * decades_of))).astype(int)
    )
    measured = np.array([allan_deviation(each.samples, int(m)) for m in means])
    modelled = np.array([model_deviation(each.model, int(m), dt) for m in means])
    traces = (
        line(means * dt, measured, MEASURED, name="measured"),
        line(means * dt, modelled, PREDICTED, name="model"),
    )
    y = decades(measured, modelled)
    unit = each.unit("white")
    return stacked([Panel(unit, traces, y=y)], "averaging time, s", type="log")


def allan_deviation(x: Float[np.ndarray, " n"], m: int) -> float:
    """The deviation of overlapping means of `m` samples, as if these came evenly."""
    total = np.append(0.0, np.cumsum(x))
    change = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
    return float(np.sqrt(np.mean(change**2) / 2)) / m


def model_deviation(model: NoiseModel, m: int, dt: float) -> float:
    """That of the model: half the variance of weights +-1/m of `2 m` samples.

    The variance is the sum over lags of the weights' products times the covariance; of
    a walk, `-q^2 |lag| / 2` stands for it where weights sum to nothing.
    """
    k = np.arange(2 * m)
    triangle = [np.maximum(m - np.abs(k - shift), 0) for shift in (-m, 0, m)]
    products = (2 * triangle[1] - triangle[0] - triangle[2]) / m**2
    covariance = -(model.value("random_walk") ** 2) * k * dt / 2
    if model.value("markov_std"):
        decay = np.exp(-k * dt / model.value("correlation_time"))
        covariance += model.value("markov_std") ** 2 * decay
    covariance[0] += model.value("white") ** 2
    twice = np.where(k == 0, 1.0, 2.0)
    return float(np.sqrt(np.sum(twice * products * covariance) / 2))
