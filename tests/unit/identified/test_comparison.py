"""What was captured: closed forms, and betas drawn with their covariance."""

from dataclasses import replace

import numpy as np
import pytest
from made_results import REFUSED, exact_result, freed, joined, known, without
from random_robots import DUAL_ARM, random_body, random_planar_robot, random_robot
from scipy.stats import chi2, kstest

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.comparison import Comparison, compare
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    Structure,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.robot.robot_file import load_robot

TARGET = from_mass_com_inertia(
    50.0,
    np.array([0.4, 0.1, -0.2]),
    np.array([[6.0, 0.5, -0.3], [0.5, 5.0, 0.2], [-0.3, 0.2, 4.0]]),
)
ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
DRAWS = 100


def drawn(result: Result, random: np.random.Generator) -> Result:
    """The result with an error drawn from its covariance."""
    values = random.multivariate_normal(
        result.base.values, result.base_covariance, method="cholesky"
    )
    return replace(result, base=replace(result.base, values=values))


def check_found(found: Comparison, body: str, theta_t: np.ndarray, tolerance: float):
    assert found.status == "changed"
    assert found.warnings == ()
    assert found.undetermined == {}
    assert found.body == body
    added = found.added
    assert added is not None
    scale = np.abs(theta_t).max()
    np.testing.assert_allclose(added.theta, theta_t, rtol=0, atol=tolerance * scale)
    assert added.mass.value == added.theta[0]
    np.testing.assert_allclose(
        added.com.values, theta_t[1:4] / theta_t[0], rtol=0, atol=tolerance
    )
    I_com = inertia_about_com(theta_t)
    np.testing.assert_allclose(
        added.I_com.values, [I_com[e] for e in ENTRIES], rtol=0, atol=tolerance * scale
    )
    np.testing.assert_array_equal(added.I_origin.values, added.theta[4:])


@pytest.fixture(scope="module")
def servicer() -> tuple[Robot, Robot]:
    """`paper-spatial`: as it is, and with nothing known of link 3."""
    robot = load_robot("paper-spatial")
    return robot, freed(robot, "link3")


@pytest.mark.parametrize("body", ["base", "link3", "link6"])
def test_any_body_of_a_tree(body):
    robot = random_robot(3, DUAL_ARM, prismatic=[1])
    theta_t = random_body(np.random.default_rng(1))
    found = compare(exact_result(robot), exact_result(joined(robot, body, theta_t), 1))
    # d is exact to 1e-15 of beta; conditions of T and of the covariance.
    check_found(found, body, theta_t, 1e-9)
    assert found.explanations[0].probability == pytest.approx(1.0)


def test_a_structure_that_no_longer_holds(servicer):
    """18 parameters before, 23 after; the CM of the target is off the axis."""
    before, after = servicer
    found = compare(
        exact_result(before), exact_result(joined(after, "link3", TARGET), 1)
    )
    check_found(found, "link3", TARGET, 1e-9)
    # Let go again: the structure holds after, not before.
    found = compare(
        exact_result(joined(after, "link3", TARGET), 1), exact_result(before)
    )
    check_found(found, "link3", -TARGET, 1e-9)


def test_structures_of_different_bodies():
    """What the two know need not contain one another."""
    robot = random_robot(5, (0, 1, 2))
    theta = robot.theta.copy()
    theta[1, [1, 2]] = theta[3, [2, 3]] = 0.0
    robot = replace(robot, theta=theta)
    before = known(robot, link3=Structure(com_on_axis="x"))
    after = known(robot, link1=Structure(com_on_axis="z"))
    theta_t = random_body(np.random.default_rng(2))
    found = compare(
        exact_result(before), exact_result(joined(after, "link3", theta_t), 1)
    )
    check_found(found, "link3", theta_t, 1e-9)


def test_in_the_plane():
    robot = random_planar_robot(4, (0, 1, 2))
    theta_t = random_body(np.random.default_rng(2))
    found = compare(
        exact_result(robot), exact_result(joined(robot, "link3", theta_t), 1)
    )
    added, shows = found.added, [0, 1, 2, 9]
    assert (found.status, found.body, found.warnings) == ("changed", "link3", ())
    assert added is not None
    np.testing.assert_allclose(added.theta[shows], theta_t[shows], rtol=1e-8)
    assert np.isnan(np.delete(added.theta, shows)).all()
    assert list(found.undetermined) == ["mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz"]
    assert set(found.undetermined.values()) == {
        "does not show in the momentum of planar motion"
    }
    # The CM in the plane, and the inertia about it, need nothing else.
    assert np.isnan(added.com.values).tolist() == [False, False, True]
    assert np.isnan(added.I_com.values).tolist() == [True] * 5 + [False]
    I_zz = inertia_about_com(theta_t)[2, 2]
    assert added.I_com.values[5] == pytest.approx(I_zz, rel=1e-8)


