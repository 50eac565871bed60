import numpy as np
import pytest
from urdf_texts import joint, link, robot

from orbident.robot.oddities import nonphysical


@pytest.mark.parametrize(
    "moments",
    [(1, 1, 1), (0, 0, 0), (0, 1, 1), (1, 2, 3), (0.1, 0.2, 0.3), (0, 1, 1 + 1e-10)],
)
def test_points_rods_and_plates_are_physical(moments):
    assert nonphysical("x", 1.0, np.diag(np.array(moments, float))) == ()


def test_a_turned_rod_is_physical():
    u = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)
    assert nonphysical("x", 1.0, np.eye(3) - np.outer(u, u)) == ()


@pytest.mark.parametrize(
    ("mass", "moments", "sentence"),
    [
        (
            1.0,
            (1, 2, 9),
            "link 'x': principal moments 1, 2, 9 kg m^2 violate the triangle "
            "inequality (1 + 2 < 9)",
        ),
        (1.0, (-1, 2, 2), "moments -1, 2, 2 kg m^2, the smallest is negative"),
        (-1.0, (1, 1, 1), "link 'x': the mass -1 kg is negative"),
        (0.0, (1, 1, 1), "link 'x': it has no mass but principal moments 1, 1, 1"),
    ],
)
def test_what_no_body_can_have(mass, moments, sentence):
    (found,) = nonphysical("x", mass, np.diag(np.array(moments, float)))
    assert sentence in found


@pytest.mark.parametrize(
    ("moments", "words"),
    [
        # An arm whose last moment lacks an exponent.
        (
            (0.011, 0.012, 1.676),
            "would be izz = 0.01676 (times 0.01) or izz = 0.001676 (times 0.001)",
        ),
        # No number alone makes these right.
        ((1.0, 20.0, 4e9), ""),
        ((-1.0, 2.0, 2.0), ""),
    ],
)
def test_a_decimal_point_that_slipped(moments: tuple[float, ...], words: str):
    (found,) = nonphysical("x", 1.0, np.diag(moments))
    assert ("did a decimal point slip?" in found) == bool(words)
    assert found.endswith(words)


def test_a_slip_is_looked_for_in_the_files_axes(load_urdf):
    text = (
        '<link name="b"><inertial><origin rpy="0.3 0.2 0.1"/><mass value="1"/>'
        '<inertia ixx="0.011" iyy="0.012" izz="0.013" ixy="0.8" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )
    (found,) = load_urdf(robot(text)).warnings
    assert found.endswith("possible would be ixy = 0.0008 (times 0.001)")


def test_small_violations_are_printed_with_the_digits_that_show_them():
    (found,) = nonphysical("x", 1.0, np.diag([1.0, 2.0, 3.00000003]))
    assert "(1 + 2 < 3.00000003)" in found


def test_loading_goes_on_with_a_warning_for_each_link(load_urdf):
    found = load_urdf(
        robot(
            link("base", 10.0, (1.0, 2.0, 9.0)),
            link("arm", 1.0, (-1.0, 1.0, 1.0)),
            link("ghost", 0.0),
            joint("j", "base", "arm"),
            joint("f", "arm", "ghost", "fixed"),
        )
    )
    assert [warning.split(":")[0] for warning in found.warnings] == [
        "link 'base'",
        "link 'arm'",
        "link 'ghost'",
    ]
