"""May the numbers be trusted? What is not determined is named, and why."""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool

from orbident.estimation.least_squares import Fits
from orbident.estimation.mass import Mass
from orbident.robot.description import Robot
from orbident.signals.samples import Samples

# The known term of the momentum equation, nuisance apart, beside the whole of it:
# zero but for rounding.
NO_SCALE = 1e-9
# What the parameters must explain of it: noise alone is explained hardly at all.
EXPLAINED = 0.5


class Verdict(NamedTuple):
    """Which numbers stand."""

    status: Literal["ok", "rejected"]
    warnings: tuple[str, ...]
    pi: Bool[np.ndarray, " pi"]
    phi: Bool[np.ndarray, " phi"]
    mass: bool


def judge(robot: Robot, samples: Samples, fits: Fits, mass: Mass) -> Verdict:
    """Decide what is determined, in words that say what to do."""
    warnings = list(robot.warnings)
    scale = _has_scale(fits)
    pi = fits.pi.determined & scale
    phi = fits.phi.determined & bool(samples.v_S)
    if not scale:
        warnings.append(f"pi has no scale: {_why_no_scale(robot)}")
    else:
        warnings += _undetermined("pi", pi, samples.locked)
    if not samples.v_S:
        warnings.append(
            "phi is not determined: the recording has no velocity.x .y .z of the "
            "feature point (nor position.x .y .z); record one of them"
        )
    else:
        warnings += _undetermined("phi", phi, samples.locked)
    has_mass = bool(scale and mass.forms.size)
    if scale and not has_mass:
        warnings.append(
            "mass: no form of Eq. 32 has all its parameters determined; weigh the "
            "robot with a thruster burn (Eq. 40), or see the warnings above"
        )
    status = "ok" if scale and has_mass else "rejected"
    return Verdict(status, tuple(warnings), pi, phi, has_mass)


def _has_scale(fits: Fits) -> bool:
    """Whether the momentum equation has a known term that the motion explains."""
    known = np.hypot(fits.pi.explained, fits.pi.unexplained)
    if known <= NO_SCALE * fits.pi.total:
        return False
    return fits.pi.explained**2 > EXPLAINED * known**2


def _why_no_scale(robot: Robot) -> str:
    if not robot.wheels:
        return (
            "the robot has no reaction wheel, so only ratios show; declare its wheels "
            "and spin one up before recording"
        )
    remedy = "spin up a wheel before recording"
    if robot.motion == "planar":
        remedy += (
            "; in the plane a constant wheel speed tells nothing unless the momentum "
            "is known, so start at rest and use --initial-momentum at-rest, or change "
            "the wheel speed during the recording"
        )
    return f"the wheels' momentum does not vary in the recording; {remedy}"


def _undetermined(
    name: str, determined: Bool[np.ndarray, " n"], locked: tuple[str, ...]
) -> list[str]:
    which = np.flatnonzero(~determined) + 1
    if which.size == 0:
        return []
    names = ", ".join(f"{name}_{k}" for k in which)
    if locked:
        joints = ", ".join(f"'{joint}'" for joint in locked)
        never = f"joint {joints}" if len(locked) == 1 else f"joints {joints}"
        reason = f"{never} never moved; move it" if len(locked) == 1 else (
            f"{never} never moved; move them"
        )
    else:
        reason = "the motion does not excite them; record a richer trajectory"
    return [f"{names} not determined: {reason}"]
