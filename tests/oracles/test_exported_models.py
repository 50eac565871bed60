"""Files and objects for other tools are the identified robot, as those tools read them.

Of robots whose nominal bodies are off by a fifth, Pinocchio and MuJoCo must find the
mass, the CM, `H+` (whose parts are `D`, `D_q` and the wheels' inertia) and `c+` of
`result.dynamics()`, and the momentum in random states.
"""

# Pinocchio and MuJoCo are compiled, and have no stubs for what they export.
# pyright: reportAttributeAccessIssue=false

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from made_results import exact_result
from pinocchio_model import paper_equations
from servicer import load_servicer

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.exported_robot import Mechanism, exported_robot
from orbident.identified.simulator_models import basilisk_script, mjcf, sdf
from orbident.model.core_robot import wheels_of
from orbident.model.equations_of_motion import movable
from orbident.model.kinematics import inertia_at
from orbident.model.reconstruction import Dynamics
from orbident.robot.description import NO_ROTOR, GearedRotor, Robot
from orbident.robot.parameters import inertia_about_com
from orbident.robot.robot_file import load_robot
from orbident.studies.control import off_by

ROBOTS = ("paper-spatial", "cepheus-like", "dual-arm", "rotor-links", "geared")

STATES = 5

# The solver meets `beta` to rounding, of sums over bodies: 1e-12 of the largest entry
# (`test_physical_bodies`); eigenvectors of inertias and sums over the tree add to it.
EXACT = 1e-10


class Case(NamedTuple):
    """A result, and what is exported of it."""

    result: Result
    dynamics: Dynamics
    mechanism: Mechanism

    @property
    def joints(self) -> list[str]:
        """The robot's joints and wheels, as the tools name them."""
        return [joint.name for joint in self.mechanism.joints]


class State(NamedTuple):
    q: np.ndarray
    v: np.ndarray
    """`[v_cm, w, qd, qd_rw]`, base axes."""


@pytest.fixture(scope="module", params=ROBOTS)
def case(request: pytest.FixtureRequest, tmp_path_factory) -> Case:
    if request.param == "rotor-links":
        true = load_servicer(tmp_path_factory.mktemp("servicer"))
    elif request.param == "geared":
        motors = GearedRotor(160.0, 1e-4), GearedRotor(-100.0, 1e-4), NO_ROTOR
        true = load_robot("paper-spatial")
        rotors = dict(zip(true.joint_names, motors, strict=True))
        true = replace(true, rotors=rotors)
    else:
        true = load_robot(request.param)
    result = replace(exact_result(true), robot=off_by(true, 0.2, seed=1))
    return Case(result, result.dynamics(), exported_robot(result))


@pytest.fixture(scope="module")
def states(case: Case) -> list[State]:
    robot, random = case.result.robot, np.random.default_rng(3)
    q = random.standard_normal((STATES, len(robot.joints)))
    v = random.standard_normal((STATES, 6 + len(case.joints)))
    return [
        State(*map(np.asarray, each))
        for each in zip(q, v * movable(robot), strict=True)
    ]


def shown(case: Case, entries: np.ndarray) -> np.ndarray:
    """The entries of the speeds that the robot has: in the plane, three less."""
    may = movable(case.result.robot)
    return entries[np.ix_(*(entries.ndim * (may,)))]


def assert_close(found: np.ndarray, true: np.ndarray) -> None:
    scale = np.abs(true).max(initial=0.0)
    np.testing.assert_allclose(found, true, rtol=0, atol=EXACT * scale)


def check_by_pinocchio(case: Case, states: Sequence[State], model: pin.Model) -> None:
    """Pinocchio finds `H+` and `c+` of `result.dynamics()`, and the CM."""
    for q, v in states:
        at = np.append(q, np.zeros(len(case.result.robot.wheels)))
        H, c = paper_equations(model, case.joints, at, v)
        assert_close(H, shown(case, case.dynamics.H_plus(q)))
        assert_close(c, shown(case, case.dynamics.c_plus(q, v)))


def test_the_wheels_are_bodies(case):
    """What they add to the base is what it lacks; all can exist."""
    robot = case.result.robot
    assert len(case.joints) == len(robot.joints) + len(robot.wheels)
    for theta_i in case.mechanism.theta:
        I = inertia_about_com(theta_i)
        a, b, c = np.linalg.eigvalsh(I)
        assert theta_i[0] > 0
        # A rotor that is a thin disc is on the border: rounding.
        assert a > 0
        assert a + b > c * (1 - 1e-14)
    rotors = case.mechanism.theta[len(robot.bodies) :]
    for wheel, theta_i in zip(robot.wheels, rotors, strict=True):
        I = inertia_about_com(theta_i)
        assert wheel.axis @ I @ wheel.axis == pytest.approx(wheel.inertia, rel=1e-12)


