"""The least deviations along a motion, with torques at joints and panels that swing."""

import re
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from examples import EXAMPLES
from random_motions import random_motion

import orbident as oi
from orbident.estimation.identify import identify
from orbident.excitation.bound import bound_of
from orbident.robot.sensor_schema import declared_sensors


@pytest.mark.parametrize("torques", [{}, {"torques": {"std": "0.1 N m"}}])
def test_without_wheels_torques_give_the_scale(torques):
    """Momentum alone shows ratios of parameters; a torque shows how large all are."""
    robot = replace(
        oi.load_robot("paper-spatial"),
        wheels=(),
        sensors=declared_sensors({"rate": RATE, **SENSORS, **torques}),
    )
    motion = random_motion(robot, 1, 60.0, start="turning")
    found = bound_of(robot, motion).parameters.base
    assert found.determined.all() == bool(torques)
    assert found.determined.any() == bool(torques)


@pytest.mark.slow
def test_of_a_panel_that_swings(tmp_path):
    """What an estimate of a simulated recording states is what the bound promises."""
    for name in ("satellite.xml", "satellite.yaml"):
        text = (EXAMPLES / "mujoco-panels" / name).read_text()
        (tmp_path / name).write_text(re.sub(r"\n.*panel_right.*", "", text))
    robot = oi.load_robot(tmp_path / "satellite.yaml")
    arm = replace(robot, joints=robot.joints[:2], passive={})
    motion = replace(random_motion(arm, 1, 60.0, 150.0), joints=("shoulder", "elbow"))
    promised = bound_of(robot, motion).parameters.base
    result = identify(robot, oi.simulate(robot, motion, noise="sensors", seed=1))
    assert result.status == "ok"
    assert promised.determined.all()
    ratio = result.base.std / np.sqrt(np.diag(promised.covariance))
    # How far a panel swings is found to some percent, and with it what it shows.
    assert ratio == pytest.approx(np.ones(ratio.size), abs=0.25)
