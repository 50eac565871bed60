import numpy as np
import pytest

from orbident.errors import InputError
from orbident.preprocessing.column_faults import (
    turned_between,
    unwrapped,
    within_a_turn,
)

T = np.arange(0.0, 20.0, 0.05)


def wrapped(x, period=2 * np.pi):
    return x - period * np.round(x / period)


@pytest.mark.parametrize("period", [2 * np.pi, np.pi, 360.0])
def test_a_turning_angle_is_as_numpy_has_it(period):
    x = period * (0.3 * T + 0.4 * np.sin(T))
    np.testing.assert_allclose(
        unwrapped(T, wrapped(x, period), period),
        np.unwrap(wrapped(x, period), period=period),
        rtol=1e-12,
    )


def test_a_wheel_that_spins_up_past_half_a_turn_a_sample():
    # To -170 rad/s: 8.5 rad from one sample to the next, more than a turn.
    x = -170.0 * np.where(T < 10, T**2 / 20, T - 5)
    np.testing.assert_allclose(unwrapped(T, wrapped(x)), x, atol=1e-9)
    assert np.abs(np.unwrap(wrapped(x)) - x).max() > 100


def test_gaps_of_several_turns():
    x = 7.0 * T + 0.5 * np.sin(T)
    shown = wrapped(x)
    missing = (T > 4) & (T < 7)
    shown[missing | (T < 0.3)] = np.nan
    found = unwrapped(T, shown)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(shown))
    valid = ~np.isnan(shown)
    # The first sample stays as it is.
    offset = (x - found)[valid][0]
    np.testing.assert_allclose((x - found)[valid], offset, atol=1e-9)


def test_a_spike_does_not_turn_what_follows():
    x = 2.0 * T
    shown = wrapped(x)
    shown[100] = wrapped(shown[100] + 2.5)
    found = unwrapped(T, shown)
    others = np.arange(T.size) != 100
    np.testing.assert_allclose(found[others], x[others], atol=1e-9)


def test_noise_of_half_a_radian():
    x = 0.2 * T
    noisy = x + 0.5 * np.random.default_rng(0).uniform(-1, 1, T.size)
    np.testing.assert_allclose(unwrapped(T, wrapped(noisy)), noisy, atol=1e-9)


def test_nothing_to_unwrap():
    assert np.isnan(unwrapped(T, np.full(T.size, np.nan))).all()
    with pytest.raises(InputError, match="period 0; give a positive"):
        unwrapped(T, T, 0.0)


@pytest.mark.parametrize("low", [-np.pi, 0.0, -np.pi / 2])
def test_an_angle_that_leaps_by_a_turn_is_shown_within_it(low):
    x = 4.0 * np.sin(0.7 * T) + 1.0
    assert within_a_turn(T, (x - low) % (2 * np.pi) + low)
    shown = (x - low) % (2 * np.pi) + low
    shown[100] = np.nan
    # One wild sample does not hide it.
    shown[200] += 8.0
    assert within_a_turn(T, shown)


def test_neither_a_motion_nor_a_spike_is_a_leap_by_a_turn():
    x = 2.0 * np.sin(0.7 * T)
    assert not within_a_turn(T, x)
    spiky = x.copy()
    spiky[100:110] = 5.0
    spiky[200] -= 4.0
    assert not within_a_turn(T, spiky)
    assert not within_a_turn(T, -170.0 * T)


def test_each_part_between_gaps_is_turned_between_the_limits():
    x = np.sin(T)
    shown = x + 2 * np.pi * np.where(T < 5, 1, np.where(T < 10, 0, -2))
    shown[(T > 4.5) & (T < 5.5) | (T > 9) & (T < 11)] = np.nan
    found = turned_between(T, shown, (-2.0, 2.0), 0.5)
    seen = ~np.isnan(shown)
    np.testing.assert_array_equal(np.isnan(found), ~seen)
    np.testing.assert_allclose(found[seen], x[seen], atol=1e-12)
    nothing = np.full(T.size, np.nan)
    assert np.isnan(turned_between(T, nothing, (-2.0, 2.0), 0.5)).all()
