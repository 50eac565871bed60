"""In orbit: what acts is identified from directions that are recorded.

The simulator's tide acts on every body, and its air at a point of the base: nothing of
it is the estimator's. The statistics: `pytest -m long` on this file, some five minutes.
"""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache

import numpy as np
import pytest

import orbident as oi
from orbident.errors import InputError
from orbident.orbits.orbit import Elements, Orbit
from orbident.preprocessing.samples import samples_of
from orbident.robot.sensor_schema import AttitudeSpec
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import Made, made_along
from orbident.studies import paper_tables
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.environment import Environment

MANY = 20
"""Runs with other noise."""

ORBIT = {"orbit": {"altitude": "400 km", "inclination": "0.9 rad"}}
CENTRE = np.array([0.5, 0.4, -0.2])
"""m, of pressure."""

MAGNET = (30.0, -40.0, 50.0)
"""A m^2."""

ACTS = {
    "tide": {"gravity_gradient": True},
    "air": {"air_drag": {"density": 3e-12, "area": 10.0, "centre": [*CENTRE]}},
    "magnet": {"dipole": [*MAGNET]},
}


@cache
def made(*names: str) -> Made:
    """The paper's servicer on its trajectory, at 400 km."""
    robot = spatial_robot()
    acting = {key: value for name in names for key, value in ACTS[name].items()}
    trajectory = replace(
        spatial_trajectory(robot),
        environment=Environment.model_validate(ORBIT | acting),
    )
    return made_along(robot, trajectory, paper_tables.SPATIAL_RATE)


def recorded(flown: Made, seed: int) -> oi.Recording:
    seen = measure_truth(spatial_robot(), flown.t, flown.true, seed)
    return seen.with_columns(flown.known)


def errors(result: oi.Result) -> np.ndarray:
    """Errors of the base parameters, in their deviations."""
    robot = spatial_robot()
    true = oi.minimal_sets(robot).beta(robot.theta)
    return (result.base.values - true) / result.base.std


@pytest.mark.slow
def test_the_tide_is_known_where_the_earth_is():
    result = oi.identify(spatial_robot(), recorded(made("tide"), 0))
    assert result.status == "ok", result.warnings
    assert not result.disturbances
    assert np.abs(errors(result)).max() < 4


def in_orbit(epoch: datetime | None = None) -> oi.Robot:
    orbit = Orbit(Elements(6778137.0, 0.9), epoch)
    return replace(spatial_robot(), orbit=orbit)


def around(robot: oi.Robot, seen: oi.Recording) -> dict[str, np.ndarray]:
    """What is known of the surroundings, base axes."""
    return dict(samples_of(robot, seen).surroundings)


def test_an_orbit_says_what_columns_say():
    """The simulator's columns are those of the true attitude."""
    epoch = datetime(2026, 3, 1, 12, tzinfo=UTC)
    given = {**ORBIT["orbit"], "epoch": epoch.isoformat()}
    light = {"solar_pressure": {"area": 1, "centre": [0, 0, 0]}}
    robot = in_orbit(epoch)
    trajectory = replace(
        spatial_trajectory(robot),
        duration=5.0,
        environment=Environment.model_validate({"orbit": given, **light}),
    )
    seen = oi.simulate(robot, trajectory)
    by_columns = around(spatial_robot(), seen)
    names = ("nadir", "flow", "sun", "field")
    alone = {n: x for n, x in seen.columns.items() if not n.startswith(names)}
    by_orbit = around(robot, replace(seen, columns=alone))
    assert set(by_columns) == set(by_orbit) == set(names)
    for name in names:
        size = np.abs(by_columns[name]).max()
        # The same numbers, but for the rounding of rotations. Flow is as long as the
        # square of the speed, which changes little within five seconds.
        near = 1e-4 if name == "flow" else 1e-9
        np.testing.assert_allclose(
            by_orbit[name], by_columns[name], atol=near * size, err_msg=name
        )
    # What was recorded goes before.
    turned = {f"nadir.{axis}": np.full(seen.t.size, 5e6) for axis in "xyz"}
    both = around(robot, replace(seen, columns={**alone, **turned}))
    np.testing.assert_array_equal(both["nadir"], 5e6)


def without(seen: oi.Recording, *names: str) -> oi.Recording:
    kept = {n: x for n, x in seen.columns.items() if not n.startswith(names)}
    return replace(seen, columns=kept)


