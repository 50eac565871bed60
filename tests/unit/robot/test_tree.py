import numpy as np
import pytest
from urdf_texts import ARM, joint, link, robot

from orbident.errors import InputError
from orbident.robot.fusing import fused, link_tree
from orbident.robot.urdf_reader import read_urdf

A, B, C = link("a"), link("b"), link("c")
WORLD = link("world", mass=None)


def tree(*elements, base_link=None):
    return link_tree(read_urdf(robot(*elements), "sc.urdf"), base_link)


def test_the_root_is_the_base():
    assert link_tree(read_urdf(ARM)).base == "base"


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        (
            (A, B, C, joint("ac", "a", "c"), joint("bc", "b", "c")),
            "kinematic loop: link 'c' has two parents, through joints 'ac' and 'bc'",
        ),
        (
            (A, B, joint("ab", "a", "b"), joint("ba", "b", "a")),
            "kinematic loop through link 'a' and joints 'ab', 'ba'",
        ),
        ((A, joint("aa", "a", "a")), "kinematic loop through link 'a'"),
        (
            (A, B, C, joint("bc", "b", "c"), joint("cb", "c", "b")),
            "kinematic loop through link 'b' and joints 'bc', 'cb'",
        ),
        ((A, B), "disconnected: links 'a', 'b' have no parent"),
        (
            (A, B, joint("f", "a", "b", "floating")),
            "joint 'f' is floating; below the base only",
        ),
        (
            (WORLD, A, B, joint("f", "world", "a", "floating"),
             joint("p", "a", "b", "planar")),
            "joint 'p' is planar",
        ),
    ],
)  # fmt: skip
def test_what_is_no_tree_is_refused(elements, message):
    with pytest.raises(InputError, match=f"^sc.urdf: {message}"):
        tree(*elements)


@pytest.mark.parametrize("kind", ["floating", "planar"])
@pytest.mark.parametrize("base_link", [None, "a"])
def test_a_massless_world_is_dropped(kind, base_link):
    elements = (WORLD, A, B, joint("f", "world", "a", kind), joint("ab", "a", "b"))
    found = tree(*elements, base_link=base_link)
    assert found.base == "a"
    assert fused(found).names == ("a", "b")


def test_a_world_with_mass_is_not_dropped():
    with pytest.raises(InputError, match=r"joint 'f'.* only a massless root"):
        tree(A, B, joint("f", "a", "b", "floating"), base_link="b")


def test_base_link_below_fixed_joints_turns_them_round():
    elements = (
        link("root", 3.0),
        link("mount", 2.0, com="0.1 0 0"),
        link("base", 1.0),
        link("arm", 0.5),
        joint("f1", "root", "mount", "fixed", xyz="1 0 0", rpy="0 0 1.5"),
        joint("f2", "mount", "base", "fixed", xyz="0 2 0", rpy="0.3 0 0"),
        joint("q", "root", "arm", xyz="0 0 3"),
    )
    below_root = fused(tree(*elements))
    below_base = fused(tree(*elements, base_link="base"))
    at = below_root.placements["base"]
    assert below_base.names == ("base", "arm")
    # The same joint seen from the other link: p_root = R p_base + p.
    (there,), (here,) = below_base.joints, below_root.joints
    np.testing.assert_allclose(at.R @ there.p_PJ + at.p, here.p_PJ, atol=1e-14)
    np.testing.assert_allclose(at.R @ there.R_PJ, here.R_PJ, atol=1e-14)
    assert below_base.theta[0, 0] == 6.0


def test_base_link_below_a_moving_joint_is_refused():
    with pytest.raises(InputError, match=r"'b' hangs below joint 'ab' .revolute"):
        tree(A, B, joint("ab", "a", "b"), base_link="b")


def test_unknown_base_link_is_refused():
    with pytest.raises(InputError, match=r"no link 'bas'.*did you mean 'base'"):
        link_tree(read_urdf(ARM), "bas")
