"""Rates of measured positions, and samples between samples, by cubic splines."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.errors import InputError


def spline_rates(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples *columns"],
    name: str = "x",
) -> Float[np.ndarray, " samples *columns"]:
    """Time derivative of each column at every `t`.

    The not-a-knot cubic spline through the valid samples, differentiated. NaN before
    the first and after the last valid sample: an extrapolated rate is mostly noise.

    Args:
        t: Times, s, strictly increasing.
        x: One column or several; NaN where there is no sample.
        name: What `x` is, for messages.

    Raises:
        InputError: A column has fewer than 4 valid samples or infinite values.
    """
    return _by_column(x, name, lambda column, label: _spline(t, column, label)(t, nu=1))


def fill(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples *columns"],
    name: str = "x",
) -> Float[np.ndarray, " samples *columns"]:
    """Each column with its gaps filled from the same spline; measured values stay.

    Nothing is extrapolated: NaN before the first and after the last valid sample stay.

    Args:
        t: Times, s, strictly increasing.
        x: One column or several; NaN where there is no sample.
        name: What `x` is, for messages.

    Raises:
        InputError: A column has fewer than 4 valid samples or infinite values.
    """

    def filled(column: np.ndarray, label: str) -> np.ndarray:
        spline = _spline(t, column, label)
        gaps = np.isnan(column)
        result = column.copy()
        result[gaps] = spline(t[gaps])
        return result

    return _by_column(x, name, filled)


def at_times(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples"],
    at: Float[np.ndarray, " m"],
    name: str = "x",
) -> Float[np.ndarray, " m"]:
    """The same spline at other times; NaN where it would be extrapolated.

    Args:
        t: Times, s, strictly increasing.
        x: One column; NaN where there is no sample.
        at: Times to evaluate at, s.
        name: What `x` is, for messages.

    Raises:
        InputError: The column has fewer than 4 valid samples or infinite values.
    """
    return _spline(t, x, name)(at)


def _by_column(
    x: np.ndarray, name: str, work: Callable[[np.ndarray, str], np.ndarray]
) -> np.ndarray:
    # A spline needs several times its data: one column at a time bounds that.
    if x.ndim == 1:
        return work(x, name)
    result = np.empty(x.shape)
    for index in np.ndindex(x.shape[1:]):
        label = f"{name}[:, {', '.join(map(str, index))}]"
        result[:, *index] = work(x[:, *index], label)
    return result


def _spline(t: np.ndarray, column: np.ndarray, label: str) -> CubicSpline:
    valid = ~np.isnan(column)
    count = int(valid.sum())
    if count < 4:
        raise InputError(
            f"{label} has {count} samples; a cubic spline needs at least 4"
        )
    knots, values = (t, column) if count == t.size else (t[valid], column[valid])
    try:
        return CubicSpline(knots, values, extrapolate=False)
    except ValueError as error:
        raise InputError(
            f"{label}: no spline ({error}); give finite samples at strictly "
            "increasing times"
        ) from error
