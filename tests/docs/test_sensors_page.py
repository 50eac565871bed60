"""The least deviations on the page of sensors are those of its robot and its motion."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from pages import ROOT, blocks
from readers_files import bundled

import orbident as oi
from orbident.excitation.bound import bound_of
from orbident.model.formulas import formulas_of

PAGE = ROOT / "docs/how-to/which-sensors.md"
ROBOT, MOTION = (block.text for block in blocks(PAGE) if block.title)
ROWS = re.findall(
    r"^\| `\[(.*)\]` \| .* \| (\S+) \| (\S+) \|$", PAGE.read_text(), re.MULTILINE
)
SPEEDS = re.findall(
    r"wheels at (\d+)[^.]*?to ([\d.]+) kg", " ".join(PAGE.read_text().split())
)


@pytest.fixture(autouse=True)
def in_a_folder_with_the_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    bundled("paper-spatial", "servicer")


def least(suites: str, wheel_speed: float = 100.0) -> dict[str, str]:
    """The least deviations of this motion, with two digits as pages have them."""
    document = yaml.safe_load(ROBOT)
    document["sensors"]["suites"] = suites.split(", ")
    Path("mine.yaml").write_text(yaml.safe_dump(document))
    Path("motion.yaml").write_text(MOTION)
    robot, motion = oi.load_robot("mine.yaml"), oi.load_trajectory("motion.yaml")
    speeds = dict.fromkeys(robot.wheel_names, wheel_speed)
    initial = replace(motion.initial, wheel_speed=speeds)
    found = bound_of(robot, replace(motion, initial=initial)).parameters.base
    every = np.sqrt(np.diag(found.covariance))
    names = formulas_of(robot, oi.minimal_sets(robot)).base.names
    return {n: f"{std:.2g}" for n, std in zip(names, every, strict=True)}


@pytest.mark.parametrize(("suites", "mass", "inertia"), ROWS)
def test_the_table_of_suites(suites: str, mass: str, inertia: str):
    found = least(suites)
    assert (found["M"], found["iota_6"]) == (mass, inertia)


@pytest.mark.parametrize(("speed", "mass"), SPEEDS)
def test_what_the_wheels_give(speed: str, mass: str):
    assert least("phasespace-like", float(speed))["M"] == mass


def test_all_numbers_of_the_page_are_found():
    assert (len(ROWS), len(SPEEDS)) == (5, 2)
