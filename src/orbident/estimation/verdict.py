"""May the numbers be trusted? What is not determined is named, and why."""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool

from orbident.estimation.found import Found
from orbident.estimation.least_squares import Fits
from orbident.estimation.mass import Mass
from orbident.estimation.triangular import LinearFit
from orbident.files.names import joined, listed
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

# The known term of the momentum equation, nuisance apart, beside the whole of it:
# zero but for rounding.
ROUNDING = 1e-9
# What the parameters must explain of it, squared: noise is explained hardly at all, and
# signals in wrong units or frames in part.
EXPLAINED = 0.9
# Below this part of the wheels' momentum the known term may be noise of their speeds.
VARIES = 1e-2
# Freeing a momentum that is rightly known hardly makes the residual smaller.
FREED = 0.5
# Forms of Eq. 32 that differ by more than this do not measure one mass.
SPREAD = 0.5
# A mass is told where it is more than this part of itself from zero.
VAGUE = 0.3
# So many neighbours are named; more are given by the first and the last.
LISTED = 20
# CAD values are off by some ten percent; a robot that was not at rest by far more.
SURPRISING = 0.3


class Obstacles(NamedTuple):
    """Why a recording cannot tell the parameters, whatever the method."""

    scale: str | None
    """Why `pi` has no scale, or a wrong one."""
    phi: str | None
    """Why `phi` is not determined, or wrong."""

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return bool(self.scale or self.phi)


class Verdict(NamedTuple):
    """Which numbers stand."""

    status: Literal["ok", "rejected"]
    warnings: tuple[str, ...]
    pi: Bool[np.ndarray, " pi"]
    phi: Bool[np.ndarray, " phi"]
    base: Bool[np.ndarray, " beta"]
    mass: bool


def obstacles(
    robot: Robot, samples: Samples, fits: Fits, initial_momentum: str
) -> Obstacles:
    """What the linear fits show."""
    return Obstacles(
        _no_scale(robot, fits, initial_momentum), _no_phi(samples, fits.phi)
    )


def judge(
    robot: Robot,
    samples: Samples,
    fits: Fits,
    obstacles: Obstacles,
    found: Found,
    no_mass: str | None,
) -> Verdict:
    """Decide what is determined, in words that say what to do.

    Args:
        robot: with the warnings of its readers.
        samples: which joints did not move.
        fits: whether an assumed momentum is plausible.
        obstacles: of the recording.
        found: by the method.
        no_mass: why the method could not tell the mass; None where it could.
    """
    no_scale, no_phi = obstacles
    pi = found.pi.determined & (no_scale is None)
    phi = found.phi.determined & (no_phi is None)
    has_mass = not (obstacles.any or no_mass)
    warnings = list(robot.warnings)
    warnings += [no_scale] if no_scale else _undetermined("pi", pi, samples.locked)
    if not no_scale and fits.surprise > SURPRISING:
        warnings.append(
            "was the robot at rest before the wheels spun up? the scale of pi and the "
            "mass rest on that, and with nominal inertia the first sample's momentum "
            f"is off by {fits.surprise:.2g} times the wheels'"
        )
    warnings += [no_phi] if no_phi else _undetermined("phi", phi, samples.locked)
    if no_mass and not obstacles.any:
        warnings.append(no_mass)
    status = "ok" if has_mass else "rejected"
    base = found.base.determined & has_mass
    return Verdict(status, tuple(warnings), pi, phi, base, has_mass)


def _no_phi(samples: Samples, phi: LinearFit) -> str | None:
    """Why `phi` is not determined, or wrong; None where all is well."""
    if not samples.v_S:
        return (
            "phi and the mass are not determined: the recording has no velocity.x .y "
            ".z of the feature point (nor position.x .y .z); record one of them"
        )
    if phi.explained**2 <= EXPLAINED * (phi.explained**2 + phi.unexplained**2):
        return (
            "phi and the mass are not determined: the velocity of the feature point "
            "does not follow from joints, gyro and attitude; check its units and frame "
            "(inertial axes), and the attitude (scalar last, base to inertial axes)"
        )
    return None