def test_the_tide_is_known_by_the_orbit_in_the_robot_file():
    """Without a date nobody knows sun and field, and the servicer needs a tracker."""
    robot = in_orbit()
    tracker = {"attitude": AttitudeSpec(angle=1e-4)}
    robot = replace(robot, sensors=robot.sensors.model_copy(update=tracker))
    flown = made("tide")
    seen = measure_truth(robot, flown.t, flown.true, 0)
    assert set(around(robot, seen)) == {"nadir", "flow"}
    result = oi.identify(robot, seen)
    assert result.status == "ok", result.warnings
    assert not result.disturbances
    assert np.abs(errors(result)).max() < 4
    # With columns it is the same but for the rounding of these.
    same = oi.identify(
        replace(robot, orbit=None), without(seen.with_columns(flown.known), "field")
    )
    np.testing.assert_allclose(
        result.base.values, same.base.values, atol=1e-3 * result.base.std.min()
    )


def test_an_orbit_needs_an_attitude_and_a_time_near_its_epoch():
    seen = without(recorded(made("tide"), 0), "nadir")
    words = r"gives an orbit, and without attitude\.x to \.w nobody knows where"
    with pytest.raises(InputError, match=words):
        oi.identify(in_orbit(), seen)
    half = 0.01 * np.sin(seen.t)
    turned = {"attitude.x": np.sin(half), "attitude.w": np.cos(half)}
    seen = seen.with_columns(dict.fromkeys(["attitude.y", "attitude.z"], 0 * half))
    seen = seen.with_columns(turned)
    with pytest.raises(InputError, match="days from its epoch, and elements hold for"):
        oi.identify(in_orbit(), replace(seen, t=seen.t + 1.7e9))


@pytest.mark.slow
def test_without_the_earth_it_is_seen_as_a_slow_torque():
    """Or it is held by what may act in space."""
    flown = made("tide")
    silent, still = (replace(spatial_robot(), disturbances=acts) for acts in (None, {}))
    seen = measure_truth(silent, flown.t, flown.true, 0)
    held, found = (oi.identify(robot, seen) for robot in (silent, still))
    assert held.level == "trust", held.warnings
    assert found.level == "with care"
    # In inertial axes or in the base's: the base hardly turns against the Earth.
    groups = {fit.group for fit in found.disturbances.values()}
    assert groups <= {"torque", "slow_torque", "base_torque", "slow_base_torque"}
    assert groups & {"slow_torque", "slow_base_torque"}
    for result in (held, found):
        assert np.abs(errors(result)).max() < 4


@pytest.mark.parametrize(
    "runs",
    [
        pytest.param(1, marks=pytest.mark.slow),
        pytest.param(MANY, marks=pytest.mark.long),
    ],
)
@pytest.mark.parametrize(("acts", "group"), [("air", "air"), ("magnet", "dipole")])
def test_what_acts_is_identified(acts: str, group: str, runs: int):
    """Air and magnet act one at a time; of the magnet the moment is identified too."""
    z = []
    for seed in range(runs):
        result = oi.identify(spatial_robot(), recorded(made("tide", acts), seed))
        assert result.status == "ok", result.warnings
        found = result.disturbances
        # So little air may as well be a slow torque: what is identified holds.
        groups = {fit.group for fit in found.values()}
        assert groups == {group} or (
            seed and groups <= {"slow_torque", "slow_base_torque"}
        )
        if group == "dipole":
            sizes = (found[f"dipole.{axis}"] for axis in "xyz")
            z += [(f.value - m) / f.std for f, m in zip(sizes, MAGNET, strict=True)]
        z += [*errors(result)]
    inside = np.mean(np.abs(z) < 1.96)
    print(f"{inside:.3f} of {len(z)} inside, rms {np.sqrt(np.mean(np.square(z))):.2f}")
    assert np.abs(z).max() < 4
    assert runs < MANY or inside > 0.9


Column = Callable[[np.ndarray], np.ndarray]


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("nadir", lambda x: x / 6.8e6, "an orbit below the ground"),
        ("flow", lambda x: 7600 * x, "found a vector with norm 7600"),
        ("field", lambda x: 1e9 * x, "stronger than the Earth's; give tesla"),
    ],
)
def test_what_cannot_be_is_refused(name: str, change: Column, words: str):
    seen = recorded(made("tide"), 0)
    columns = {
        n: change(x) if n.startswith(name) else x for n, x in seen.columns.items()
    }
    with pytest.raises(InputError, match=words):
        oi.identify(spatial_robot(), replace(seen, columns=columns))
