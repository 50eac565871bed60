import sys
from io import BytesIO

import numpy as np
import pytest
from matplotlib.lines import Line2D
from matplotlib.text import Text

from orbident.preprocessing.low_pass import choose_cut_off
from orbident.report.study_page import drawn_cut_off

T = np.arange(400) / 20.0
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(T.size)


def drawing_of(x, t=T):
    return drawn_cut_off(choose_cut_off(t, x), "joint1")


def png_of(x):
    picture = BytesIO()
    drawing_of(x).savefig(picture, format="png")
    return picture.getvalue()


def test_the_picture_names_what_it_shows():
    drawing = drawing_of(np.sin(T) + NOISE)
    # Axis labels and legends are made when it is drawn.
    drawing.savefig(BytesIO(), format="png")
    texts = {text.get_text() for text in drawing.findobj(Text)}
    assert texts >= {
        "f (Hz)",
        "cut-off frequency (Hz)",
        "amplitude (rad)",
        "RMS (rad)",
        "residual of noise alone",
    }
    assert any(text.startswith("joint1: cut-off") for text in texts)


@pytest.mark.parametrize("x", [np.sin(T), np.full(T.size, 0.7), np.zeros(T.size)])
def test_png_without_noise_and_of_a_joint_that_stands_still(x):
    assert png_of(x).startswith(b"\x89PNG")


def test_the_same_data_give_the_same_picture():
    assert png_of(np.sin(T) + NOISE) == png_of(np.sin(T) + NOISE)


def test_many_lines_are_thinned_and_peaks_kept():
    t = np.arange(40_000) / 20.0
    drawing = drawing_of(np.sin(2 * np.pi * 3.0 * t), t)
    curves = [np.asarray(each.get_xydata()) for each in drawing.findobj(Line2D)]
    spectrum = max(curves, key=len)
    # Of 20 000 lines of the spectrum.
    assert len(spectrum) < 2000
    assert spectrum[spectrum[:, 1].argmax(), 0] == pytest.approx(3.0, abs=0.01)


def test_no_window_system_is_asked_for():
    assert "matplotlib.pyplot" not in sys.modules