def test_statistics(servicer):
    """Normalised errors squared are chi-square, and intervals hold what they say."""
    before, after = servicer
    holding = joined(after, "link3", TARGET)
    a, b = exact_result(before, 2, 3e-5), exact_result(holding, 3, 3e-5)
    random = np.random.default_rng(0)
    nees, left, inside = [], [], []
    I_com = inertia_about_com(TARGET)
    truth = np.array([*TARGET[1:4] / TARGET[0], *(I_com[e] for e in ENTRIES)])
    for _ in range(DRAWS):
        found = compare(drawn(a, random), drawn(b, random), "link3")
        added = found.added
        assert added is not None
        error = added.theta - TARGET
        nees.append(error @ np.linalg.solve(added.covariance, error))
        left.append(found.explanations[0].left.p)
        assert found.explanations[0].body == "link3"
        values = np.append(added.com.values, added.I_com.values)
        std = np.append(added.com.std, added.I_com.std)
        inside.append(np.abs(values - truth) < 1.96 * std)
    low, high = chi2.ppf([0.005, 0.995], 10 * DRAWS) / DRAWS
    assert low < np.mean(nees) < high
    assert kstest(left, "uniform").pvalue > 0.01
    # 9 numbers, 100 times: 95 % to 0.7 % if they were independent.
    assert 0.93 < np.mean(inside) < 0.97


def test_the_same_by_plain_generalised_least_squares(servicer):
    _, robot = servicer
    random = np.random.default_rng(4)
    a = drawn(exact_result(robot, 2, 1e-4), random)
    b = drawn(exact_result(joined(robot, "link3", TARGET), 3, 1e-4), random)
    X = minimal_sets(robot).base.T[:, -10:]
    C = a.base_covariance + b.base_covariance
    N = X.T @ np.linalg.solve(C, X)
    d = b.base.values - a.base.values
    theta_t = np.linalg.solve(N, X.T @ np.linalg.solve(C, d))
    found = compare(a, b, "link3").added
    assert found is not None
    # Normal equations: half the digits.
    np.testing.assert_allclose(found.theta, theta_t, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(N), rtol=1e-6, atol=1e-9)


def test_no_change(servicer):
    """One false alarm in a thousand."""
    before, after = servicer
    random = np.random.default_rng(1)
    a, b = exact_result(before, 2, 1e-3), exact_result(after, 3, 1e-3)
    found = [compare(drawn(a, random), drawn(b, random)) for _ in range(DRAWS)]
    assert [each.status for each in found].count("no change") >= DRAWS - 2
    assert kstest([each.change.p for each in found if each.change], "uniform")[1] > 0.01
    assert found[0].added is None
    assert found[0].body is None


def test_what_is_not_determined_is_not_used(servicer):
    """As if its deviation were enormous."""
    _, robot = servicer
    random = np.random.default_rng(4)
    a = drawn(exact_result(robot, 2, 1e-5), random)
    b = drawn(exact_result(joined(robot, "link3", TARGET), 3, 1e-5), random)
    names = ("sigma_2", "iota_1", "iota_3")
    vague = a.base_covariance.copy()
    lost = np.isin(a.base.names, names)
    vague[lost, lost] += 1e9
    a_vague = replace(a, base=replace(a.base, covariance=vague))
    found = compare(without(a, *names), b, "link3")
    expected = compare(a_vague, b, "link3").added
    assert found.added is not None
    assert expected is not None
    np.testing.assert_allclose(found.added.theta, expected.theta, rtol=1e-5, atol=1e-5)
    assert found.change is not None
    assert found.change.dof == len(a.base.values) - 3


def test_parameters_that_are_lost_have_a_reason(servicer):
    _, robot = servicer
    a, b = exact_result(robot), exact_result(joined(robot, "link3", TARGET), 1)
    formulas = dict(zip(b.base.names, b.base.formulas, strict=True))
    own = [name for name, formula in formulas.items() if formula == "Ixy(link3)"]
    found = compare(a, without(b, *own))
    assert found.undetermined == {"Ixy": f"the run after does not determine {own[0]}"}
    assert found.added is not None
    np.testing.assert_allclose(
        np.delete(found.added.theta, 5), np.delete(TARGET, 5), rtol=0, atol=1e-6
    )
    assert np.isnan(found.added.I_com.values).tolist() == [0, 1, 0, 0, 0, 0]
    assert np.isnan(found.added.to_json()["mass"]["value"]) == 0
    assert found.to_json()["added"]["theta"]["values"][5] is None

    found = compare(without(a, *a.base.names), b)
    assert found.status == "rejected"
    assert "the run before does not determine M, sigma_1, " in found.warnings[0]
    # The mass alone: on which body does not show.
    found = compare(without(a, *a.base.names[1:]), b)
    assert found.body == "link3"
    assert found.added is not None
    assert found.added.mass.value == pytest.approx(50.0)
    assert "it is on 'link3' with probability 0.25 only" in found.warnings[0]


