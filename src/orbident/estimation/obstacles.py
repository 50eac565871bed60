"""Why a recording cannot tell the parameters, or not their scale, by any method."""

import math
from collections.abc import Iterator

import numpy as np

from orbident.estimation.checks import Check, Level
from orbident.estimation.estimate import Solved
from orbident.estimation.levels import TIMES_CAD
from orbident.estimation.momentum_problem import EXPLAINED, VARIES, MomentumProblem
from orbident.estimation.quantities import Quantity
from orbident.files.names import listed
from orbident.preprocessing.delays import LONGEST, NAMES

# The known term of the momentum equation, nuisance apart, beside the whole of it:
# zero but for rounding.
ROUNDING = 1e-9
# Freeing a momentum that is rightly known hardly makes the residual smaller.
FREED = 0.5
# Deviations of the momentum beforehand that a robot at rest has not.
MOVING = 5.0
# CAD values are off by some ten percent; a robot that was not at rest by far more.
SURPRISING = 0.3

WHEEL_UNITS = {
    "degrees per second": 180 / math.pi,
    "turns per minute": 30 / math.pi,
    "turns per second": 0.5 / math.pi,
}
"""What a speed of 1 rad/s is in other units: pi and M are so many times too large where
wheel speeds in them are taken for rad/s."""

NEAR = 1.5
"""Times that an identified mass may be off a unit's factor: CAD values are hardly
further off."""

MASS_BESIDE_NOMINAL = "mass beside the nominal one"
"""The check's name."""


def obstacles(problem: MomentumProblem, by_torque: bool = False) -> list[Check]:
    """What the linear fits show: each forbids a result.

    They know nothing of thrust, and a recording with some is not judged by them.

    Args:
        problem: of a recording.
        by_torque: whether torques of joints show how large all parameters are.
    """
    if still := no_motion(problem):
        return still
    told = problem.samples.unknown_thrust or (by_torque and not problem.scale_seen)
    scale = [] if told else _no_scale(problem)
    return [*_clocks_apart(problem), *scale]


def no_motion(problem: MomentumProblem) -> list[Check]:
    """Whether all joints are measured, none moved, and no thrust says anything."""
    robot, samples = problem.robot, problem.samples
    moving = {*robot.joint_names} - {*samples.locked} or robot.passive
    if not robot.joints or samples.wrenches or moving:
        return []
    reason = f"no joint moves: {listed(samples.locked)} never moved"
    remedy = "record the joints while they move, and see that the columns are theirs"
    return [_refused("motion", reason, remedy)]


def _clocks_apart(problem: MomentumProblem) -> list[Check]:
    """Clocks so far apart that no constant delay is to be corrected."""
    return [
        Check(
            "clocks",
            "do not trust",
            f"the clock of {NAMES[sensor]} is about {delay.late:.2g} s behind "
            f"that of the base rate; no sensor is {LONGEST:g} s late, so these "
            "clocks were never set together, and may drift apart as well",
            "record all sensors with one clock; if it is a constant offset, subtract "
            "it from the times, or give it as 'latency' in the robot file",
            abs(delay.late),
            LONGEST,
        )
        for sensor, delay in problem.clocks.items()
        if delay.apart
    ]


def no_velocity(
    problem: MomentumProblem, level: Level = "do not trust", otherwise: str = ""
) -> list[Check]:
    """Why `phi` and the mass are not determined: momentum alone was recorded.

    Args:
        problem: of a recording.
        level: of a method that cannot go without.
        otherwise: what may be done instead of recording it.
    """
    if problem.samples.tracked:
        return []
    reason = (
        "phi and the mass are not determined: the recording has no velocity.x .y "
        ".z of the feature point (nor position.x .y .z)"
    )
    return [Check("velocity of S", level, reason, f"record one of them{otherwise}")]


def _no_scale(problem: MomentumProblem) -> list[Check]:
    """Why `pi` has no scale, or a wrong one."""
    fits, pi = problem.fits, problem.fits.pi
    assumed = (
        problem.initial_momentum == "at-rest" and pi.unexplained > ROUNDING * fits.h_rw
    )
    # Only where the parameters could be told without the assumption can it be checked.
    freed = np.hypot(pi.explained_freed, pi.unexplained_freed)
    checkable = bool(
        pi.explained_freed**2 > EXPLAINED * freed**2
        and freed > VARIES * fits.h_rw
        # What swings is not in the linear equations.
        and not problem.robot.passive
    )
    if (
        assumed
        and checkable
        and pi.unexplained_freed < FREED * pi.unexplained
        and _moving(problem)
    ):
        reason = (
            "pi is not determined: the robot was not at rest as assumed (with the "
            "momentum unknown the residual falls to "
            f"{pi.unexplained_freed / pi.unexplained:.2g} of what it is)"
        )
        return [_refused("at rest", reason, "use --initial-momentum unknown")]
    if not problem.scale_seen:
        reason, remedy = _why_no_scale(problem)
        return [_refused("scale", f"pi has no scale: {reason}", remedy)]
    return []


