import numpy as np
import pytest

from orbident.preprocessing.rates import false_rates
from orbident.recordings.recording import Recording

T = np.arange(0.0, 40.0, 0.05)
RANDOM = np.random.default_rng(0)
NOISE, NOISE_V = RANDOM.standard_normal((2, T.size))
Q = 0.8 * np.sin(0.5 * T) + 0.3 * np.sin(1.3 * T + 1)
V = 0.4 * np.cos(0.5 * T) + 0.39 * np.cos(1.3 * T + 1)
COLUMN = "joint.elbow.velocity"


def found(v, q=Q + 1e-4 * NOISE, t=T):
    columns = {"joint.elbow.position": q, COLUMN: v}
    return dict(false_rates(Recording(t, columns), ("elbow", "wrist")))


def low_passed(x, tau):
    y, part = x.copy(), -np.expm1(-0.05 / tau)
    for k in range(1, x.size):
        y[k] = y[k - 1] + part * (x[k] - y[k - 1])
    return y


@pytest.mark.parametrize(
    ("v", "words"),
    [
        (0 * V, "is 0 throughout"),
        (0 * V + 0.6, "is 0.6 throughout"),
        (160 * V, "is 160 times that"),
        (-V, "is -1 times that"),
        (low_passed(V, 0.2), "s late"),
        (np.append([0, 0], np.diff(Q)[:-1] / 0.05), "is 0.075"),
        (np.append(0, np.diff(Q) / 0.05), "is 0.025"),
        (np.cos(2 * T), "does not follow it"),
    ],
    ids=["zero", "limit", "motor", "sign", "filtered", "row late", "backward", "other"],
)
def test_a_rate_that_is_none_is_named(v, words):
    assert words in found(v)[COLUMN]


def test_a_low_pass_is_as_late_as_its_time_constant():
    fine = np.linspace(0, 40, 4001)
    q = 0.8 * np.sin(0.5 * fine)
    v = 0.4 * np.cos(0.5 * fine)
    y = v.copy()
    for k in range(1, v.size):
        y[k] = y[k - 1] - np.expm1(-0.01 / 0.3) * (v[k - 1] - y[k - 1])
    words = found(y, q, fine)[COLUMN]
    assert float(words.split()[1]) == pytest.approx(0.3, rel=0.05)


@pytest.mark.parametrize(
    ("v", "q"),
    [
        (V, Q),
        (V, Q + 1e-4 * NOISE),
        (V + 0.05 * NOISE_V, Q),
        (V + 0.02, Q),
        (1.005 * V, Q),
        (V, 2e-3 * np.round(Q / 2e-3)),
        (V, np.where(T % 17 < 0.3, 5.0, Q)),
        (np.where((T > 10) & (T < 13), np.nan, V), Q),
        (0 * V, 1e-4 * NOISE),
    ],
    ids=[
        "exact",
        "noise",
        "tachometer",
        "bias",
        "scale",
        "counts",
        "wild",
        "gap",
        "held",
    ],
)
def test_what_tachometers_and_encoders_show_is_left(v, q):
    assert found(v, q) == {}


def test_joints_without_both_columns_and_short_recordings_are_left():
    assert found(V[:20], Q[:20], T[:20]) == {}
    assert dict(false_rates(Recording(T, {COLUMN: V}), ("elbow",))) == {}
