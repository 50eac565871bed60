import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.preprocessing.column_faults import find_spikes
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

STD = 2.5e-5


def random(seed):
    return np.random.default_rng(seed)


def table_2():
    t = np.arange(1601) * 0.05
    q, _, _ = spatial_trajectory(spatial_robot()).at(t)
    return t, q[:, 1]


def acceleration_steps(t):
    """0.2 rad/s^2 from 2 to 4 s, and as much backwards from 6 to 8 s."""
    ramp = [np.clip(t - start, 0, 2) for start in (2, 6)]
    late = [np.clip(t - end, 0, None) for end in (4, 8)]
    pull = [r**2 / 2 + 2 * s for r, s in zip(ramp, late, strict=True)]
    return 0.2 * (pull[0] - pull[1])


FINE = np.arange(2001) * 0.01
MOTIONS = {
    "Table 2": table_2(),
    "acceleration steps": (FINE, acceleration_steps(FINE)),
    # Up to 6 Hz at 100 Hz: 16 samples a period.
    "chirp": (FINE, np.sin(FINE**2)),
    "still": (FINE, np.full(FINE.size, 0.3)),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("std", [0.0, STD, 1e-2])
def test_clean_samples_are_not_spikes(motion, std):
    t, q = MOTIONS[motion]
    # One in ten thousand would be none or one here.
    assert find_spikes(t, q + std * random(1).standard_normal(t.size)).count == 0


def test_false_alarms_on_gaussian_noise_are_rare():
    x = random(2).standard_normal(50_000)
    assert find_spikes(np.arange(x.size) * 0.01, x).count < 1e-4 * x.size


@pytest.mark.parametrize("burst", [1, 2, 3, 5])
@pytest.mark.parametrize("alike", [True, False])
@pytest.mark.parametrize("motion", ["Table 2", "acceleration steps", "still"])
def test_spikes_and_bursts_that_leap_out_are_found(motion, burst, alike):
    t, q = MOTIONS[motion]
    draws = random(3)
    x = q + STD * draws.standard_normal(t.size)
    true = np.zeros(t.size, dtype=bool)
    # Beyond the noise, and beyond the fastest samples' steps.
    size = 20 * STD + 6 * np.abs(np.diff(q)).max()
    for start in range(40, t.size - 40, 160):
        true[start : start + burst] = True
        sign = draws.choice([-1, 1], 1 if alike else burst)
        x[start : start + burst] += sign * size
    spikes = find_spikes(t, x)
    assert spikes.count == spikes.mask.sum()
    assert (spikes.mask & true).sum() > 0.9 * true.sum()
    assert (spikes.mask & ~true).sum() <= 1


@pytest.mark.parametrize("name", ["paper-spatial", "cepheus-like"])
@pytest.mark.parametrize("noise", ["none", "sensors"])
@pytest.mark.parametrize("seed", range(4))
def test_no_clean_column_of_a_fast_manoeuvre_has_spikes(name, noise, seed):
    robot = load_robot(name)
    flight = simulate(robot, random_motion(robot, seed=seed), noise=noise)
    for column, x in flight.columns.items():
        assert find_spikes(flight.t, x, column).count == 0, column


def test_ends_and_gaps():
    t, q = table_2()
    x = q + STD * random(4).standard_normal(t.size)
    x[[0, 7, -1, 700]] += 0.3
    x[500:520], x[699] = np.nan, np.nan
    np.testing.assert_array_equal(np.flatnonzero(find_spikes(t, x).mask), [7, 700])


def test_without_noise():
    t, q = table_2()
    x = q.copy()
    x[[100, 101, 900]] += 0.1
    np.testing.assert_array_equal(
        np.flatnonzero(find_spikes(t, x).mask), [100, 101, 900]
    )


def test_uneven_times():
    t = np.sort(random(5).uniform(0, 20, 1000))
    x = np.sin(t) + 1e-3 * random(6).standard_normal(t.size)
    assert find_spikes(t, x).count == 0
    x[300] += 0.5
    np.testing.assert_array_equal(np.flatnonzero(find_spikes(t, x).mask), [300])


def test_input_is_not_changed():
    t, q = table_2()
    x = q.copy()
    x[13] = 9.0
    before = x.copy()
    x.flags.writeable = False
    assert find_spikes(t, x).mask[13]
    np.testing.assert_array_equal(x, before)


def test_few_samples():
    assert find_spikes(np.arange(6.0), np.array([0, 1, 2, 3, 4, 5.0])).count == 0
    with pytest.raises(InputError, match="q has 2 samples; spikes show among 5"):
        find_spikes(
            np.arange(6.0), np.array([0, 1, np.nan, np.nan, np.nan, np.nan]), "q"
        )


def test_spikes_are_looked_for_beside_leaps_only(monkeypatch):
    """Whoever looks everywhere finds the same."""
    draw, t = random(3), np.arange(40_000) / 100
    x = np.sin(t) + 1e-3 * draw.standard_normal(t.size)
    x[draw.integers(0, t.size, 100)] += 0.1
    for start in draw.integers(0, t.size, 30):
        x[start : start + draw.integers(1, 14)] += 0.05
    found = find_spikes(t, x)
    for name, everywhere in (
        ("_usual_at_least", lambda padded: np.zeros(padded.size - 100)),
        ("_eventful", lambda at, samples: iter([slice(0, samples)])),
    ):
        monkeypatch.setattr(f"orbident.preprocessing.column_faults.{name}", everywhere)
    assert found.count > 100
    np.testing.assert_array_equal(found.mask, find_spikes(t, x).mask)
