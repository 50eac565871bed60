"""The cost where the mass is held one deviation off, against a parabola."""

import pytest
from cause_problems import problem_with

from orbident.estimation.output_error import mass_profile
from orbident.estimation.output_error.estimator import OutputError


def test_where_much_shows_the_mass_the_cost_rises_by_one(monkeypatch):
    monkeypatch.setattr(mass_profile, "PLAIN", 0.0)
    found = OutputError().estimate(problem_with(), lambda _: None)
    assert found.rise == pytest.approx(1, abs=0.01)
    assert found.rise != 1


def test_a_mass_that_is_known_well_is_not_asked_for(monkeypatch):
    """It would take as long again."""
    asked = []
    monkeypatch.setattr(mass_profile, "solved", lambda *x, **_: asked.append(x))
    found = OutputError().estimate(problem_with(), lambda _: None)
    assert found.converged
    assert not asked


@pytest.mark.parametrize("times", [-0.2, 0.03, 0.5, 1.0, 2.0, 4.0])
def test_a_mass_that_no_cad_explains_is_of_no_robot(times: float):
    """Only if it is ten deviations beyond a third of, or three times, the CAD mass."""
    assert mass_profile.of_no_robot(times, 1e-3, 1.0) == (not 1 / 3 < times < 3)
    assert not mass_profile.of_no_robot(times, 1.0, 1.0)
