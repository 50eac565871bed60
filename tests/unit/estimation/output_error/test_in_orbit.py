"""In orbit: what acts is identified from directions that are recorded.

The simulator's tide acts on every body, and its air at a point of the base: nothing of
it is the estimator's. The statistics: `pytest -m long` on this file, some five minutes.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import orbident as oi
from orbident.errors import InputError
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import Made, made_along
from orbident.studies import paper_tables
from orbident.studies.spatial import spatial_robot, spatial_trajectory
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


def test_the_tide_is_known_where_the_earth_is():
    result = oi.identify(spatial_robot(), recorded(made("tide"), 0))
    assert result.status == "ok", result.warnings
    assert not result.disturbances
    assert np.abs(errors(result)).max() < 4


def test_without_the_earth_it_is_seen_as_a_slow_torque():
    robot = spatial_robot()
    flown = made("tide")
    seen = measure_truth(robot, flown.t, flown.true, 0)
    result = oi.identify(robot, seen)
    # In inertial axes or in the base's: the base hardly turns against the Earth.
    groups = {fit.group for fit in result.disturbances.values()}
    assert groups <= {"slow_torque", "slow_base_torque"}
    assert groups
    assert np.abs(errors(result)).max() < 4


@pytest.mark.parametrize("runs", [1, pytest.param(MANY, marks=pytest.mark.long)])
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
