"""Figures of matplotlib: their data are the result's, and their axes have units."""

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import report_runs
from matplotlib.figure import Figure

from orbident.errors import InputError
from orbident.estimation.budget import SensitivityTable
from orbident.estimation.quantities import physical_names
from orbident.estimation.result import Result
from orbident.estimation.solution import Step
from orbident.report.fit import autocorrelation, spectrum

UNITS = {"momentum": "N m s", "velocity": "m/s"}


@pytest.fixture(scope="module")
def result() -> Result:
    """Least squares, with a table as maximum likelihood makes one."""
    found = report_runs.result()
    shifts = np.array([[3.0, -150.0], [0.1, np.nan]])
    table = SensitivityTable(
        parameters=found.base.names[:2],
        errors=("joint.joint1.zero", "gyro.scale.x"),
        units=("mrad", "%"),
        shifts=shifts,
    )
    steps = (Step(1e6, np.nan), Step(90.0, 2.0), Step(80.0, 1e-3, 2))
    return replace(found, sensitivity=lambda: table, convergence=steps)


NAMES = (
    *("signals", "residuals", "parameters", "mass", "budget"),
    *("correlations", "sensitivity", "convergence"),
)


def drawn(result: Result, name: str) -> Figure:
    draw: Callable[[], Figure] = getattr(result.plot, name)
    return draw()


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_shows_it(result, name):
    picture = drawn(result, name)._repr_png_()  # pyright: ignore[reportAttributeAccessIssue]: ours
    assert picture.startswith(b"\x89PNG")
    assert name in repr(result.plot)


def test_signals(result):
    """A panel an axis, as in the report; so short a flight is drawn whole."""
    panels = iter(drawn(result, "signals").axes)
    for signal in result.signals():
        below = [next(panels) for _ in signal.axes]
        for k, (panel, axis) in enumerate(zip(below, signal.axes, strict=True)):
            assert panel.get_title(loc="left") == f"{axis} ({UNITS[signal.name]})"
            measured, predicted = (line.get_ydata() for line in panel.lines)
            np.testing.assert_array_equal(measured, signal.measured[:, k])
            np.testing.assert_array_equal(predicted, signal.predicted[:, k])
        assert below[-1].get_xlabel() == "t (s)"
    assert next(panels, None) is None


def test_residuals(result):
    panels = iter(drawn(result, "residuals").axes)
    for signal in result.signals():
        errors, unit = signal.measured - signal.predicted, UNITS[signal.name]
        over_time, over_f, over_lags = (
            [next(panels) for _ in signal.axes] for _ in range(3)
        )
        for k, axis in enumerate(signal.axes):
            e = errors[:, k]
            assert over_time[k].get_title(loc="left") == f"{axis} ({unit})"
            np.testing.assert_array_equal(over_time[k].lines[0].get_ydata(), e)
            assert over_f[k].get_title(loc="left") == f"{axis} ({unit}/√Hz)"
            # Thinned and in decades as the report's (`test_residual_spectra`).
            shown = over_f[k].lines[0].get_data()
            np.testing.assert_array_equal(shown, spectrum(signal.t, e))
            bars = [bar.get_height() for bar in over_lags[k].containers[0]]
            np.testing.assert_allclose(bars, autocorrelation(e), atol=5e-4)
        assert over_f[-1].get_xlabel() == "f (Hz)"
        assert over_lags[-1].get_xlabel() == "lag (samples)"


def test_parameters_and_mass(result):
    (axes,) = drawn(result, "parameters").axes
    assert axes.get_xlabel() == "difference from CAD (%)"
    names = [text.get_text() for text in axes.get_yticklabels()]
    which = [physical_names(result.base).index(name) for name in names]
    drawn_at = np.asarray(axes.lines[1].get_xdata())
    np.testing.assert_allclose(drawn_at, result.base.percent[which], rtol=1e-12)
    (axes,) = drawn(result, "mass").axes
    assert axes.get_xlabel() == "M (kg)"
    cad, routes = (np.asarray(line.get_xdata()) for line in axes.lines[:2])
    assert set(cad) == {result.base.nominal[0]}
    assert set(routes) <= set(result.mass_forms.values)


def test_budget(result):
    """Bars as long as the shares, one after another, and all of them 100 %."""
    (axes,) = drawn(result, "budget").axes
    found = result.budget()
    ends = np.zeros(len(result.base.names))
    for bars in axes.containers:
        k = found.sources.index(bars.get_label())
        for row, bar in enumerate(bars):
            assert bar.get_x() == pytest.approx(ends[row])
            assert bar.get_width() == pytest.approx(100 * found.shares[row, k])
            ends[row] += bar.get_width()
    # Sources of less than half a per cent everywhere are left out.
    assert ends == pytest.approx(100, abs=1)
    assert axes.get_xlabel() == "share of the variance (%)"
    assert [text.get_text() for text in axes.get_yticklabels()] == physical_names(
        result.base
    )


def test_correlations(result):
    axes = drawn(result, "correlations").axes[0]
    R = np.asarray(axes.images[0].get_array())
    np.testing.assert_allclose(np.diag(R), 1.0, rtol=1e-12)
    C, std = result.base_covariance, result.base.std
    assert R[0, 1] == pytest.approx(C[0, 1] / (std[0] * std[1]))


def test_sensitivity(result):
    (axes,) = drawn(result, "sensitivity").axes
    rows = [text.get_text() for text in axes.get_yticklabels()]
    assert rows == ["1 mrad: zero of joint1", "1 %: gyro scale x"]
    assert [text.get_text() for text in axes.texts] == ["3.0", "0.1", "150", ""]


def test_convergence(result):
    cost, size = drawn(result, "convergence").axes
    assert cost.get_xlabel() == size.get_xlabel() == "step"
    assert size.get_title(loc="left") == "largest change (standard deviations)"
    # A curve a round, of all costs, and of the sizes of steps.
    curves = [np.asarray(line.get_xydata()).tolist() for line in cost.lines]
    assert curves == [[[0, 1e6], [1, 90]], [[2, 80]]]
    _, first, second = (np.asarray(line.get_ydata()) for line in size.lines)
    assert (first[1], *second) == (2.0, 1e-3)
    assert cost.get_yscale() == size.get_yscale() == "log"


def test_what_cannot_be_drawn_is_said(result):
    rejected = report_runs.rejected()
    for name in ("parameters", "mass"):
        with pytest.raises(InputError, match="is refused"):
            drawn(rejected, name)
    with pytest.raises(InputError, match="nothing was predicted"):
        drawn(replace(result, signals=tuple), "signals")
    with pytest.raises(InputError, match="least-squares has no steps"):
        drawn(replace(result, convergence=()), "convergence")
    with pytest.raises(InputError, match="is not known"):
        drawn(replace(result, sensitivity=lambda: None), "sensitivity")
    C = np.full_like(result.base_covariance, np.nan)
    base = replace(result.base, covariance=C)
    with pytest.raises(InputError, match="no correlations"):
        drawn(replace(result, base=base), "correlations")


def test_the_extra_is_named(result, monkeypatch: pytest.MonkeyPatch):
    for name in list(sys.modules):
        if name.startswith(("matplotlib", "orbident.report")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r'needs matplotlib: .* "orbident\[report\]"'):
        _ = result.plot
