"""A recursive estimate over time, from `history.csv`."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.report.convergence_section import read_trail, recursion
from orbident.report.page import embedded

HEADER = (
    "t,M,sigma_1,M.std,sigma_1.std,"
    "innovation_squared,degrees_of_freedom,change_statistic"
)


def test_charts(tmp_path):
    path = tmp_path / "history.csv"
    t = np.arange(3000) / 10
    rows = [t, 10 + 0 * t, t, 1 / (1 + t), 0 * t + 0.5, 6 + 0 * t, 3 + 0 * t, t / 300]
    np.savetxt(path, np.column_stack(rows), "%.10g", ",", header=HEADER, comments="")
    trail = read_trail(path)
    assert trail is not None
    assert trail.names == ("M", "sigma_1")
    assert (trail.surprise == 2).all()
    section = recursion(trail)
    assert section is not None
    course, detector = section.charts
    titles = [each["text"] for each in course.figure["layout"]["annotations"]]
    assert titles == ["M (kg)", "sigma_1 (kg m)"]
    # A band and a curve for each.
    assert len(course.figure["data"]) == 4
    assert len(detector.figure["data"]) == 3


def test_nothing_to_show(tmp_path):
    assert recursion(read_trail(tmp_path / "history.csv")) is None


@pytest.mark.parametrize("text", ["", "t,M\n1,2,3\n", "t,M,M.std\n1,2,3\n", "\0\1"])
def test_damaged(tmp_path, text: str):
    path = tmp_path / "history.csv"
    path.write_text(text)
    with pytest.raises(InputError, match="identify again"):
        read_trail(path)


def test_what_is_not_determined_has_no_band(tmp_path):
    """As of a run that is refused: its deviations are NaN."""
    path = tmp_path / "history.csv"
    t = np.arange(100) / 10
    rows = [t, 10 + t, t, np.nan * t, np.inf + t, np.nan * t, 3 + 0 * t, np.nan * t]
    np.savetxt(path, np.column_stack(rows), "%.10g", ",", header=HEADER, comments="")
    section = recursion(read_trail(path))
    assert section is not None
    for chart in section.charts:
        assert "NaN" not in embedded(chart.figure)
    layout = section.charts[0].figure["layout"]
    assert layout["yaxis"]["range"] == [12.0, 19.9]
