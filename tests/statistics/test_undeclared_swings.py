"""What swings and is not declared is named with its frequency, on MuJoCo's flights.

pytest -m long -s tests/statistics/test_undeclared_swings.py
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

import re
import xml.etree.ElementTree as ET
from copy import deepcopy
from pathlib import Path

import mujoco
import numpy as np
import pytest
from test_swinging_intervals import (
    CASES,
    SEEDS,
    Swings,
    by_cad,
    recorded,
    robot_of,
)

from orbident.estimation.identify import identify

NAMED = 0.9
"""Part of the flights in which the ring is named."""


def rigid(case: Swings) -> Swings:
    """The robot as its file declares nothing that swings."""
    model = deepcopy(case.model)
    for body in model.iter("body"):
        for joint in body.findall("joint"):
            if joint.get("name") in case.declared.get("passive", {}):
                body.remove(joint)
    return case._replace(model=model, declared={})


def floating(case: Swings) -> np.ndarray:
    """The frequencies at zero angles where nothing holds the base, Hz."""
    text = ET.tostring(case.flown, encoding="unicode")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    H = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, H)
    free = [*range(6), *(model.joint(name).dofadr[0] for name in case.hz)]
    inverse = np.linalg.inv(H[np.ix_(free, free)])[6:, 6:]
    K = [model.joint(name).stiffness[0] for name in case.hz]
    return np.sqrt(np.linalg.eigvals(inverse * K).real) / (2 * np.pi)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("two of one make at 0.5 Hz", 0.02),
        ("two at 0.3 and 1 Hz", 0.02),
        # Ten swings in a flight, which the joints' motion forces.
        ("fuel about one axis", 0.06),
        # The frequency changes with the pose, by a tenth.
        ("elbow at 1 Hz", 0.05),
        ("elbow at 3 Hz", 0.05),
    ],
)
def test_a_ring_is_named_with_its_frequency(tmp_path: Path, name: str, near: float):
    case, named = CASES[name](), 0
    (tmp_path / "rigid").mkdir()
    for seed in range(SEEDS):
        recording = recorded(robot_of(case, tmp_path, 1.0), case, seed, tmp_path)
        robot = by_cad(
            robot_of(rigid(case), tmp_path / "rigid", 1.0), np.random.default_rng(seed)
        )
        words = identify(robot, recording).with_causes().refusal()
        print(seed, words, floating(case), flush=True)
        found = re.search(r"rings at (\S+) Hz", words)
        off = np.abs(float(found[1]) / floating(case) - 1) if found else np.inf
        named += bool(np.min(off) < near)
    assert named >= NAMED * SEEDS