def test_pinocchio_object(case, states):
    model = case.result.to_pinocchio()
    assert model.nv == len(case.joints) + model.joints[1].nv
    S = model.frames[model.getFrameId("feature_point")]
    assert S.placement.translation == pytest.approx(case.result.robot.feature_point)
    check_by_pinocchio(case, states, model)


def test_mjcf_read_by_pinocchio(case, states, tmp_path):
    if case.result.robot.motion == "planar":
        pytest.skip("Pinocchio makes three joints of the plane's, not one root")
    path = tmp_path / "robot.xml"
    path.write_text(mjcf(case.mechanism))
    model = pin.buildModelFromMJCF(str(path))
    model.gravity.linear = np.zeros(3)
    check_by_pinocchio(case, states, model)


def test_sdf(case, states):
    """Its links, joints and poses make the same model; S is a frame."""
    text = sdf(case.mechanism)
    planar = case.result.robot.motion == "planar"
    model = model_of_sdf(text, planar)
    # The format has no place for it, which the file says.
    assert case.mechanism.armature.any() == ("has no place" in text)
    model.armature[-len(case.joints) :] = case.mechanism.armature
    check_by_pinocchio(case, states, model)
    frame = ET.fromstring(text).find(".//frame[@name='feature_point']/pose")
    assert numbers(frame)[:3] == pytest.approx(case.result.robot.feature_point)


def model_of_sdf(text: str, planar: bool) -> pin.Model:
    """A slow reader of what is written of the format: poses are in the model's frame.

    Drake, which reads SDF by the format's own library, was tried beside it (see
    decision 11), and does so here where it is installed.
    """
    root = ET.fromstring(text)
    at = {link.get("name"): pose_of(link) for link in root.iter("link")}
    model = pin.Model()
    model.gravity.linear = np.zeros(3)
    free = pin.JointModelPlanar() if planar else pin.JointModelFreeFlyer()
    base = next(root.iter("link")).get("name")
    index = {base: model.addJoint(0, free, at[base], "root_joint")}
    for joint in root.iter("joint"):
        parent, child = joint.findtext("parent"), joint.findtext("child")
        turns = joint.get("type") == "revolute"
        kind = (
            pin.JointModelRevoluteUnaligned
            if turns
            else (pin.JointModelPrismaticUnaligned)
        )
        axis = np.array(numbers(joint.find("axis/xyz")))
        placed = at[parent].inverse() * at[child]
        index[child] = model.addJoint(
            index[parent], kind(axis), placed, joint.get("name")
        )
    for link in root.iter("link"):
        inertial = link.find("inertial")
        assert inertial is not None
        I = np.zeros((3, 3))
        for a, b in np.ndindex(3, 3):
            key = "".join(sorted(("xyz"[a], "xyz"[b])))
            I[a, b] = numbers(inertial.find(f"inertia/i{key}"))[0]
        mass = numbers(inertial.find("mass"))[0]
        com = np.array(numbers(inertial.find("pose"))[:3])
        body = pin.Inertia(mass, com, I)
        model.appendBodyToJoint(index[link.get("name")], body, pin.SE3.Identity())
    return model


def pose_of(link: ET.Element) -> pin.SE3:
    x, y, z, *angles = numbers(link.find("pose"))
    return pin.SE3(pin.rpy.rpyToMatrix(*angles), np.array([x, y, z]))


def numbers(element: ET.Element | None) -> list[float]:
    assert element is not None
    return [float(word) for word in (element.text or "").split()]


def test_sdf_read_by_drake(case, states, tmp_path):
    """Mass, CM and momentum, by libsdformat."""
    pydrake = pytest.importorskip("pydrake.all", reason="pip install drake")
    if case.result.robot.motion == "planar":
        pytest.skip("a robot on a table turns about one axis only")
    path = tmp_path / "robot.sdf"
    path.write_text(sdf(case.mechanism))
    plant = pydrake.MultibodyPlant(0.0)
    pydrake.Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    robot = case.dynamics.robot
    base = plant.GetBodyByName(robot.bodies[0])
    for q, v in states:
        n = q.size
        plant.SetFreeBodyPose(context, base, pydrake.RigidTransform())
        moved = pydrake.SpatialVelocity(w=v[3:6], v=np.zeros(3))
        plant.SetFreeBodySpatialVelocity(context, base, moved)
        for name, at, rate in zip(
            case.joints, [*q, *np.zeros(v.size - 6 - n)], v[6:], strict=True
        ):
            joint = plant.GetJointByName(name)
            joint.set_angle(context, at)
            joint.set_angular_rate(context, rate)
        assert plant.CalcTotalMass(context) == pytest.approx(robot.mass, rel=EXACT)
        r_cm = plant.CalcCenterOfMassPositionInWorld(context)
        found = plant.CalcSpatialMomentumInWorldAboutPoint(context, r_cm)
        assert_close(found.rotational(), momentum(robot, q, v))
        assert_close(r_cm, inertia_at(robot, q).r_cm + robot.feature_point)


