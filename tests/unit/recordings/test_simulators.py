"""Recordings of simulators: MuJoCo itself, and what recorders of Basilisk hold."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from pages import ROOT
from random_motions import random_motion
from scipy.spatial.transform import Rotation

import orbident as oi
from orbident.robot.description import Robot

EXAMPLE = ROOT / "examples/mujoco-panels"
S = [0.3, -0.2, 0.5]
T = np.arange(20) / 10


@pytest.fixture(scope="module")
def robot() -> Robot:
    """The satellite of the example; S is not at the origin of its base."""
    text = (EXAMPLE / "satellite.yaml").read_text()
    text = text.replace("satellite.xml", str(EXAMPLE / "satellite.xml"))
    return oi.load_robot({**yaml.safe_load(text), "feature_point": S})


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_file(str(EXAMPLE / "satellite.xml"))
    spec.body("base").add_site(name="S", pos=S)
    return spec.compile()


@pytest.fixture(scope="module")
def rows(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """States drawn at random."""
    random = np.random.default_rng(3)
    qpos = random.standard_normal((T.size, model.nq))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    return qpos, random.standard_normal((T.size, model.nv))


def test_sensors_show_what_mujoco_says_of_a_site(
    robot: Robot, model: mujoco.MjModel, rows: tuple[np.ndarray, np.ndarray]
):
    recording = oi.Recording.from_mujoco(robot, model, T, *rows)
    data, twist = mujoco.MjData(model), np.zeros(6)
    site = model.site("S").id
    # Rounding of some operations on numbers of about 1.
    exact: dict[str, Any] = {"rtol": 0, "atol": 1e-13}
    for k, (x, v) in enumerate(zip(*rows, strict=True)):
        data.qpos, data.qvel = x, v
        mujoco.mj_forward(model, data)
        for local, name in ((0, "velocity"), (1, "gyro")):
            kind = mujoco.mjtObj.mjOBJ_SITE
            mujoco.mj_objectVelocity(model, data, kind, site, twist, local)
            shown = twist[3:] if name == "velocity" else twist[:3]
            np.testing.assert_allclose(recording.vector(name)[k], shown, **exact)
        place = recording.vector("position")[k]
        np.testing.assert_allclose(place, data.site_xpos[site], **exact)
        R_WB = Rotation.from_quat(recording.vector("attitude")[k]).as_matrix()
        np.testing.assert_allclose(R_WB.ravel(), data.site_xmat[site], **exact)
        for name in ("shoulder", "elbow"):
            joint = data.joint(name)
            assert recording.column(f"joint.{name}.position")[k] == joint.qpos[0]
            assert recording.column(f"joint.{name}.velocity")[k] == joint.qvel[0]
        for name in ("wheel_x", "wheel_y", "wheel_z"):
            speed = recording.column(f"wheel.{name}.speed")[k]
            assert speed == data.joint(name).qvel[0]
    # Nobody measures a panel.
    assert not any("panel" in name for name in recording.columns)


def test_what_mujoco_has_not_logged(
    robot: Robot, model: mujoco.MjModel, rows: tuple[np.ndarray, np.ndarray]
):
    qpos, qvel = rows
    with pytest.raises(oi.InputError, match=r"qpos has shape \(20, 13\); .* by 14"):
        oi.Recording.from_mujoco(robot, model, T, qvel, qvel)
    other = oi.load_robot("paper-spatial")
    with pytest.raises(oi.InputError, match="no joint 'joint1', only 'wheel_x'"):
        oi.Recording.from_mujoco(other, model, T, qpos, qvel)
    fixed = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(oi.InputError, match="has 0 free joints"):
        oi.Recording.from_mujoco(
            robot, fixed, T, np.zeros((T.size, 0)), np.zeros((T.size, 0))
        )


def recorder(t: np.ndarray = T, **fields: np.ndarray) -> Any:
    """What a recorder of Basilisk's messages has: times in ns, and arrays."""
    return SimpleNamespace(times=lambda: (t * 1e9).astype(np.uint64), **fields)


