"""Joints on springs, flown by MuJoCo: what is identified of them lies in its intervals.

The satellite is that of `examples/mujoco-panels` with other parts on springs. For each
flight masses and inertias of the CAD model are off by 5 %, those of each body by one
factor, and declared frequencies by 20 % either way. Of as many flights of each as
ORBIDENT_SWINGS says (20 by default):

    ORBIDENT_SWINGS=20 pytest -m long -s tests/statistics/test_swinging_intervals.py

What a fit with two panels costs beside one with both welded, where annotations are not
checked at every call, as that takes time, too:

    ORBIDENT_SWINGS=4 pytest --jaxtyping-packages=none,beartype.beartype -m long -s
        -k cost tests/statistics/test_swinging_intervals.py
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from types import MappingProxyType
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
import yaml
from examples import EXAMPLES, identifying

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import GearedRotor, Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.measure import measure_truth

SEEDS = int(os.environ.get("ORBIDENT_SWINGS", "20"))

EXAMPLE = EXAMPLES / "mujoco-panels"

DAMPING = 0.005
"""Over critical damping."""

SURE = 1.96
"""Deviations of a 95 % interval."""

NEAR = 0.01
"""How far frequencies may be off, relative."""

CAD, DECLARED = 0.05, 0.2
"""How far masses and inertias of the CAD model, and declared frequencies, are off."""

COST = 4.0
"""Times the processor's time of a rigid robot."""

JERKS = np.array([12.0, 20.0, 28.0, 36.0, 44.0, 52.0]) / 60
"""When the arm moves by `JERK` beside the example's motion, its joints in turn: shares
of a flight."""

JERK = 0.1
"""rad."""


class Swings(NamedTuple):
    """What swings in MuJoCo, and how it is declared."""

    model: ET.Element
    """Of the robot file."""
    flown: ET.Element
    """Of MuJoCo."""
    declared: Mapping[str, Any]
    """What the robot file says, with frequencies that are right."""
    hz: Mapping[str, float]
    """By joint of what is flown."""
    moved: float = 1.0
    """How much of all motion the arm does."""
    within: float = 0.15
    """How fast jerks are, s."""
    rate: int = 25
    """Hz."""
    duration: float = 60.0
    """s."""
    rotors: Mapping[str, GearedRotor] = MappingProxyType({})
    """That turn in MuJoCo; the robot file says nothing of them."""


def satellite(*, panels: bool) -> ET.Element:
    """The example's, with stiff joints: its arm follows commands."""
    text = (EXAMPLE / "satellite.xml").read_text()
    if not panels:
        text = re.sub(r'\s*<body name="(left|right)".*?</body>', "", text, flags=re.S)
    return ET.fromstring(text)


def on_springs(model: ET.Element, hz: Mapping[str, float]) -> ET.Element:
    """With springs whose frequencies are these with all other joints held at zero."""
    mujoco_model = mujoco.MjModel.from_xml_string(
        ET.tostring(model, encoding="unicode")
    )
    data = mujoco.MjData(mujoco_model)
    mujoco.mj_forward(mujoco_model, data)
    H = np.zeros((mujoco_model.nv, mujoco_model.nv))
    mujoco.mj_fullM(mujoco_model, data, H)
    for joint in model.iter("joint"):
        name = joint.get("name", "")
        if name in hz:
            at = mujoco_model.joint(name).dofadr[0]
            rate = 2 * np.pi * hz[name]
            joint.set("stiffness", repr(float(H[at, at] * rate**2)))
            joint.set("damping", repr(float(2 * DAMPING * rate * H[at, at])))
    return model


def declared_as(hz: Mapping[str, float]) -> dict[str, dict[str, Any]]:
    """What a robot file says of joints with these frequencies."""
    return {name: {"frequency": each, "inertia": CAD} for name, each in hz.items()}


def panels(left: float, right: float, *, one_make: bool) -> Swings:
    """The example's, at these frequencies, Hz."""
    hz = {"panel_left": left, "panel_right": right}
    model = on_springs(satellite(panels=True), hz)
    declared = declared_as(hz)
    if one_make:
        declared["panel_right"] = {"like": "panel_left", "inertia": CAD}
    return Swings(model, model, {"passive": declared}, hz)


def fuel(hinges: str, hz: float) -> Swings:
    """Fuel of 5 % of the mass as a pendulum, about one axis of the base or two."""
    model = satellite(panels=False)
    base = model.find("worldbody/body")
    assert base is not None
    body = ET.SubElement(base, "body", name="fuel", pos="0.1 0.05 -0.2")
    axes = {"x": "1 0 0", "y": "0 1 0"}
    for k in hinges:
        ET.SubElement(body, "joint", name=f"fuel_{k}", axis=axes[k])
    ET.SubElement(
        body, "inertial", pos="0 0 -0.4", mass="7.6", diaginertia="0.05 0.05 0.05"
    )
    first, *others = (f"fuel_{k}" for k in hinges)
    springs = dict.fromkeys([first, *others], hz)
    model = on_springs(model, springs)
    declared = declared_as({first: hz})
    declared |= {name: {"like": first, "inertia": CAD} for name in others}
    massless = {f"{first}_link": {"massless": True}} if others else {}
    said = {"passive": declared, "structure": massless}
    return Swings(model, model, said, springs, moved=0.2)