def momentum(robot: Robot, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Eqs. 3 and 5 about the system CM, base axes."""
    at, n = inertia_at(robot, q), q.size
    h_rs = at.D @ v[3:6] + at.D_q @ v[6 : 6 + n]
    return h_rs + wheels_of(robot).A_rw @ v[6 + n :]


def test_basilisk_script(case, states):
    """It compiles; where Basilisk is installed, its spacecraft has our momentum."""
    made = exported_robot(case.result)
    code = compile(basilisk_script(made), "spacecraft.py", "exec")
    pytest.importorskip("Basilisk.simulation", reason="pip install bsk")
    if case.result.robot.motion == "planar":
        pytest.skip("a robot on a table turns about one axis only")
    script: dict[str, Any] = {"__name__": "spacecraft"}
    exec(code, script)
    robot = case.dynamics.robot
    for q, v in states:
        n = q.size
        values = (
            dict(zip(names, numbers, strict=True))
            for names, numbers in (
                (robot.joint_names, q),
                (robot.joint_names, v[6 : 6 + n]),
                (robot.wheel_names, v[6 + n :]),
            )
        )
        craft, effectors = script["build"](*values)
        craft.hub.omega_BN_BInit = script["column"](v[3:6])
        before, after = script["fly"](craft, effectors, 0.05, 0.0002)
        assert_close(before, momentum(robot, q, v))
        # RK4 at random rates of 1 rad/s: with steps of 1 ms the worst was 1e-10.
        assert_close(after, before)


def test_basilisk_has_no_such_arms(tmp_path):
    """An arm that branches, and one that slides where it turned before."""
    robot = load_robot("paper-spatial")
    made = exported_robot(exact_result(robot))
    first, second, third = robot.joints
    branched = (first, second, replace(third, parent=1))
    sliding = (first, second, replace(third, kind="prismatic"))
    for joints, words in (
        (branched, "two joints are on body 'link1'"),
        (sliding, "joint 'joint3' slides where"),
    ):
        wrong = made._replace(robot=replace(made.robot, joints=joints))
        with pytest.raises(InputError, match=words):
            basilisk_script(wrong)


def test_mjcf_read_by_mujoco(case, states):
    """Mass, CM, `H+` and momentum of the file, and of the object."""
    spec = case.result.to_mujoco()
    check_by_mujoco(case, states, spec.compile())
    text = mjcf(case.mechanism)
    check_by_mujoco(case, states, mujoco.MjModel.from_xml_string(text))
    assert spec.site("feature_point").pos == pytest.approx(
        case.result.robot.feature_point
    )


def check_by_mujoco(case: Case, states: Sequence[State], model: mujoco.MjModel) -> None:
    robot = case.dynamics.robot
    data, planar = mujoco.MjData(model), robot.motion == "planar"
    root = [0, 1, 5] if planar else list(range(6))
    dofs = [int(model.joint(name).dofadr[0]) for name in case.joints]
    rows = [*range(len(root)), *dofs]
    base = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, robot.bodies[0])
    p_S = robot.feature_point
    for q, v in states:
        at = inertia_at(robot, q)
        # The base link's frame moves with S: v_S = v_cm - w x r_cm - J_cm qd.
        n, w = q.size, v[3:6]
        v_S = v[:3] - np.cross(w, at.r_cm) - at.J_cm @ v[6 : 6 + n]
        data.qpos[:] = 0.0
        if not planar:
            data.qpos[3] = 1.0
        for name, angle in zip(robot.joint_names, q, strict=True):
            data.qpos[model.joint(name).qposadr[0]] = angle
        data.qvel[rows] = [*np.append(v_S - np.cross(w, p_S), w)[root], *v[6:]]
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        assert model.body_subtreemass[base] == pytest.approx(robot.mass, rel=EXACT)
        planes = [2] if planar else [0, 1, 2]
        h = momentum(robot, q, v)
        assert_close(data.subtree_angmom[base][planes], h[planes])
        moved = [0, 1] if planar else [0, 1, 2]
        assert_close(data.subtree_linvel[base][moved], v[moved])
        assert_close(data.subtree_com[base][moved], (at.r_cm + p_S)[moved])
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        J = np.zeros((3, model.nv))
        mujoco.mj_jacSubtreeCom(model, data, J, base)
        T, k = np.eye(len(rows)), len(moved)
        T[:k, k:] = -J[np.ix_(moved, rows[k:])]
        H = T.T @ M[np.ix_(rows, rows)] @ T
        assert_close(H, shown(case, case.dynamics.H_plus(q)))
