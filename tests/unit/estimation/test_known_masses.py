"""What scales said, where it is not the whole robot's mass by maximum likelihood."""

from dataclasses import replace

import numpy as np
import pytest
from burns import Body, burn
from clean_recordings import clean_space
from random_motions import random_motion
from valved_satellite import Truth, flown, satellite

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.weigh import weigh
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import KnownQuantities
from orbident.robot.robot_file import load_robot
from orbident.robot.units import MeasuredQuantity
from orbident.simulation.simulate import simulate

SCALES = KnownQuantities(mass=MeasuredQuantity(12.3, 0.01))


def test_a_body_that_is_the_whole_robot(tmp_path):
    whole, body = (
        satellite(tmp_path, more=f"known: {known}\n")
        for known in (
            "{mass: 23.09 +- 0.01 kg}",
            "{bodies: {satellite: 23.09 +- 0.01 kg}}",
        )
    )
    assert body.known.bodies == {"satellite": (23.09, 0.01)}
    seen = flown(Truth(), 1, duration=20.0)
    found = [identify(robot, seen).base for robot in (whole, body)]
    np.testing.assert_allclose(found[0].values, found[1].values, rtol=1e-9)
    np.testing.assert_allclose(found[0].std, found[1].std, rtol=1e-6)


def test_a_link_on_a_hinge_has_no_mass_of_its_own():
    """It trades its mass for a first moment of the body that carries it."""
    robot = load_robot("cepheus-like")
    sets = minimal_sets(robot)
    assert all(sets.of_mass(k) is None for k in range(len(robot.bodies)))


def test_a_body_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="known: bodies: no body 'arm'"):
        satellite(tmp_path, more="known: {bodies: {arm: 1 +- 0.1 kg}}\n")


@pytest.mark.parametrize("off", [0.0, 0.05])
def test_scales_that_contradict_the_recording(off):
    """Whose deviation is far less than that of the recording."""
    flown = clean_space(seed=1, duration=20.0)
    mass = MeasuredQuantity((1 + off) * flown.robot.mass, 1e-4 * flown.robot.mass)
    robot = replace(flown.robot, known=KnownQuantities(mass=mass))
    found = identify(robot, flown.recording)
    said = [words for words in found.warnings if "contradict" in words]
    said += [words for words in found.warnings if "what was weighed" in words]
    assert (found.status == "rejected") == bool(said) == bool(off)
    if off:
        assert (
            "what was weighed (known in the robot file)"
            in found.with_causes().refusal()
        )


def test_a_burn_beside_scales():
    """Both say the mass, and scales what thrust was: here 1.05 of what is recorded."""
    robot = load_robot("cepheus-like")
    jets = tuple(replace(each, gain=0.2) for each in robot.thrusters)
    robot = replace(robot, thrusters=jets)
    seen = burn(Body(robot.joint_names, mass=12.3 / 1.05))
    alone, both = weigh(robot, seen), weigh(replace(robot, known=SCALES), seen)
    assert np.isnan(alone.thrust.value)
    assert both.thrust.value == pytest.approx(1.05, rel=1e-3)


def test_a_burn_that_contradicts_scales():
    """A net force is taken as it is recorded: thrust has no gain."""
    robot = replace(load_robot("cepheus-like"), known=SCALES)
    found = weigh(robot, burn(Body(robot.joint_names, mass=13.0)))
    assert found.status == "rejected"
    assert "by 'known' 12.3 +- 0.01 kg" in found.warnings[0]
    agrees = weigh(robot, burn(Body(robot.joint_names, mass=12.3)))
    assert agrees.status == "ok"
    assert agrees.mass.value == pytest.approx(12.3, rel=1e-6)
    assert agrees.mass.std <= 0.01


@pytest.mark.parametrize("method", ["structured", "least-squares", "recursive"])
def test_other_methods_say_that_they_leave_it_out(method):
    robot = load_robot("paper-spatial")
    scales = KnownQuantities(mass=MeasuredQuantity(robot.mass, 0.1))
    seen = simulate(robot, random_motion(robot, duration=20.0))
    found = identify(replace(robot, known=scales), seen, method=method)
    assert any("left out by" in words for words in found.notes)
    assert not any("left out by" in words for words in identify(robot, seen).notes)
