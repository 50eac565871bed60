"""The picture of what errors of instruments would shift."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import exact_result

from orbident.estimation.budget import SensitivityTable
from orbident.estimation.result import Result
from orbident.report.parameter_section import READABLE, error_in_words, sensitivities
from orbident.robot.robot_file import load_robot


def with_table(table: SensitivityTable | None) -> Result:
    result = exact_result(load_robot("cepheus-like"))
    return replace(result, sensitivity=lambda: table)


def heat_map(result: Result) -> tuple[dict, list[str], list[str]]:
    """The trace, the errors and the parameters."""
    section = sensitivities(result)
    assert section is not None
    (chart,) = section.charts
    layout = chart.figure["layout"]
    errors, names = (layout[axis]["ticktext"] for axis in ("yaxis", "xaxis"))
    return chart.figure["data"][0], errors, names


@pytest.mark.parametrize(
    ("error", "unit", "words"),
    [
        ("joint.left.elbow.zero", "mrad", "1 mrad: zero of left.elbow"),
        ("joint.slide.zero", "mm", "1 mm: zero of slide"),
        ("wheel.rw_x.inertia", "%", "1 %: inertia of rw_x"),
        ("gyro.misalignment.x", "mrad", "1 mrad: gyro misalignment x"),
        ("feature_point.y", "mm", "1 mm: feature point y"),
        ("joints.clock", "ms", "1 ms: joints clock"),
    ],
)
def test_labels_have_units(error: str, unit: str, words: str):
    assert error_in_words(error, unit) == words


def test_cells():
    shifts = np.array([[0.04, -3.21], [np.nan, np.nan], [-523.6, 12345.0]])
    errors, units = ("joint.a.zero", "gyro.scale.x"), ("mrad", "%")
    table = SensitivityTable(("M", "sigma_1", "iota_1"), errors, units, shifts)
    trace, rows, columns = heat_map(with_table(table))
    assert rows == ["1 mrad: zero of a", "1 %: gyro scale x"]
    assert columns == ["total mass", "mx of base and beyond", "Izz of base and beyond"]
    assert trace["text"] == [["0.0", "", "524"], ["3.2", "", "≫"]]
    raw = trace["z"]
    # The colour has the sign, and grows with the logarithm.
    np.testing.assert_array_equal(np.sign(raw[:, 0]), [1, -1])
    assert np.sign(raw[0, 2]) == -1
    assert np.isnan(raw[:, 1]).all()
    assert trace["zmax"] == pytest.approx(np.log10(12346.0))


def test_the_largest_of_many():
    shifts = np.arange(30.0)[:, None] * np.arange(25.0)
    table = SensitivityTable(
        parameters=tuple(f"iota_{k}" for k in range(30)),
        errors=tuple(f"joint.j{k}.zero" for k in range(25)),
        units=("mrad",) * 25,
        shifts=shifts,
    )
    result = with_table(table)
    _, rows, columns = heat_map(result)
    assert rows == [f"1 mrad: zero of j{k}" for k in range(25 - READABLE, 25)]
    assert columns == [f"iota_{k}" for k in range(30 - READABLE, 30)]
    section = sensitivities(result)
    assert section is not None
    assert "The 20 of 25 errors" in section.words[-1]


def test_nothing_is_said_where_nothing_is_known():
    assert sensitivities(with_table(None)) is None
    unknown = SensitivityTable(
        ("M",), ("joints.clock",), ("ms",), np.full((1, 1), np.nan)
    )
    assert sensitivities(with_table(unknown)) is None
