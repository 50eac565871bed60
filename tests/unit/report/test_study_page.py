"""The paper's figures: a curve for every column, the same file for the same data."""

import re

import numpy as np
import pytest

from orbident.report.study_page import draw_errors, draw_figures
from orbident.studies.paper_tables import PaperRow
from orbident.studies.run_planar import PaperFigure

T = np.linspace(0, 1, 50)
FIGURES = {
    "fig08": PaperFigure(
        "Measured position and velocity of S",
        {"t (s)": T, "S x (m)": T, "S y (m)": T**2, "S velocity x (m/s)": T},
    ),
    "fig12": PaperFigure(
        "Position with its prediction",
        {"t (s)": T, "S x (m)": T, "S y (m)": T, "S x predicted (m)": T + 0.1},
    ),
}


def _texts(svg: str) -> list[str]:
    # Matplotlib writes each text as a comment beside its outlines.
    return re.findall(r"<!-- (.*?) -->", svg)


def test_figures(tmp_path):
    first = draw_figures(FIGURES, tmp_path)
    assert [picture.title for picture in first] == [
        "Fig. 8. Measured position and velocity of S",
        "Fig. 12. Position with its prediction",
    ]
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"fig{k}.{kind}" for k in ("08", "12") for kind in ("png", "svg")}
    assert (tmp_path / "fig08.png").read_bytes().startswith(b"\x89PNG")
    by_unit, by_axis = (_texts(picture.svg) for picture in first)
    assert {"position (m)", "velocity (m/s)", "S velocity x", "t (s)"} <= set(by_unit)
    # Each axis with its own prediction.
    assert by_axis.count("position (m)") == 2
    assert {"S x", "S y", "S x predicted"} <= set(by_axis)
    again = draw_figures(FIGURES, tmp_path)
    assert [picture.svg for picture in again] == [picture.svg for picture in first]
    assert (tmp_path / "fig12.svg").read_text() == first[1].svg


@pytest.mark.parametrize("rms", [float("nan"), 0.2])
def test_errors(tmp_path, rms: float):
    rows = [
        PaperRow("pi_1", 843.15, 0.04, 843.15, 843.15, rms),
        PaperRow("M", None, None, 1110.0, 1111.0, rms),
    ]
    picture = draw_errors(rows, tmp_path / "table4", "Table 4")
    texts = _texts(picture.svg)
    assert {"pi_1", "M", "paper", "estimate", "relative error (%)"} <= set(texts)
    assert ("RMS over seeds" in texts) == (rms == rms)
    assert (tmp_path / "table4.png").is_file()