def test_the_wrong_body(servicer):
    before, after = servicer
    a, b = (
        exact_result(before, 1, 1e-6),
        exact_result(joined(after, "link3", TARGET), 2, 1e-6),
    )
    found = compare(a, b, "link2")
    assert (found.status, found.added, found.body) == ("rejected", None, None)
    (warning,) = found.warnings
    assert warning.startswith("a body on 'link2' does not explain the change")
    assert "'link3' does better" in warning
    with pytest.raises(InputError, match="no body 'link4'; did you mean"):
        compare(a, b, "link4")


def test_two_bodies_at_once():
    robot = random_robot(3, DUAL_ARM)
    random = np.random.default_rng(3)
    held = joined(robot, "link3", random_body(random))
    held = joined(held, "link6", random_body(random))
    found = compare(exact_result(robot, 1, 1e-4), exact_result(held, 2, 1e-4))
    assert found.status == "rejected"
    assert found.warnings[0].startswith("no single body explains the change")
    assert len(found.explanations) == len(robot.bodies)


def test_rejected_runs(servicer):
    _, robot = servicer
    good = exact_result(robot)
    bad = replace(good, checks=(REFUSED,))
    found = compare(good, bad)
    assert found.status == "rejected"
    assert found.warnings == (
        "the run after is refused, so nothing is compared: mass: no scale; "
        "spin a wheel up",
    )
    assert len(compare(bad, bad).warnings) == 2


def test_deviations_that_are_too_small(servicer):
    """Whatever is found."""
    _, robot = servicer
    a, b = exact_result(robot), exact_result(joined(robot, "link3", TARGET), 1)
    by_lines = replace(a, method="least-squares")
    for other, body in ((a, None), (b, None), (b, "link1")):
        warning = compare(by_lines, other, body).warnings[0]
        assert "the run before is by least-squares" in warning
        assert warning.endswith("identify again by maximum-likelihood")


def test_the_structure_of_what_holds_it(servicer):
    """On the axis, and known to be: the rest is right, and there is a warning."""
    robot, _ = servicer
    theta_t = from_mass_com_inertia(
        50.0, np.array([0.4, 0.0, 0.0]), np.diag([6.0, 5.0, 4.0])
    )
    found = compare(
        exact_result(robot), exact_result(joined(robot, "link3", theta_t), 1)
    )
    (warning,) = found.warnings
    assert "'link3' with what it holds is taken to have no my, mz, Ixy, " in warning
    assert found.undetermined["Ixy"] == "the structure of 'link3' takes it as zero"
    assert found.added is not None
    assert found.added.com.values[0] == pytest.approx(0.4)

    x, z = (known(robot, link2=Structure(com_on_axis=axis)) for axis in ("x", "z"))
    with pytest.raises(InputError, match="link2: com_on_axis is x before and z after"):
        compare(exact_result(x), exact_result(z))


def test_bodies_that_cannot_be(servicer):
    _, robot = servicer
    a = exact_result(robot, 1, 1e-6)
    flat = from_mass_com_inertia(50.0, np.zeros(3), np.diag([1.0, 2.0, 5.0]))
    (warning,) = compare(
        a, exact_result(joined(robot, "link3", flat), 2, 1e-6)
    ).warnings
    assert "principal moments 1, 2, 5 kg m^2 violate the triangle" in warning
    # Let go, it is as impossible.
    (warning,) = compare(
        exact_result(joined(robot, "link3", flat), 2, 1e-6), a
    ).warnings
    assert "violate the triangle" in warning
    # Within its deviations it may be possible.
    vague = compare(a, exact_result(joined(robot, "link3", flat), 2, 1e-3), "link3")
    assert vague.status == "changed"
    assert vague.warnings == ()
    # In the plane all that can be said is that Izz is negative.
    plane = random_planar_robot(4, (0, 1, 2))
    thin = from_mass_com_inertia(2.0, np.zeros(3), np.diag([1.0, 1.0, -0.3]))
    held = exact_result(joined(plane, "link3", thin), 2, 1e-6)
    (warning,) = compare(exact_result(plane, 1, 1e-6), held).warnings
    assert "Izz about its CM, -0.3 kg m^2, is negative" in warning


def test_a_change_without_mass(servicer):
    """Something inside moved: no mass, so no CM of it."""
    _, robot = servicer
    moved = np.array([0.0, 5.0, 0, 0, 2.0, 0, 2.0, 0, 0, 2.0])
    a, b = (
        exact_result(robot, 1, 1e-6),
        exact_result(joined(robot, "link3", moved), 2, 1e-6),
    )
    found = compare(a, b)
    assert found.status == "changed"
    assert any("too vague to determine the CM" in each for each in found.warnings)
    assert found.added is not None
    assert np.isnan(found.added.com.values).all()
    assert np.isnan(found.added.I_com.values).all()
    assert found.added.I_origin.values[0] == pytest.approx(2.0, abs=0.05)


def test_results_that_are_none(servicer):
    _, robot = servicer
    good = exact_result(robot)
    of_another = exact_result(known(robot, link3=Structure(principal_axes=True)))
    short = replace(good, base=of_another.base)
    with pytest.raises(InputError, match="has not the 23 base parameters"):
        compare(good, short)