def _no_scale(robot: Robot, fits: Fits, initial_momentum: str) -> str | None:
    """Why `pi` has no scale, or a wrong one; None where all is well."""
    pi = fits.pi
    assumed = initial_momentum == "at-rest" and pi.unexplained > ROUNDING * fits.h_rw
    # Only where the parameters could be told without the assumption can it be checked.
    freed = np.hypot(pi.explained_freed, pi.unexplained_freed)
    checkable = bool(
        pi.explained_freed**2 > EXPLAINED * freed**2 and freed > VARIES * fits.h_rw
    )
    if assumed and checkable and pi.unexplained_freed < FREED * pi.unexplained:
        return (
            "pi is not determined: the robot was not at rest as assumed (with the "
            "momentum unknown the residual falls to "
            f"{pi.unexplained_freed / pi.unexplained:.2g} of what it is); use "
            "--initial-momentum unknown"
        )
    known = np.hypot(pi.explained, pi.unexplained)
    if known <= ROUNDING * fits.h_rw or pi.explained**2 <= EXPLAINED * known**2:
        varies = bool(known > VARIES * fits.h_rw)
        return f"pi has no scale: {_why_no_scale(robot, initial_momentum, varies)}"
    return None


def _why_no_scale(robot: Robot, initial_momentum: str, varies: bool) -> str:
    if not robot.wheels:
        return (
            "the robot has no reaction wheel, so only ratios show; declare its wheels "
            "and spin one up before recording"
        )
    if initial_momentum == "at-rest":
        return (
            "base and arms have no momentum of their own, or not the one that starting "
            "from rest gives them; spin a wheel up from rest, so that the base turns, "
            "or use --initial-momentum unknown"
        )
    if varies:
        return (
            "base and arms do not answer the wheels' momentum as a free-floating robot "
            "does; check units (rad, rad/s), signs, the wheels' axes, and the attitude "
            "(scalar last, from base to inertial axes)"
        )
    remedy = "spin up a wheel before recording"
    if robot.motion == "planar":
        remedy += (
            "; in the plane a constant wheel speed tells nothing unless the momentum "
            "is known, so start at rest and use --initial-momentum at-rest, or change "
            "the wheel speed during the recording"
        )
    return f"the wheels' momentum does not vary in the recording; {remedy}"


def no_linear_mass(mass: Mass) -> str | None:
    """Why the forms of Eq. 32 do not give the mass; None where they do."""
    if mass.value > 0 and mass.spread < SPREAD:
        return None
    if len(mass.forms) == 0:
        return (
            "mass: no form of Eq. 32 is determined; weigh the robot with a thruster "
            "burn (Eq. 40), or see the warnings above"
        )
    return (
        f"mass: the forms of Eq. 32 give {mass.values.min():.4g} to "
        f"{mass.values.max():.4g} kg; check units (rad, rad/s, m/s), the robot's "
        "geometry, its wheels' inertia, and the signs and frames of wheel speeds and "
        "velocity"
    )


def no_direct_mass(M: float, std: float) -> str | None:
    """Why an estimate of `M` itself cannot stand; None where it can."""
    if std < VAGUE * M:
        return None
    return (
        f"mass: found {M:.4g} kg with a standard deviation of {std:.2g} kg; record a "
        "richer or longer motion, with more momentum in the wheels"
    )


def _undetermined(
    name: str, determined: Bool[np.ndarray, " n"], locked: tuple[str, ...]
) -> list[str]:
    which = np.flatnonzero(~determined) + 1
    if which.size == 0:
        return []
    runs = np.split(which, np.flatnonzero(np.diff(which) > 1) + 1)
    names = joined(
        f"{name}_{run[0]} to {name}_{run[-1]}"
        if run.size > LISTED
        else ", ".join(f"{name}_{k}" for k in run)
        for run in runs
    )
    if locked:
        noun, pronoun = ("joint", "it") if len(locked) == 1 else ("joints", "them")
        reason = f"{noun} {listed(locked)} never moved; move {pronoun}"
    else:
        reason = "the motion does not excite them; record a richer trajectory"
    return [f"{names} not determined: {reason}"]