def _moving(problem: MomentumProblem) -> bool:
    """Whether more momentum was there than a robot has that is said to be at rest."""
    axes = [*problem.sets.regressors.momentum_axes]
    assert problem.rest_std is not None
    return bool((np.abs(problem.fits.pi.freed) > MOVING * problem.rest_std[axes]).any())


def _why_no_scale(problem: MomentumProblem) -> tuple[str, str]:
    """What was found, and the remedy."""
    if not problem.robot.wheels:
        return (
            "the robot has no reaction wheel, so only ratios show",
            "declare its wheels and spin one up before recording, or record torques of "
            "joints, which --method maximum-likelihood takes",
        )
    if problem.initial_momentum == "at-rest":
        return (
            "base and arms have no momentum of their own",
            "spin a wheel up from rest, so that the base turns, or use "
            "--initial-momentum unknown",
        )
    remedy = "spin up a wheel before recording"
    if problem.robot.motion == "planar":
        remedy += (
            "; in the plane a constant wheel speed shows nothing unless the momentum "
            "is known, so start at rest and use --initial-momentum at-rest, or change "
            "the wheel speed during the recording"
        )
    return "the wheels' momentum does not vary in the recording", remedy


def surprise(problem: MomentumProblem) -> list[Check]:
    """Whether the first sample contradicts a momentum that is taken as known."""
    if problem.fits.surprise <= SURPRISING:
        return []
    return [
        Check(
            "at rest",
            "with care",
            "with nominal inertia the first sample's momentum is off by "
            f"{problem.fits.surprise:.2g} times the wheels', and the scale of pi and "
            "the mass rest on it",
            "was the robot at rest before the wheels spun up? if not, use "
            "--initial-momentum unknown",
            problem.fits.surprise,
            SURPRISING,
        )
    ]


def scale_beside_nominal(solved: Solved) -> Iterator[Check]:
    """Whether the mass, or `pi` where that is all, is as large as CAD has it."""
    problem, found, robot = solved.problem, solved.estimate, solved.problem.robot
    given = len(robot.wheels), bool((solved.shown or found).drives)
    if problem.samples.tracked:
        return beside_nominal(found.mass, robot.mass, *given)
    pi, cad = found.parameters.pi, problem.sets.pi(robot.theta)
    size, nominal = (
        float(np.linalg.norm(each[pi.determined])) for each in (pi.values, cad)
    )
    if not nominal:
        return iter(())
    return beside_nominal(Quantity(size, math.nan), nominal, *given, ("pi", "kg m^2"))


def beside_nominal(
    M: Quantity,
    nominal: float,
    wheels: int,
    torques: bool = False,
    what: tuple[str, str] = ("mass", "kg"),
) -> Iterator[Check]:
    """Whether the mass is far from the nominal one, as it is with a wrong scale.

    Wheels, known thrust or torques alone give the scale, so nothing else in a recording
    shows that wheel speeds are in another unit, or that inertia or thrust is wrong.

    Args:
        M: the identified mass, kg.
        nominal: the mass in the robot file, kg.
        wheels: how many wheels the robot has.
        torques: whether those of joints were measured.
        what: what is compared, and its unit.
    """
    name, unit = what
    times = M.value / nominal
    if not (times > TIMES_CAD or times < 1 / TIMES_CAD):
        return
    units = [
        each for each, factor in WHEEL_UNITS.items() if 1 / NEAR < times / factor < NEAR
    ]
    source, known = "thrust", "the thrust"
    if wheels:
        source, known = "wheels", "wheel speeds and the wheels' inertia"
    elif torques:
        source, known = "torques of joints", "the torques"
    yield Check(
        MASS_BESIDE_NOMINAL,
        "do not trust" if wheels and units else "with care",
        f"{name}: {M.value:.4g} {unit} is {times:.2g} times the nominal {nominal:.4g} "
        f"{unit}, and only {source} can say how large all parameters are",
        f"see whether wheel speeds are in {units[0]} and not in rad/s"
        if wheels and units
        else f"check the unit of {known}, unless the robot holds or has lost a load",
        times,
        TIMES_CAD,
    )


def _refused(name: str, reason: str, remedy: str) -> Check:
    return Check(name, "do not trust", reason, remedy)
