"""What may act on a robot, by the world that it is in, where its file says nothing.

    table   slow torque    M a L              what the slope does at arms' length
            pull           a = 100 urad g     levelled by feet, beside 5 to 90 urad
            uneven         50 urad/m g        a good granite or epoxy floor
            drag           c = M / 1000 s     4 to 11 mN s/m under three pads
    orbit   slow torque    1.5 n^2 trace(I) + 2.2 rho v^2 / 2 (2 L)^2 L
            pull           3 n^2 10 m         the tide from where it is tracked
    space   slow torque    1 % of h / T       what moves either momentum by one per
            pull           1 % of v_S / T     cent in the recording
            wheel loss     0.1 % of h / T     of wheels that no sensor is declared for

`M` is the nominal mass, `L` the radius of gyration, `n` the rate of the orbit and `rho`
the air's density. Sources: docs/how-to/what-acts-from-outside.md.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.gaussian import rms_of
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia_at
from orbident.orbits.earth import MU, R_E
from orbident.robot.description import Robot
from orbident.robot.may_act import MayAct
from orbident.robot.units import STANDARD_GRAVITY

SLOPE = 100e-6 * STANDARD_GRAVITY
"""m/s^2: of a table that was levelled by its feet."""

UNEVEN = 50e-6 * STANDARD_GRAVITY
"""1/s^2: change of slope of a good floor."""

STOPS_IN = 1000.0
"""s: the film takes a robot's momentum in such a time."""

PART = 0.01
"""What acts in space changes this part of a robot's momentum in a recording."""

LOST = 0.1
"""A loss of wheels is so large beside a slow torque, where the robot file does not say
that their speeds are measured: a thousandth of the momentum in a recording."""

FROM = 10.0
"""m: so far from a robot is what tracks it in orbit."""

DRAG_COEFFICIENT = 2.2
"""The drag coefficient of a body in free molecular flow."""

THIN_AIR = ((300e3, 2.4e-11), (400e3, 3.7e-12), (500e3, 7.0e-13), (700e3, 3.6e-14))
"""Mean density of the air, kg/m^3, at heights, m (Vallado, Table 8-4)."""

SHORTEST = {"table": 6.0, "orbit": 60.0, "space": 60.0}
"""s: what changes slowly swings at least so long. Hoses and the air of a hall take
seconds; in space nothing but the robot's own turning is as fast."""


class Scale(NamedTuple):
    """How large a motion is."""

    start: float
    """s."""
    duration: float
    """s."""
    h: float
    """Root mean square of the angular momentum of wheels and base, N m s."""
    v: float
    """Root mean square of the velocity of S, m/s; NaN where it is not known."""


def scale_of(
    robot: Robot,
    t: Float[np.ndarray, " n"],
    qd_rw: Float[np.ndarray, "m wheels"],
    w: Float[np.ndarray, "k 3"],
    v_S: Float[np.ndarray, "l 3"] | None,
) -> Scale:
    """The scale of a motion.

    Args:
        robot: with its wheels.
        t: times, s.
        qd_rw: rates of the wheels, rad/s.
        w: of the base, rad/s.
        v_S: of the feature point, m/s; None where it is not known.
    """
    h_base = robot.mass * radius_of_gyration(robot) ** 2 * rms_of(w)
    h = np.hypot(rms_of(qd_rw @ wheels_of(robot).A_rw.T), h_base)
    v = np.nan if v_S is None else rms_of(v_S)
    return Scale(float(t[0]), float(t[-1] - t[0]), float(h), v)


def world_of(robot: Robot) -> str:
    """Where a robot is: on a table, in an orbit, or in space."""
    if robot.motion == "planar":
        return "table"
    return "space" if robot.orbit is None else "orbit"


def what_may_act(robot: Robot, scale: Scale) -> dict[str, MayAct]:
    """All that may act on a robot, by group, with how slowly it changes.

    Args:
        robot: the file's sizes, where it has any, stand for those of the world.
        scale: of the motion.
    """
    world = world_of(robot)
    sizes = dict(robot.disturbances or {})
    if robot.disturbances is None:
        found = {"table": _on_a_table, "orbit": _in_orbit, "space": _in_space}[world]
        sizes = {name: MayAct(size) for name, size in found(robot, scale).items()}
        if world != "table" and robot.wheels and robot.sensors.wheels is None:
            sizes["wheel_loss"] = MayAct(LOST * sizes["slow_torque"].size)
        if robot.momentum_walk.torque:
            # A walk changes slowly, too.
            sizes.pop("slow_torque")
    if world == "table" and robot.pads:
        sizes = {"drag": MayAct(np.inf), **sizes}
    walks = robot.momentum_walk._asdict().items()
    sizes |= {f"{name}_walk": MayAct(q) for name, q in walks if q}
    shortest = SHORTEST[world]
    return {
        name: each._replace(shortest=each.shortest or shortest)
        for name, each in sizes.items()
    }


def may_act_in_words(robot: Robot) -> str:
    """What may act on a robot, one standard deviation of each, in SI."""
    world = world_of(robot)
    if robot.disturbances is None and world == "space":
        return (
            "may act (in space): a slow torque and a pull that change either momentum "
            f"by {PART:.0%} in a recording"
        )
    # In an orbit sizes depend on the height alone.
    sizes = what_may_act(robot, Scale(0.0, 1.0, np.nan, np.nan))
    listed = ", ".join(
        name if np.isinf(each.size) else f"{name} {each.size:.2g}"
        for name, each in sizes.items()
        if each.size
    )
    source = f"of a {world}" if robot.disturbances is None else "of the robot file"
    return f"may act (sizes {source}, SI): {listed or 'nothing'}"


def radius_of_gyration(robot: Robot) -> float:
    """About S with all joints at zero, m; by CAD."""
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    # Of CAD values that no body can have, D may be anything.
    return float(np.sqrt(np.abs(np.diag(D)).sum() / 2 / robot.mass))


def _on_a_table(robot: Robot, _: Scale) -> dict[str, float]:
    return {
        "slow_torque": robot.mass * SLOPE * radius_of_gyration(robot),
        "pull": SLOPE,
        "uneven": UNEVEN,
        "drag": robot.mass / STOPS_IN,
    }


def _in_orbit(robot: Robot, scale: Scale) -> dict[str, float]:
    assert robot.orbit is not None
    start = np.array([scale.start])
    arc = robot.orbit.arc(scale.start, scale.start + scale.duration)
    R = float(np.linalg.norm(arc.position(start)))
    tide, L = MU / R**3, radius_of_gyration(robot)
    heights, densities = np.array(THIN_AIR).T
    rho = np.exp(np.interp(R - R_E, heights, np.log(densities)))
    flow = DRAG_COEFFICIENT * rho * MU / R / 2
    torque = 1.5 * tide * 2 * robot.mass * L**2 + flow * (2 * L) ** 2 * L
    return {"slow_torque": float(torque), "pull": 3 * tide * FROM}


def _in_space(_: Robot, scale: Scale) -> dict[str, float]:
    sizes = {"slow_torque": PART * scale.h / scale.duration}
    if np.isfinite(scale.v):
        sizes["pull"] = PART * scale.v / scale.duration
    return sizes
