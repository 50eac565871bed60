"""What the `environment` of a file may say, and how it comes back."""

from pathlib import Path

import pytest

from orbident.errors import InputError
from orbident.trajectories.trajectory_file import load_trajectory, save_trajectory

EVERYTHING = """\
  torque: [5 mN m, 0, 0]
  force: [0, 1 mN, 0]
  slow_torque: {std: 2 mN m, correlation_time: 10 s}
  slow_force: {std: 1e-3, correlation_time: .inf}
  bursts: [{start: 1, duration: 500 ms, force: [1, 0, 0]}]
  thrusters: {t1: {gain: 1.05, pulses: [{on: 0.5, off: 1.5, force: 0.3}]}}
  tilt: [40 urad, -70 urad]
  uneven: {xx: 10 urad/m, xy: 2e-5}
  film_drag: {base: {c: 8 mN s/m, c_r: 0.2 mN m s}}
  orbit: {altitude: 400 km, inclination: 51.6 deg, epoch: 2026-03-01T12:00:00Z}
  gravity_gradient: true
  air_drag: {density: 3e-12, area: 10 m^2, centre: [50 cm, 0, 0]}
  solar_pressure: {sun: [1, 1, 0], area: 10, centre: [0, 0, 0]}
  dipole: [0, 5 A m^2, 0]
"""


def written(folder: Path, environment: str) -> Path:
    path = folder / "motion.yaml"
    head = "schema: orbident/trajectory/1\nduration: 2\njoints: {}\n"
    path.write_text(f"{head}environment:\n{environment}")
    return path


def test_quantities_are_in_si(tmp_path: Path):
    found = load_trajectory(written(tmp_path, EVERYTHING)).environment
    assert found is not None
    assert found.torque == (5e-3, 0.0, 0.0)
    assert found.force == (0.0, 1e-3, 0.0)
    assert found.tilt == pytest.approx((4e-5, -7e-5))
    assert found.uneven is not None
    assert found.uneven.xx == pytest.approx(9.80665e-5)
    assert found.film_drag["base"].c_r == pytest.approx(2e-4)
    assert found.bursts[0].duration == 0.5
    assert found.orbit is not None
    assert found.orbit.altitude == 4e5


def test_an_environment_comes_back_as_it_was(tmp_path: Path):
    first = load_trajectory(written(tmp_path, EVERYTHING))
    save_trajectory(first, tmp_path / "again.yaml")
    assert load_trajectory(tmp_path / "again.yaml").environment == first.environment


def test_without_one_nothing_is_written(tmp_path: Path):
    path = written(tmp_path, "  torque: [0, 0, 0]\n")
    path.write_text(path.read_text().split("environment:")[0])
    trajectory = load_trajectory(path)
    assert trajectory.environment is None
    save_trajectory(trajectory, path)
    assert "environment" not in path.read_text()


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ("  wind: 3\n", "environment: unknown key 'wind'"),
        ("  torque: [1, 2]\n", "environment.torque: .*give a 3-vector"),
        ("  torque: [1 N, 0, 0]\n", "unknown unit 'N' of a torque; accepted: Nm"),
        ("  tilt: [1, 2, 3]\n", "environment.tilt: .*give a 2-vector"),
        (
            "  orbit: {altitude: -10 km, inclination: 0}\n",
            "orbit.altitude: found '-10 km'; the orbit is below the ground",
        ),
        ("  orbit: {altitude: 400 km}\n", "orbit: inclination: this key is missing"),
        (
            "  orbit: {oem: iss.oem, epoch: 2026-03-01}\n",
            "orbit: 'oem' stands under 'orbit:' of the robot file",
        ),
        (
            "  film_drag: {base: {c: -1}}\n",
            r"film_drag\.base\.c: found -1; give zero or more",
        ),
        (
            "  slow_torque: {std: 1}\n",
            "slow_torque.correlation_time: this key is missing",
        ),
        (
            "  bursts: [{start: 1, duration: 0, force: [1, 0, 0]}]\n",
            r"bursts\[0\]\.duration: found 0; give a time above zero",
        ),
        (
            "  solar_pressure: {sun: [0, 0, 0], area: 1, centre: [0, 0, 0]}\n",
            "solar_pressure: sun: found no direction",
        ),
    ],
)
def test_what_cannot_act_is_one_line(tmp_path: Path, environment: str, words: str):
    with pytest.raises(InputError, match=words) as refused:
        load_trajectory(written(tmp_path, environment))
    assert "\n" not in str(refused.value)
