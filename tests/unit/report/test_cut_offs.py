import re
import sys

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.preprocessing.low_pass import choose_cut_off
from orbident.report.study_page import draw_cut_off

T = np.arange(400) / 20.0
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(T.size)


def cut_off(x):
    return choose_cut_off(T, x)


def test_svg_names_what_it_shows(tmp_path):
    path = tmp_path / "joint.svg"
    draw_cut_off(cut_off(np.sin(T) + NOISE), path, "joint1", "rad")
    text = path.read_text()
    assert text.startswith("<?xml")
    # Matplotlib writes each text as a comment beside its outlines.
    comments = re.findall(r"<!-- (.*?) -->", text)
    for words in (
        "f (Hz)",
        "cut-off frequency (Hz)",
        "amplitude (rad)",
        "RMS (rad)",
        "residual of noise alone",
    ):
        assert words in comments
    assert any(comment.startswith("joint1: cut-off") for comment in comments)


@pytest.mark.parametrize("x", [np.sin(T), np.full(T.size, 0.7), np.zeros(T.size)])
def test_png_without_noise_and_of_a_joint_that_stands_still(tmp_path, x):
    path = tmp_path / "joint.PNG"
    draw_cut_off(cut_off(x), path, "joint1", "rad")
    assert path.read_bytes().startswith(b"\x89PNG")


def test_the_same_data_give_the_same_picture(tmp_path):
    for name in ("a.png", "b.png"):
        draw_cut_off(cut_off(np.sin(T) + NOISE), tmp_path / name, "joint1", "rad")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_many_lines_are_thinned_and_peaks_kept(tmp_path):
    t = np.arange(40_000) / 20.0
    found = choose_cut_off(t, np.sin(2 * np.pi * 3.0 * t))
    draw_cut_off(found, tmp_path / "long.svg", "joint1", "rad")
    # 20 000 lines would take more than half a megabyte.
    assert (tmp_path / "long.svg").stat().st_size < 300_000


def test_no_window_system_is_asked_for():
    assert "matplotlib.pyplot" not in sys.modules


def test_refusals(tmp_path):
    found = cut_off(np.sin(T))
    with pytest.raises(InputError, match=r"joint\.pdf: .* ends in \.png or \.svg"):
        draw_cut_off(found, tmp_path / "joint.pdf", "joint1", "rad")
    with pytest.raises(InputError, match="does not exist"):
        draw_cut_off(found, tmp_path / "no" / "joint.png", "joint1", "rad")
