"""Which routes give a mass, and how far they are apart."""

import numpy as np
import pytest

from orbident.estimation.base_parameters import mass_of
from orbident.estimation.obstacles import beside_nominal
from orbident.estimation.parameter_checks import (
    agreement_of_routes,
    is_a_mass,
    sigmas_apart,
)
from orbident.estimation.quantities import Quantity
from orbident.estimation.triangular import LinearFit
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.robot_file import load_robot

NAN = float("nan")
SAMPLES = 1000


def known(values: np.ndarray, std: np.ndarray) -> LinearFit:
    """Estimates that are uncorrelated, with these deviations."""
    n = values.size
    nothing = np.zeros(0)
    return LinearFit(
        values=values,
        covariance=np.diag(std**2),
        determined=np.ones(n, dtype=bool),
        hidden=np.zeros((n, 0)),
        factor=np.eye(n),
        target=np.zeros(n),
        nuisances=nothing,
        nuisances_std=nothing,
        rms=0.0,
        explained=1.0,
        unexplained=0.0,
        unexplained_freed=0.0,
        explained_freed=1.0,
        freed=nothing,
    )


def test_forms_are_a_deviation_apart():
    """Each form's sigmas scatter by one in many draws with the declared covariance."""
    robot = load_robot("paper-spatial")
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    std_pi, std_phi = 1e-4 * np.abs(pi), 2e-4 * np.abs(phi)
    random = np.random.default_rng(5)
    drawn = [
        mass_of(
            sets,
            known(pi + std_pi * random.standard_normal(pi.size), std_pi),
            known(phi + std_phi * random.standard_normal(phi.size), std_phi),
        ).sigmas
        for _ in range(SAMPLES)
    ]
    scatter = np.std(drawn, axis=0)
    assert scatter.size == 7
    # The deviation of a scatter of so many draws is 1 / sqrt(2 n).
    assert scatter == pytest.approx(1.0, abs=5 / np.sqrt(2 * SAMPLES))


def test_one_form_is_not_compared_with_itself():
    """Where a single form is determined it makes up the mass."""
    robot = load_robot("paper-spatial")
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    last = np.zeros((pi.size, 6))
    # All forms but the last are hidden.
    last[-7:-1] = np.eye(6)
    fit = known(pi, 1e-4 * np.abs(pi))._replace(hidden=last)
    found = mass_of(sets, fit, known(phi, 1e-4 * np.abs(phi)))
    assert found.values == pytest.approx([robot.mass])
    assert np.isnan(found.sigmas).all()


@pytest.mark.parametrize(
    ("value", "std", "M", "counts"),
    [
        (10.0, 1.0, 10.0, True),
        (10.0, 1.01, 10.0, False),
        # As in the tutorial's first run: -89.8 +- 72 kg of a robot of 10 kg.
        (-89.8, 72.0, 10.4, False),
        # Less than a tenth of itself, but more than the robot.
        (367.0, 20.0, 10.4, False),
        (10.0, 0.5, NAN, True),
        (NAN, NAN, 10.0, False),
    ],
)
def test_a_vague_route_is_no_mass(value: float, std: float, M: float, counts: bool):
    assert is_a_mass(value, std, Quantity(M, 0.1)) is counts


def test_routes_in_sigmas():
    assert sigmas_apart(Quantity(13.0, 3.0), Quantity(23.0, 4.0)) == pytest.approx(-2.0)
    assert np.isnan(sigmas_apart(Quantity(1.0, 0.0), Quantity(1.0, 0.0)))


def test_the_check_says_how_far():
    ours = Quantity(1110.0, 0.3)
    near = {"Eq. 32": Quantity(1105.0, 0.4), "maximum likelihood": ours}
    (check,) = agreement_of_routes(near)
    assert check.passed
    assert check.calls_for_care
    assert "but 1105 +- 0.4 kg by Eq. 32 (10 sigmas apart, 0.45 %)" in check.reason
    assert "white noise only" in check.remedy
    assert check.statistic < check.limit
    far = {**near, "Eq. 32": Quantity(1050.0, 0.4)}
    (check,) = agreement_of_routes(far)
    assert check.level == "with care"
    assert "weigh the robot" in check.remedy
    assert check.statistic > check.limit


def test_a_difference_by_chance_needs_no_care():
    ours = Quantity(1110.0, 0.3)
    (check,) = agreement_of_routes(
        {"Eq. 32": Quantity(1108.0, 0.4), "maximum likelihood": ours}
    )
    assert not check.calls_for_care
    assert "and 1108 +- 0.4 kg by Eq. 32 (4 sigmas apart" in check.reason


def test_only_the_route_that_is_off_is_named():
    masses = {
        "Eq. 40": Quantity(1120.0, 0.4),
        "Eq. 32": Quantity(1109.8, 0.4),
        "maximum likelihood": Quantity(1110.0, 0.3),
    }
    (check,) = agreement_of_routes(masses)
    assert check.passed
    assert "Eq. 32" not in check.words
    assert check.remedy == "check the burn's force"


@pytest.mark.parametrize("times", [0.4, 0.7, 1.0, 1.3, 2.9])
def test_a_mass_that_cad_may_be_off_by(times: float):
    assert not [*beside_nominal(Quantity(13.0 * times, 0.1), 13.0, 1)]


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (57.3, "degrees per second"),
        (48.0, "degrees per second"),
        (9.55, "turns per minute"),
        (0.159, "turns per second"),
        (1e3, "the unit of wheel speeds"),
        (-2.0, "the unit of wheel speeds"),
        (4.0, "the unit of wheel speeds"),
    ],
)
def test_a_mass_that_only_a_wrong_scale_gives(times: float, words: str):
    (check,) = beside_nominal(Quantity(13.0 * times, 0.1), 13.0, 1)
    explained = words.endswith(("second", "minute"))
    assert check.level == ("do not trust" if explained else "with care")
    assert words in check.words


def test_a_mass_that_is_not_determined_is_not_compared():
    assert not [*beside_nominal(Quantity(NAN, NAN), 13.0, 1)]


def test_without_wheels_the_thrust_gives_the_scale():
    (check,) = beside_nominal(Quantity(13.0 * 57.3, 0.1), 13.0, 0)
    assert "wheel" not in check.words
    assert "the unit of the thrust" in check.words