def flexible(joints: Sequence[str], hz: float, rate: int, within: float) -> Swings:
    """Joints of the arm behind whose motors is a spring; encoders are on motors."""
    flown = satellite(panels=False)
    for body in list(flown.iter("body")):
        joint = body.find("joint")
        if joint is None or (name := joint.get("name", "")) not in joints:
            continue
        link = ET.Element("body", name=body.get("name", ""))
        ET.SubElement(
            link, "joint", name=f"{name}'s flexibility", axis=joint.get("axis", "")
        )
        for part in list(body)[1:]:
            body.remove(part)
            link.append(part)
        body.set("name", f"{name}'s motor")
        # MuJoCo moves no body without mass. An armature is of no momentum.
        joint.set("armature", "1")
        ET.SubElement(
            body, "inertial", pos="0 0 0", mass="1e-6", diaginertia="1e-6 1e-6 1e-6"
        )
        body.append(link)
    for motor in flown.iter("position"):
        motor.set("kp", "20000")
        motor.set("kv", "600")
    springs = {f"{name}'s flexibility": hz for name in joints}
    declared = declared_as(dict.fromkeys(joints, hz))
    return Swings(
        satellite(panels=False),
        on_springs(flown, springs),
        # An armature has no momentum.
        {"flexible": declared, "rotors": "none"},
        springs,
        rate=rate,
        within=within,
        duration=30.0,
    )


GEAR, ROTOR = 100.0, 1e-3
"""Of a motor: its rotor, kg m^2, has 10 kg m^2 on the joint's side."""


def geared(hz: float, rate: int, within: float) -> Swings:
    """An elbow on a spring behind a geared motor, whose rotor is a body in MuJoCo."""
    case = flexible(["elbow"], hz, rate, within)
    flown, rotor = case.flown, "elbow's rotor"
    (upper,) = (x for x in flown.iter("body") if x.get("name") == "upper")
    for joint in flown.iter("joint"):
        if joint.get("name") == "elbow":
            del joint.attrib["armature"]
    # About y, and symmetric. At rest it is part of the body that carries it.
    I = ROTOR * np.array([0.6, 1.0, 0.6])
    inertial = upper.find("inertial")
    assert inertial is not None
    whole = np.fromstring(inertial.get("diaginertia", ""), sep=" ")
    inertial.set("diaginertia", " ".join(map(str, whole - I)))
    body = ET.SubElement(upper, "body", name=rotor, pos="0 0 0.75")
    ET.SubElement(body, "joint", name=rotor, axis="0 1 0")
    own = {"mass": "1e-6", "diaginertia": " ".join(map(str, I))}
    ET.SubElement(body, "inertial", own, pos="0 0 0")
    stiff = {"solref": "0.004 1", "solimp": "0.999 0.9999 0.001"}
    both = {"joint1": rotor, "joint2": "elbow", "polycoef": f"0 {GEAR} 0 0 0"}
    ET.SubElement(ET.SubElement(flown, "equality"), "joint", both | stiff)
    declared = {"flexible": case.declared["flexible"]}
    rotors = {"elbow": GearedRotor(GEAR, ROTOR, 0.0)}
    return case._replace(declared=declared, rotors=rotors)


CASES = {
    "two of one make at 0.5 Hz": lambda: panels(0.5, 0.5, one_make=True),
    "two at 0.3 and 1 Hz": lambda: panels(0.3, 1.0, one_make=False),
    "fuel about one axis": lambda: fuel("y", 0.15),
    "fuel about two axes": lambda: fuel("xy", 0.15),
    "elbow at 1 Hz": lambda: flexible(["elbow"], 1.0, 50, 0.15),
    "elbow at 3 Hz": lambda: flexible(["elbow"], 3.0, 50, 0.1),
    "elbow at 10 Hz": lambda: flexible(["elbow"], 10.0, 100, 0.05),
    "elbow at 3 Hz, geared": lambda: geared(3.0, 50, 0.1),
    "all joints at 3 Hz": lambda: flexible(["shoulder", "elbow"], 3.0, 50, 0.1),
}


def robot_of(case: Swings, folder: Path, off: float) -> Robot:
    """As its file declares it: frequencies are off."""
    ET.ElementTree(case.model).write(folder / "satellite.xml")
    document = yaml.safe_load((EXAMPLE / "satellite.yaml").read_text())
    del document["passive"]
    document["sensors"]["rate"] = case.rate
    for section, said in case.declared.items():
        document[section] = said
        if isinstance(said, Mapping):
            document[section] = {
                name: {k: off * x if k == "frequency" else x for k, x in each.items()}
                for name, each in said.items()
            }
    (folder / "satellite.yaml").write_text(yaml.safe_dump(document))
    return load_robot(folder / "satellite.yaml")


