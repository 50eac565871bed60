"""Samples that jump as no smooth motion does."""

import numpy as np
import pytest

from orbident.preprocessing.leaps import FAR, jumps_of

T = np.arange(300) * 0.1
NOISE = 1e-4 * np.random.default_rng(0).standard_normal((T.size, 1))
SMOOTH = np.sin(0.7 * T)[:, None] + NOISE


def test_a_smooth_motion_does_not_jump():
    assert jumps_of("joint.a", T, SMOOTH) == []


@pytest.mark.parametrize("size", [-0.02, 0.005])
def test_the_row_and_the_size_of_a_jump(size: float):
    (found,) = jumps_of("joint.a", T, SMOOTH + size * (T[140] <= T)[:, None])
    assert found.times > FAR
    assert found.row == 140
    # The step's own deviation is some three times that of a sample.
    assert found.size[0] == pytest.approx(size, abs=1e-3)
    assert found.rate[0] == pytest.approx(0.7 * np.cos(0.7 * T[140]), abs=0.02)


def test_too_few_samples_show_nothing():
    assert jumps_of("joint.a", T[:20], SMOOTH[:20]) == []


def test_a_jump_there_and_back():
    away = (T[140] <= T) & (T[200] > T)
    found = jumps_of("joint.a", T, SMOOTH + 0.01 * away[:, None])
    assert sorted(jump.row for jump in found) == [140, 200]
    rising = {jump.row: jump.size[0] for jump in found}
    assert rising[140] == pytest.approx(0.01, abs=1e-3)
    assert rising[200] == pytest.approx(-0.01, abs=1e-3)
