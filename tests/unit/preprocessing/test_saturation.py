import numpy as np
import pytest

from orbident.preprocessing.column_faults import saturated

T = np.arange(0.0, 40.0, 0.05)
W = 0.3 * np.sin(T) + 1e-4 * np.random.default_rng(0).standard_normal(T.size)
MOVING = np.ones(T.size, dtype=bool)


@pytest.mark.parametrize(
    ("low", "high", "level"),
    [(-0.2, 0.2, "+-0.2"), (-1, 0.25, "0.25"), (-0.1, 1, "-0.1")],
)
def test_samples_at_the_end_of_the_range_are_found(low, high, level):
    ((reason, mask),) = saturated(np.clip(W, low, high), MOVING).items()
    assert reason == f"sample saturated at {level} rad/s"
    np.testing.assert_array_equal(mask, (low > W) | (high < W))


def test_noise_at_the_end_of_the_range_leaves_none_between():
    noisy = W + 0.01 * np.random.default_rng(1).standard_normal(T.size)
    (mask,) = saturated(np.minimum(noisy, 0.29), MOVING).values()
    assert mask[noisy >= 0.29].all()
    crests = np.abs(W - 0.3) < 0.003
    assert mask[crests].mean() > 0.9


@pytest.mark.parametrize("count", [1e-3, 1e-2, 0.05])
def test_a_coarse_gyro_is_not_saturated(count):
    assert saturated(count * np.round(W / count), MOVING) == {}


def test_a_base_that_turns_evenly_while_joints_rest_is_not_saturated():
    w = np.where(T < 10, 0.3, 0.3 * np.cos(T - 10))
    assert saturated(w, T > 10) == {}
    assert saturated(np.full(T.size, 0.1), MOVING) == {}
