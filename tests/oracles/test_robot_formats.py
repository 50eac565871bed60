"""One robot as URDF, MJCF and SDF: we read what MuJoCo, Pinocchio and Drake read."""

# All three are compiled, and have no stubs or none that say what they export.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from one_state import only_state
from robot_parts import mjcf_of, random_parts, sdf_of, urdf_of
from scipy.spatial.transform import Rotation

from orbident.model.kinematics import Poses, momentum_regressors, poses
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com
from orbident.robot.robot_file import load_robot

SEEDS = range(8)

# Files have 17 digits, and a chain of seven rotations of 1e-16 each multiplies lengths
# and inertias of some tens: 3e-14 is the worst seen.
TOLERANCE = 1e-12


def read(folder: Path, name: str, text: str) -> Robot:
    (folder / name).write_text(text)
    return load_robot(folder / name)


def close(one: object, other: object) -> None:
    found, expected = np.asarray(one, float), np.asarray(other, float)
    np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE)


def state(robot: Robot, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint positions and rates, and the base's angular velocity."""
    random = np.random.default_rng(seed)
    n = len(robot.joints)
    return (
        random.uniform(-1, 1, n),
        random.standard_normal(n),
        random.standard_normal(3),
    )


def momentum(
    robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """By the regressors: linear, and angular about the CM; S is at rest."""
    regressors = only_state(momentum_regressors(robot, q[None], qd[None], w[None]))
    S, P, A = (regressor @ robot.theta.ravel() for regressor in regressors)
    return P, A - np.cross(S, P) / robot.mass


def ours_at(robot: Robot, q: np.ndarray) -> Poses:
    return only_state(poses(robot, q[None]))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("other", ["robot.xml", "robot.sdf"])
def test_the_same_robot_from_every_format(tmp_path: Path, seed: int, other: str):
    parts = random_parts(seed)
    write = {"robot.xml": mjcf_of, "robot.sdf": sdf_of}[other]
    one = read(tmp_path, "robot.urdf", urdf_of(parts))
    robot = read(tmp_path, other, write(parts, seed))
    assert robot.joint_names == one.joint_names
    # The frame of a body without mass is another one in MJCF, and moves nothing else.
    seen = [
        k for k, theta in enumerate(one.theta) if theta[0] > 0 or other != "robot.xml"
    ]
    assert len(seen) >= len(one.bodies) - 1
    close(robot.theta[seen], one.theta[seen])
    for k, (mine, given) in enumerate(zip(robot.joints, one.joints, strict=True)):
        assert (mine.kind, mine.parent, mine.position) == (
            given.kind, given.parent, given.position,
        )  # fmt: skip
        if {k + 1, given.parent} <= set(seen):
            close(mine.axis, given.axis)
            close(mine.R_PJ, given.R_PJ)
            close(mine.p_PJ, given.p_PJ)
    assert [joint.velocity for joint in robot.joints] == [
        None if other == "robot.xml" else joint.velocity for joint in one.joints
    ]
    q, qd, w = state(one, seed)
    columns = [10 * k + i for k in seen for i in range(10)]
    for mine, given in zip(
        *(
            momentum_regressors(each, q[None], qd[None], w[None])
            for each in (robot, one)
        ),
        strict=True,
    ):
        close(mine[..., columns], given[..., columns])


@pytest.mark.parametrize("seed", SEEDS)
def test_mjcf_as_mujoco_has_it(tmp_path: Path, seed: int):
    text = mjcf_of(random_parts(seed), seed)
    robot = read(tmp_path, "robot.xml", text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    q, qd, w = state(robot, seed)
    data.qvel[3:6] = w
    for name, value, rate in zip(robot.joint_names, q, qd, strict=True):
        data.qpos[model.joint(name).qposadr] = value
        data.qvel[model.joint(name).dofadr] = rate
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_subtreeVel(model, data)
    P, about_CM = momentum(robot, q, qd, w)
    close(P, robot.mass * data.subtree_linvel[0])
    close(about_CM, data.subtree_angmom[0])
    at = ours_at(robot, q)
    for k, joint in enumerate(robot.joints):
        theirs = model.joint(joint.name)
        # MuJoCo's anchor of a slide stays where it is drawn.
        slid = (q[k] - model.qpos0[theirs.qposadr]) * (joint.kind == "prismatic")
        close(at.d[k + 1], data.xanchor[theirs.id] + slid * data.xaxis[theirs.id])
        close(at.R[k + 1] @ joint.axis, data.xaxis[theirs.id])
    close(robot.mass, model.body_subtreemass[0])
    for k, name in enumerate(robot.bodies):
        if robot.theta[k, 0] == 0:
            continue
        mass, com, I = of_the_group(model, data, name)
        close(robot.theta[k, 0], mass)
        close(at.d[k] + at.R[k] @ robot.theta[k, 1:4] / mass, com)
        close(at.R[k] @ inertia_about_com(robot.theta[k]) @ at.R[k].T, I)


def of_the_group(
    model: mujoco.MjModel, data: mujoco.MjData, name: str
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, CM and inertia about it of a body and what is welded to it, world axes."""
    group = [
        b for b in range(1, model.nbody)
        if model.body_weldid[b] == model.body(name).id
    ]  # fmt: skip
    masses, coms = model.body_mass[group], data.xipos[group]
    com = masses @ coms / masses.sum()
    I = np.zeros((3, 3))
    for b, mass, at in zip(group, masses, coms, strict=True):
        R, r = data.ximat[b].reshape(3, 3), at - com
        I += R @ np.diag(model.body_inertia[b]) @ R.T
        I += mass * (r @ r * np.eye(3) - np.outer(r, r))
    return masses.sum(), com, I


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", ["urdf", "written", "mjcf"])
def test_as_pinocchio_has_it(tmp_path: Path, seed: int, kind: str):
    """Its readers of URDF and MJCF, and what we write of an SDF file, by the former."""
    parts = random_parts(seed)
    floats = pin.JointModelFreeFlyer()
    if kind == "mjcf":
        # Pinocchio makes one joint of two that move the same body.
        parts[2] = parts[2]._replace(mass=1.0, moments=np.ones(3))
        robot = read(tmp_path, "robot.xml", mjcf_of(parts, moved=False))
        model = pin.buildModelFromMJCF(str(tmp_path / "robot.xml"))
    elif kind == "urdf":
        robot = read(tmp_path, "robot.urdf", urdf_of(parts))
        model = pin.buildModelFromXML(robot.urdf, floats)
    else:
        robot = read(tmp_path, "robot.sdf", sdf_of(parts, seed))
        model = pin.buildModelFromXML(robot.urdf, floats)
    data = model.createData()
    q, qd, w = state(robot, seed)
    configuration, rates = pin.neutral(model), np.zeros(model.nv)
    rates[3:6] = w
    for name, value, rate in zip(robot.joint_names, q, qd, strict=True):
        joint = model.joints[model.getJointId(name)]
        configuration[joint.idx_q], rates[joint.idx_v] = value, rate
    pin.computeJointJacobians(model, data, configuration)
    pin.computeCentroidalMomentum(model, data, configuration, rates)
    P, about_CM = momentum(robot, q, qd, w)
    close(P, data.hg.linear)
    close(about_CM, data.hg.angular)
    at = ours_at(robot, q)
    for k, joint in enumerate(robot.joints, start=1):
        j = model.getJointId(joint.name)
        close(at.d[k], data.oMi[j].translation)
        twist = data.J[:, model.joints[j].idx_v]
        axis = twist[3:] if joint.kind == "revolute" else twist[:3]
        close(at.R[k] @ joint.axis, axis)
        if robot.theta[k, 0]:
            close(at.R[k], data.oMi[j].rotation)
            close(robot.theta[k], model.inertias[j].toDynamicParameters())
    close(robot.theta[0], model.inertias[1].toDynamicParameters())


@pytest.mark.parametrize("seed", SEEDS)
def test_sdf_as_drake_has_it(tmp_path: Path, seed: int):
    """Drake reads SDF with Gazebo's own library."""
    pytest.importorskip("pydrake", reason="Drake is not made for this platform")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    parts = random_parts(seed)
    # It refuses a link without mass that moves alone; a bacterium's does not matter.
    parts[2] = parts[2]._replace(mass=1e-13, moments=np.full(3, 1e-14))
    robot = read(tmp_path, "robot.sdf", sdf_of(parts, seed))
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(tmp_path / "robot.sdf")
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q, _, _ = state(robot, seed)
    for name, value in zip(robot.joint_names, q, strict=True):
        joint = plant.GetJointByName(name)
        slides = joint.type_name() == "prismatic"
        (joint.set_translation if slides else joint.set_angle)(context, value)
    base = plant.GetBodyByName("part0")
    at = ours_at(robot, q)
    links = {part.name: part for part in parts}
    for k, joint in enumerate(robot.joints, start=1):
        theirs = plant.GetJointByName(joint.name)
        X = theirs.frame_on_child().CalcPose(context, base.body_frame())
        close(at.d[k], X.translation())
        slides = joint.kind == "prismatic"
        axis = theirs.translation_axis() if slides else theirs.revolute_axis()
        close(at.R[k] @ joint.axis, X.rotation().matrix() @ axis)
        R = plant.GetBodyByName(robot.bodies[k]).EvalPoseInWorld(context).rotation()
        R_B = base.EvalPoseInWorld(context).rotation()
        close(at.R[k], R_B.inverse().multiply(R).matrix())
    for name in links:
        spatial = plant.GetBodyByName(name).default_spatial_inertia()
        close(spatial.get_mass(), links[name].mass)
    whole = plant.CalcSpatialInertia(
        context, base.body_frame(), plant.GetBodyIndices(base.model_instance())
    )
    mass, com, I = total(robot, at)
    close(whole.get_mass(), mass)
    close(whole.get_com(), com)
    close(whole.CalcRotationalInertia().CopyToFullMatrix3(), I)


def total(robot: Robot, at: Poses) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, CM and inertia about S of the robot, base axes."""
    theta = np.zeros(10)
    for k, theta_i in enumerate(robot.theta):
        theta += (
            pin.Inertia.FromDynamicParameters(theta_i)
            .se3Action(pin.SE3(at.R[k], at.d[k]))
            .toDynamicParameters()
        )
    whole = pin.Inertia.FromDynamicParameters(theta)
    C = pin.skew(whole.lever)
    return whole.mass, whole.lever, whole.inertia - whole.mass * C @ C


def test_a_quaternion_and_a_rotation_say_the_same(tmp_path: Path):
    random = np.random.default_rng(0)
    quat = random.standard_normal(4)
    rpy = Rotation.from_quat(quat).as_euler("xyz")
    texts = [
        f"<pose>1 2 3 {' '.join(map(repr, map(float, rpy)))}</pose>",
        "<pose rotation_format='quat_xyzw'>1 2 3 "
        f"{' '.join(map(repr, map(float, quat)))}</pose>",
    ]
    inertial = "<mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>2.5</izz></inertia>"
    one, other = (
        read(
            tmp_path,
            "one.sdf",
            f"<sdf version='1.9'><model name='m'><link name='a'><inertial>{pose}"
            f"{inertial}</inertial></link></model></sdf>",
        )
        for pose in texts
    )
    close(one.theta, other.theta)
