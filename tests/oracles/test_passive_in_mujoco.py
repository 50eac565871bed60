"""Panels that nobody measures, flown by MuJoCo: what is identified of them holds.

The satellite is that of `examples/mujoco-panels`, with a CAD model that is off by 5 %.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples import EXAMPLES, identifying

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Passive, Robot
from orbident.robot.robot_file import load_robot

pytestmark = pytest.mark.long

EXAMPLE = EXAMPLES / "mujoco-panels"

FREQUENCY, DAMPING = 0.5, 0.005
"""Of both panels in MuJoCo: Hz, and over critical damping."""

FAR = 4.5
"""Deviations beyond which none of some fifty correlated numbers is: with a probability
below 1e-3 by chance."""


@pytest.fixture(scope="module")
def example():
    return identifying("mujoco-panels")


def by_cad(true: Robot, seed: int, passive: dict[str, Passive]) -> Robot:
    """With masses and inertias that are off; those of panels by one factor."""
    scale = 1 + 0.05 * np.random.default_rng(seed).standard_normal(len(true.bodies))
    panels = [k for k, joint in enumerate(true.joints, 1) if joint.name in true.passive]
    scale[panels] = scale[panels[0]]
    return replace(true, theta=true.theta * scale[:, None], passive=passive)


def check(result: Result, true: Robot) -> None:
    assert result.status == "ok", result.warnings
    for found in result.springs.values():
        assert abs(found.frequency / FREQUENCY - 1) < 0.01
        assert abs(found.frequency - FREQUENCY) < FAR * found.frequency_std
        assert abs(found.damping - DAMPING) < FAR * found.damping_std
    beta = minimal_sets(result.robot).beta(true.theta)
    assert np.nanmax(np.abs((result.base.values - beta) / result.base.std)) < FAR


def test_two_of_one_make(example):
    true = load_robot(EXAMPLE / "satellite.yaml")
    robot = by_cad(true, 0, {**true.passive})
    check(identify(robot, example.recorded(true, 0)), true)


def test_two_that_are_not_said_to_be_of_one_make(example):
    """Deviations of first order do not hold: they are refused, and it is said why."""
    true = load_robot(EXAMPLE / "satellite.yaml")
    alone = {name: each._replace(like="") for name, each in true.passive.items()}
    result = identify(by_cad(true, 0, alone), example.recorded(true, 0))
    assert result.status == "rejected"
    assert "swing alike, or may" in result.refusal()


@pytest.mark.parametrize(("seed", "off"), [(0, 0.8), (1, 1.2)])
def test_one_panel(example, tmp_path: Path, seed, off):
    """The other one does not bend."""
    for name in ("satellite.xml", "satellite.yaml"):
        text = (EXAMPLE / name).read_text()
        (tmp_path / name).write_text(re.sub(r"\n.*panel_right.*", "", text))
    true = load_robot(tmp_path / "satellite.yaml")
    panel = {"panel_left": Passive(off * FREQUENCY, DAMPING)}
    recording = example.recorded(true, seed, tmp_path / "satellite.xml")
    check(identify(by_cad(true, seed, panel), recording), true)
