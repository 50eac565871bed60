import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from urdf_texts import joint, link, robot

from orbident.robot.fusing import fused, link_tree
from orbident.robot.parameters import from_mass_com_inertia
from orbident.robot.urdf_reader import read_urdf

pin = pytest.importorskip("pinocchio")

numbers = st.floats(-2, 2).map(lambda x: round(x, 3))
triples = st.tuples(numbers, numbers, numbers).map(lambda v: " ".join(map(str, v)))
masses = st.none() | st.floats(0.1, 50).map(lambda x: round(x, 3))
diagonals = st.tuples(*[st.floats(1, 1.9).map(lambda x: round(x, 3))] * 3)
kinds = st.sampled_from(["fixed", "revolute", "continuous", "prismatic"])
axes = st.sampled_from(["1 0 0", "0 -1 0", "0 0 1", "1 2 -3"])
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'


@st.composite
def urdfs(draw: st.DrawFn) -> str:
    """Trees of up to seven links, some of them massless."""
    count = draw(st.integers(1, 7))
    elements = [link("l0", 1.0)]
    for i in range(1, count):
        parent = f"l{draw(st.integers(0, i - 1))}"
        elements += [
            link(f"l{i}", draw(masses), draw(diagonals), draw(triples)),
            joint(
                f"j{i}", parent, f"l{i}", draw(kinds), draw(triples), draw(triples),
                draw(axes), LIMIT,
            ),
        ]  # fmt: skip
    return robot(*elements)


@settings(deadline=None, max_examples=60)
@given(urdfs())
def test_fused_bodies_are_pinocchios_lumped_inertias(text):
    bodies = fused(link_tree(read_urdf(text)))
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    ids = [1, *(model.getJointId(each.name) for each in bodies.joints)]
    assert len(ids) == model.njoints - 1
    for k, theta in zip(ids, bodies.theta, strict=True):
        # Sums of a few terms of size 1e3 at most, in float64.
        expected = model.inertias[k].toDynamicParameters()
        np.testing.assert_allclose(theta, expected, rtol=1e-11, atol=1e-10)


@settings(deadline=None, max_examples=60)
@given(urdfs())
def test_joint_placements_are_pinocchios(text):
    bodies = fused(link_tree(read_urdf(text)))
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    ids = [1, *(model.getJointId(each.name) for each in bodies.joints)]
    for k, each in zip(ids[1:], bodies.joints, strict=True):
        M = model.jointPlacements[k]
        assert model.parents[k] == ids[each.parent]
        np.testing.assert_allclose(each.p_PJ, M.translation, atol=1e-12)
        np.testing.assert_allclose(each.R_PJ, M.rotation, atol=1e-12)


@given(urdfs())
@settings(deadline=None, max_examples=30)
def test_joints_are_in_topological_order(text):
    bodies = fused(link_tree(read_urdf(text)))
    assert all(each.parent <= k for k, each in enumerate(bodies.joints))
    assert len(bodies.names) == len(bodies.joints) + 1 == len(bodies.theta)


def test_bodies_come_arm_by_arm_in_the_files_order():
    text = robot(
        *(link(name) for name in ("base", "a1", "b1", "a2", "b2")),
        joint("ja1", "base", "a1"),
        joint("jb1", "base", "b1"),
        joint("ja2", "a1", "a2"),
        joint("jb2", "b1", "b2"),
    )
    assert fused(link_tree(read_urdf(text))).names == ("base", "a1", "a2", "b1", "b2")


def test_a_joint_behind_a_fixed_link_hangs_on_the_fused_body():
    text = robot(
        link("base"), link("plate"), link("arm"),
        joint("f", "base", "plate", "fixed", xyz="1 0 0"),
        joint("q", "plate", "arm", xyz="0 2 0"),
    )  # fmt: skip
    bodies = fused(link_tree(read_urdf(text)))
    assert bodies.names == ("base", "arm")
    np.testing.assert_array_equal(bodies.joints[0].p_PJ, [1, 2, 0])


def test_base_without_inertia_has_what_is_fixed_to_it():
    text = robot(
        link("shell", None), link("inertia", 9.0, com="0.5 0 0"),
        joint("f", "shell", "inertia", "fixed"),
    )  # fmt: skip
    bodies = fused(link_tree(read_urdf(text)))
    assert bodies.names == ("shell",)
    assert bodies.theta[0, :2].tolist() == [9.0, 4.5]


def test_the_base_frame_has_its_origin_at_the_feature_point():
    text = robot(
        link("base", 10.0, (1.0, 2.0, 3.0), com="0.5 0 0"), link("l1"), link("l2"),
        joint("j1", "base", "l1", xyz="1 0 0"), joint("j2", "l1", "l2", xyz="0 1 0"),
    )  # fmt: skip
    p_LS = (0.1, 0.2, 0.3)
    bodies = fused(link_tree(read_urdf(text)), feature_point=p_LS)
    expected = from_mass_com_inertia(
        10.0, np.array([0.4, -0.2, -0.3]), np.diag([1.0, 2.0, 3.0])
    )
    # One rotation-free shift of numbers of size one.
    np.testing.assert_allclose(bodies.theta[0], expected, atol=1e-14)
    np.testing.assert_allclose(bodies.joints[0].p_PJ, [0.9, -0.2, -0.3])
    np.testing.assert_array_equal(bodies.joints[1].p_PJ, [0, 1, 0])
