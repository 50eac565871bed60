"""`simulate` in an environment: its columns, its seed, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
from running import Orbident

from orbident.recordings.tables import read_recording

MOTION = """\
schema: orbident/trajectory/1
duration: 2.0
joints: {joint1: {a: [0.3], b: [0.2]}, joint2: {a: [0.2], b: [-0.3]}}
initial: {wheel_speed: {rw: 200}}
environment:
"""
TABLE = """\
  tilt: [40 urad, 0]
  slow_torque: {std: 1 mN m, correlation_time: 5 s}
  thrusters: {t2: {gain: 1.5, pulses: [{on: 0.5 s, off: 1 s, force: 10 mN}]}}
"""


def simulated(orbident: Orbident, environment: str, *options: object):
    Path("m.yaml").write_text(MOTION + environment)
    command = (
        "simulate",
        "cepheus-like",
        "m.yaml",
        "-o",
        "r.csv",
        "--rate",
        20,
        "--force",
    )
    return orbident(*command, *options)


def test_the_recording_has_the_commanded_thrust(orbident: Orbident):
    simulated(orbident, TABLE).done()
    force = read_recording("r.csv").column("thruster.t2.force")
    np.testing.assert_allclose(force[10:20], 0.01, rtol=1e-12)
    assert not force[:10].any()
    assert not force[20:].any()


@pytest.mark.parametrize("noise", ["none", "sensors"])
def test_the_seed_draws_what_is_random(orbident: Orbident, noise: str):
    def yaw(seed: int) -> np.ndarray:
        simulated(orbident, TABLE, "--noise", noise, "--seed", seed).done()
        return read_recording("r.csv").column("attitude.z")

    first = yaw(1)
    np.testing.assert_array_equal(yaw(1), first)
    assert np.abs(yaw(2) - first).max() > 1e-5


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ("  wind: 1\n", "environment: unknown key 'wind'"),
        ("  film_drag: {base: {c: 8 mN s/m}}\n", "body 'base' has no pads"),
        (
            "  orbit: {altitude: -1 km, inclination: 0}\n",
            "environment.orbit.altitude: found '-1 km'; the orbit is below the ground",
        ),
        ("  orbit: {altitude: 400 km, inclination: 0}\n", "floats on a table"),
        ("  thrusters: {x: {pulses: []}}\n", "no thruster 'x'"),
        (
            "  thrusters: {t2: {pulses: [{on: 1, off: 9, force: 1}]}}\n",
            "within the run from 0 to 2 s",
        ),
    ],
)
def test_what_cannot_act_is_refused(orbident: Orbident, environment: str, words: str):
    simulated(orbident, environment).refused("m.yaml:", words)
    assert not Path("r.csv").exists()
