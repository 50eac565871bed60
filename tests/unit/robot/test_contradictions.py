import pytest
from urdf_texts import joint, link, robot

from orbident.errors import InputError
from orbident.robot.oddities import oddities


def test_knowledge_that_the_nominal_values_confirm(load_yaml):
    found = load_yaml("structure: {link1: {com_on_axis: z, principal_axes: true}}")
    assert found.warnings == ()
    assert found.structure["link1"].zero_parameters() == {
        "mx", "my", "Ixy", "Ixz", "Iyz",
    }  # fmt: skip
    assert len(found.free_parameters) == 25


def test_a_com_off_the_declared_axis_is_warned_of(load_yaml):
    (warning,) = load_yaml("structure: {link1: {com_on_axis: x}}").warnings
    assert "link1: com_on_axis: x" in warning
    assert "[0, 0, 0.2] m" in warning


def test_products_of_inertia_are_warned_of(load_yaml):
    turned = (
        '<link name="link1"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0.25"/></inertial></link>'
    )
    text = robot(link("base"), turned, joint("joint1", "base", "link1"))
    lines = "structure: {link1: {com_on_axis: x, principal_axes: true}}"
    (warning,) = load_yaml(lines, text).warnings
    assert "[0.25, 0, 0] kg m^2" in warning


def test_principal_axes_alone_are_not_linear(load_yaml):
    with pytest.raises(InputError, match=r"structure\.link1: .* not linear"):
        load_yaml("structure: {link1: {principal_axes: true}}")


CARRIER = robot(
    link("base", 100.0),
    link("carrier", None),
    link("tank"),
    joint("x", "base", "carrier", axis="1 0 0"),
    joint("y", "carrier", "tank", axis="0 1 0"),
)


def test_a_body_that_only_carries_a_joint(load_yaml):
    found = load_yaml("structure: {carrier: {massless: true}}", CARRIER)
    assert found.free_parameters == (*range(10), *range(20, 30))
    assert not [words for words in oddities(found) if "no mass" in words]


@pytest.mark.parametrize("body", ["base", "tank"])
def test_what_has_mass_is_not_massless(load_yaml, body):
    with pytest.raises(InputError, match=f"structure: {body}: massless, but"):
        load_yaml(f"structure: {{{body}: {{massless: true}}}}", CARRIER)