@pytest.fixture
def spacecraft() -> dict[str, Any]:
    """Recorders of `paper-spatial`, whose room for wheels is 36, as Basilisk's."""
    random = np.random.default_rng(5)
    draw = random.standard_normal
    speeds = np.zeros((T.size, 36))
    speeds[:, :3] = draw((T.size, 3))
    x_BN = Rotation.random(T.size, random)
    names = ("omega_BN_B", "r_BN_N", "v_BN_N")
    vectors = {name: draw((T.size, 3)) for name in names}
    joint = {"theta": draw(T.size), "thetaDot": draw(T.size)}
    return {
        "states": recorder(sigma_BN=x_BN.as_mrp(), **vectors),
        "wheels": recorder(wheelSpeeds=speeds),
        "joints": [recorder(**joint) for _ in range(3)],
    }


def test_recorders_of_basilisk(spacecraft: dict[str, Any]):
    found = oi.Recording.from_basilisk(oi.load_robot("paper-spatial"), **spacecraft)
    states, robot = spacecraft["states"], oi.load_robot("paper-spatial")
    # Times are whole ns.
    np.testing.assert_allclose(found.t, T, rtol=0, atol=1e-9)
    x = Rotation.from_quat(found.vector("attitude"))
    # Rounding of a unit quaternion.
    np.testing.assert_allclose(x.as_mrp(), states.sigma_BN, atol=1e-14)
    for name, field in (
        *(("gyro", "omega_BN_B"), ("position", "r_BN_N"), ("velocity", "v_BN_N")),
    ):
        np.testing.assert_array_equal(found.vector(name), getattr(states, field))
    for k, name in enumerate(robot.wheel_names):
        speeds = spacecraft["wheels"].wheelSpeeds[:, k]
        np.testing.assert_array_equal(found.column(f"wheel.{name}.speed"), speeds)
    for name, each in zip(robot.joint_names, spacecraft["joints"], strict=True):
        angles, rates = (f"joint.{name}.{word}" for word in ("position", "velocity"))
        np.testing.assert_array_equal(found.column(angles), each.theta)
        np.testing.assert_array_equal(found.column(rates), each.thetaDot)


def test_a_robot_on_its_table_whose_point_is_beside_the_hub():
    """A planar flight as Basilisk records its hub is identified as it was flown."""
    folder, p_BS = ROOT / "src/orbident/robot/library", np.array([0.1, -0.05, 0.0])
    file = yaml.safe_load((folder / "cepheus-like.yaml").read_text())
    changed = {"urdf": str(folder / file["urdf"]), "feature_point": p_BS.tolist()}
    robot = oi.load_robot({**file, **changed})
    flown = oi.simulate(robot, random_motion(robot, start="spun up"))
    x, w = Rotation.from_quat(flown.vector("attitude")), flown.vector("gyro")
    states = recorder(
        flown.t,
        sigma_BN=x.as_mrp(),
        omega_BN_B=w,
        r_BN_N=flown.vector("position") - x.apply(p_BS),
        v_BN_N=flown.vector("velocity") - x.apply(np.cross(w, p_BS)),
    )
    wheels = recorder(flown.t, wheelSpeeds=flown.column("wheel.rw.speed")[:, None])
    angles, rates = (
        [flown.column(f"joint.{name}.{word}") for name in robot.joint_names]
        for word in ("position", "velocity")
    )
    joints = [
        recorder(flown.t, theta=q, thetaDot=qd)
        for q, qd in zip(angles, rates, strict=True)
    ]
    found = oi.Recording.from_basilisk(robot, states, wheels, joints)
    for name in ("position", "velocity"):
        np.testing.assert_allclose(found.vector(name), flown.vector(name), atol=1e-13)
    result = oi.identify(robot, found, "least-squares", initial_momentum="at-rest")
    assert float(result.mass) == pytest.approx(robot.mass, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"joints": []}, "recorders of 0 joints, and the robot has 3"),
        ({"wheels": None}, "recorders of 0 wheels, and the robot has 3"),
        ({"wheels": recorder(wheelSpeeds=np.ones((20, 4)))}, "of 4 wheels"),
        ({"wheels": recorder(T + 1, wheelSpeeds=np.ones((20, 3)))}, "other times"),
    ],
)
def test_recorders_that_are_not_the_robots(
    spacecraft: dict[str, Any], change: dict[str, Any], words: str
):
    with pytest.raises(oi.InputError, match=words):
        oi.Recording.from_basilisk(
            oi.load_robot("paper-spatial"), **{**spacecraft, **change}
        )