def by_cad(true: Robot, random: np.random.Generator) -> Robot:
    """With masses and inertias that are off; of what is of one make by one factor."""
    scale = 1 + CAD * random.standard_normal(len(true.bodies))
    at = {joint.name: k for k, joint in enumerate(true.joints, 1)}
    for name, each in true.passive.items():
        if each.like:
            scale[at[name]] = scale[at[each.like]]
    return replace(true, theta=true.theta * scale[:, None])


def recorded(true: Robot, case: Swings, seed: int, folder: Path) -> Recording:
    """A flight, of which nobody measures what swings."""
    example = identifying("mujoco-panels")
    ET.ElementTree(case.flown).write(folder / "flown.xml")
    smooth = example.commanded
    part = np.array([case.moved, case.moved, 1, 1, 1])

    def commanded(t: float) -> np.ndarray:
        steps = JERK / 2 * (1 + np.tanh((t - case.duration * JERKS) / case.within))
        jerked = np.array([steps[::2].sum(), steps[1::2].sum(), 0, 0, 0])
        return part * (smooth(t) + jerked)

    example.commanded = commanded
    example.DURATION = case.duration
    example.EVERY = round(500 / case.rate)
    t, truth = example.flown(true, folder / "flown.xml")
    shown = measure_truth(true, t, truth, seed)
    columns = {
        name: x
        for name, x in shown.columns.items()
        if not any(joint in name for joint in true.passive)
    }
    return Recording(shown.t, columns, "flight")


def scores(result: Result, true: Robot, case: Swings) -> tuple[list, list, list]:
    """What was found less what is true: base parameters and springs in deviations.

    The last are frequencies, relative.
    """
    beta = minimal_sets(replace(true, rotors=case.rotors)).beta(true.theta)
    of_base = (result.base.values - beta) / result.base.std
    springs = [(fit, case.hz[name]) for name, fit in result.springs.items()]
    of_springs = [
        z
        for fit, hz in springs
        for z in (
            (fit.frequency - hz) / fit.frequency_std,
            (fit.damping - DAMPING) / fit.damping_std,
        )
    ]
    off = [fit.frequency / hz - 1 for fit, hz in springs]
    return of_base.tolist(), of_springs, off


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_swings_lie_in_their_intervals(tmp_path, name):
    case, found = CASES[name](), []
    for seed in range(SEEDS):
        true = robot_of(case, tmp_path, 1 + DECLARED * (-1) ** seed)
        robot = by_cad(true, np.random.default_rng(seed))
        result = identify(robot, recorded(true, case, seed, tmp_path))
        if result.status != "ok":
            print(seed, result.refusal())
            continue
        found.append(scores(result, true, case))
        worst, off = (np.abs(found[-1][k]).max() for k in (0, 2))
        print(f"{seed}: worst {worst:.2f}, frequency off by {off:.3%}", flush=True)
    of_base, of_springs, off = (np.abs(each) for each in zip(*found, strict=True))
    inside = np.mean(of_base < SURE)
    print(
        f"{name}: accepted {len(found)} of {SEEDS}; of {of_base.size} base parameters"
    )
    print(
        f"{inside:.1%} inside, worst {of_base.max():.2f}; of frequencies and dampings"
    )
    print(f"{np.mean(of_springs < SURE):.1%}, worst {of_springs.max():.2f};")
    print(f"frequencies off by {off.max():.3%} at most", flush=True)
    assert len(found) >= 0.95 * SEEDS
    assert off.max() < NEAR
    # Numbers of one flight are correlated: three deviations of 95 %.
    assert abs(inside - 0.95) < 3 * np.sqrt(0.95 * 0.05 / of_base.size * 4)


def welded() -> Swings:
    """The satellite whose panels do not swing."""
    model = satellite(panels=True)
    for body in model.iter("body"):
        if body.get("name") in ("left", "right"):
            for joint in body.findall("joint"):
                body.remove(joint)
    return Swings(model, model, {}, {})


def seconds_of(case: Swings, seed: int, folder: Path) -> float:
    """CPU of ``identify`` on one flight of ``case``, seconds."""
    true = robot_of(case, folder, 1 + DECLARED * (-1) ** seed)
    robot = by_cad(true, np.random.default_rng(seed))
    recording = recorded(true, case, seed, folder)
    # The first one also reads what the next has at hand.
    identify(robot, recording)
    began = process_time()
    identify(robot, recording)
    return process_time() - began


@pytest.mark.long
@pytest.mark.parametrize("name", [*CASES][:2])
def test_two_panels_cost_at_most_four_times_as_much(tmp_path, name):
    ratios = []
    for seed in range(SEEDS):
        swinging, rigid = (
            seconds_of(case, seed, tmp_path) for case in (CASES[name](), welded())
        )
        ratios.append(swinging / rigid)
        print(f"{name}: {swinging:.2f} s, {ratios[-1]:.2f} times", flush=True)
    assert np.median(ratios) < COST
