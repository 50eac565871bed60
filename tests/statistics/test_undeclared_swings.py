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
from orbident.recordings.recording import Recording

NAMED, NEAR = 0.9, 0.02
"""Part of the flights in which the ring is named, and how far it may be off."""


def rigid(case: Swings) -> Swings:
    """The robot as its file declares nothing that swings."""
    model = deepcopy(case.model)
    for body in model.iter("body"):
        for joint in body.findall("joint"):
            if joint.get("name") in case.declared.get("passive", {}):
                body.remove(joint)
    return case._replace(model=model, declared={})


def floating(case: Swings, recording: Recording) -> np.ndarray:
    """The frequencies where nothing holds the base, Hz: means over the poses flown.

    A pose changes that of the elbow by a tenth. What wheels' momentum adds is left out:
    half a per cent of that of fuel.
    """
    text = ET.tostring(case.flown, encoding="unicode")
    model = mujoco.MjModel.from_xml_string(text)
    data, H = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    free = [*range(6), *(model.joint(name).dofadr[0] for name in case.hz)]
    K = [model.joint(name).stiffness[0] for name in case.hz]
    arm = ["shoulder", "elbow"]
    places = [model.joint(name).qposadr[0] for name in arm]
    poses = np.column_stack(
        [recording.columns[f"joint.{name}.position"][::25] for name in arm]
    )
    found = []
    for q in poses:
        data.qpos[places] = q
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, H)
        inverse = np.linalg.inv(H[np.ix_(free, free)])[6:, 6:]
        squares = np.sort(np.linalg.eigvals(inverse * K).real)
        found.append(np.sqrt(squares) / (2 * np.pi))
    return np.mean(found, axis=0)


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_a_ring_is_named_with_its_frequency(tmp_path: Path, name: str):
    case, named = CASES[name](), 0
    (tmp_path / "rigid").mkdir()
    for seed in range(SEEDS):
        recording = recorded(robot_of(case, tmp_path, 1.0), case, seed, tmp_path)
        robot = by_cad(
            robot_of(rigid(case), tmp_path / "rigid", 1.0), np.random.default_rng(seed)
        )
        words = identify(robot, recording).with_causes().refusal()
        found = re.search(r"(rings|swung) at (\S+) Hz", words)
        # Of a joint that gives way, the frequency is that which its file would declare.
        rings = found and found[1] == "rings"
        true = floating(case, recording) if rings else np.array([*case.hz.values()])
        print(seed, words, true, flush=True)
        off = np.abs(float(found[2]) / true - 1) if found else np.inf
        named += bool(np.min(off) < NEAR)
    assert named >= NAMED * SEEDS
