"""The robot as plain frozen data: what every other layer is given."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, PlainValidator

from orbident.files.bounds import SMALLEST
from orbident.files.names import counted
from orbident.files.schema_parts import (
    Name,
    Positive,
    WrongValueError,
    finite_number,
    finite_vector,
    keys_of,
    nonzero_vector,
)
from orbident.orbits.orbit import Orbit
from orbident.robot.may_act import MayAct
from orbident.robot.parameters import PER_BODY, SYMBOLS, Axis, Structure
from orbident.robot.sensor_schema import SensorsSpec
from orbident.robot.tolerances import Tolerances
from orbident.robot.units import (
    FRICTION_OF_A_JOINT,
    TORQUE_OF_A_JOINT,
    Damping,
    MeasuredQuantity,
    Rate,
    Share,
    measure_of,
    measurement_of,
    quantity_of,
)

POINT = PlainValidator(lambda value: np.array(finite_vector(value, 3)))
"""Reads a point of a robot file as an array."""


def _unit_vector(value: object) -> Float[np.ndarray, "3"]:
    vector = np.array(nonzero_vector(value))
    return vector / np.linalg.norm(vector)


UNIT_VECTOR = PlainValidator(_unit_vector)
"""Reads a direction of a robot file as an array of length one."""


@dataclass(frozen=True)
class Joint:
    """One degree of freedom between a parent body and the body it moves.

    Joint `k` moves body `k + 1`; `parent` is a body index smaller than that, so
    joints are in topological order.
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    parent: int
    axis: Float[np.ndarray, "3"]
    """Unit vector, in the joint's (= the moved body's) axes."""
    R_PJ: Float[np.ndarray, "3 3"]
    """Rotates vectors from the joint's axes at q = 0 into the parent body's axes."""
    p_PJ: Float[np.ndarray, "3"]
    """Vector from the parent body's origin to the joint at q = 0, parent's axes, m."""
    position: tuple[float, float] | None = None
    """Lower and upper limit, rad or m; None where the joint turns freely, and infinite
    where it has no stop to one side."""
    velocity: float | None = None
    """Limit of the rate, rad/s or m/s."""

    @property
    def unit(self) -> str:
        """The unit of the joint's position."""
        return "rad" if self.kind == "revolute" else "m"

    def within(self, far: float) -> tuple[float, float]:
        """Its limits, rad or m; where there is no stop, a place so far beyond zero.

        Where there is one stop, the other limit is twice as far from it.
        """
        low, high = self.position or (-math.inf, math.inf)
        return (
            min(high, far) - 2 * far if math.isinf(low) else low,
            max(low, -far) + 2 * far if math.isinf(high) else high,
        )


class Coupling(NamedTuple):
    """A joint that another one moves: `q = factor q' + offset`."""

    follower: str
    leader: str
    """Its name; it follows none itself."""
    factor: float
    """1, or m/rad and the like where one slides and the other turns."""
    offset: float
    """rad or m."""


@dataclass(frozen=True)
class Wheel:
    """A reaction wheel; its mass and inertia are counted in the base (Eq. 5)."""

    name: str
    axis: Float[np.ndarray, "3"]
    """Unit vector, base axes."""
    inertia: float
    """Polar moment of inertia `I_rw`, kg m^2."""
    mode: Literal["held", "free"] = "held"
    """Held at its relative speed in free flight, or motor off without friction."""


def _ratio(value: object) -> float:
    ratio = finite_number(value)
    if abs(ratio) < SMALLEST:
        raise WrongValueError(
            "give how many times as fast as its joint the rotor turns"
        )
    return ratio


class GearedRotor(NamedTuple):
    """The rotor of a joint's motor, on the body that carries the joint.

    Its mass and its inertia at rest are counted in that body.
    """

    gear: Annotated[float, BeforeValidator(_ratio)]
    """Its rate beside that body over the joint's; negative where it turns against."""
    inertia: Annotated[float, measure_of("inertia")]
    """About its axis, which is parallel to the joint's, kg m^2."""
    tolerance: Share = 0.1
    """Relative standard deviation of its inertia. What else turns with it, such as a
    brake or the gear's first stage, is seldom in a data sheet."""


NO_ROTOR = GearedRotor(1.0, 0.0, 0.0)
"""Of a joint without a gear, whose rotor is part of the body that it moves."""


class Friction(NamedTuple):
    """What a joint's bearings, seals and gear take of the torque on it.

    At a rate `qd` they take `viscous qd + coulomb sign(qd) + offset`.
    """

    viscous: Annotated[float, measure_of(FRICTION_OF_A_JOINT)] = 0.0
    """N m s, or N s/m of a joint that slides."""
    coulomb: Annotated[float, measure_of(TORQUE_OF_A_JOINT)] = 0.0
    """N m or N."""
    offset: Annotated[float, quantity_of(TORQUE_OF_A_JOINT)] = 0.0
    """Such as what a cable pulls, and the sensor's own zero; N m or N."""
    tolerance: Share | None = None
    """Standard deviation of each of the three, relative; None where they may be
    anything, as friction that nobody has measured may."""

    def std(self, value: float) -> float:
        """Standard deviation of one parameter beforehand; infinite if it is unknown."""
        return math.inf if self.tolerance is None else abs(self.tolerance * value)


NO_FRICTION = Friction()
"""Of a joint of which nothing is said: anything may take a part of its torque."""


@dataclass(frozen=True)
class Thruster:
    """A thruster on the base."""

    name: Name
    position: Annotated[Float[np.ndarray, "3"], POINT]
    """Position in the base link's frame, m."""
    direction: Annotated[Float[np.ndarray, "3"], UNIT_VECTOR]
    """Unit vector of the force on the base, base axes."""
    gain: Share = 0.1
    """Standard deviation of its force, over that which a recording says."""
    thrust: Positive | None = None
    """Its force at a duty of one, N."""


@dataclass(frozen=True)
class KnownQuantities:
    """What scales and balances said of the robot, beside all recordings of it."""

    mass: Annotated[MeasuredQuantity, measurement_of("mass")] | None = None
    """Of the whole robot, kg."""
    com: Mapping[Axis, Annotated[MeasuredQuantity, measurement_of("length")]] = field(
        default_factory=dict
    )
    """Its CM along axes of the base link's frame, all joints at zero, m."""
    bodies: Mapping[Name, Annotated[MeasuredQuantity, measurement_of("mass")]] = field(
        default_factory=dict
    )
    """The mass of single bodies, by name, kg."""


class MomentumWalk(NamedTuple):
    """White torque and force from outside: momentum is a random walk.

    After a time `t` its standard deviation along each axis is the density times the
    square root of `t`. Zero is none.
    """

    torque: Annotated[float, measure_of("torque density")] = 0.0
    """About the system CM, N m/sqrt(Hz)."""
    force: Annotated[float, measure_of("force density")] = 0.0
    """N/sqrt(Hz)."""


class AtRest(NamedTuple):
    """How still a robot is that is said to be at rest: standard deviations.

    By default as hands and grippers let go of a robot on a table; zero is exact.
    """

    spin: Annotated[float, measure_of("angular rate")] = 1e-3
    """Residual rate of the whole robot, rad/s."""
    wheels: Annotated[float, measure_of("share")] = 1e-3
    """Part of the wheels' momentum that had been there before."""


def _at_rest(value: object) -> object:
    return {"spin": 0.0, "wheels": 0.0} if value == "exact" else value


Stillness = Annotated[AtRest, keys_of(AtRest), BeforeValidator(_at_rest)]
"""As a robot file has it: its sizes, or `exact`."""


DAMPING_STD = 1.0
"""Standard deviation of the logarithm of a passive joint's damping: what is declared
may be wrong by a factor of three."""


class Passive(NamedTuple):
    """A joint on a spring that nobody measures: a panel, a boom, fuel as a pendulum.

    Its torque is `-k q - c qd`, with `k = (2 pi f)^2 I` and `c = 2 zeta k / (2 pi f)`
    where `I` is the inertia of what it carries about its axis.
    """

    frequency: Rate
    """`f`, at which it swings where the body that carries it is held, Hz."""
    damping: Damping = 0.01
    """`zeta`, over critical damping."""
    tolerance: Share = 0.2
    """Standard deviation of the frequency, relative."""
    like: Name = ""
    """Another passive joint of one make, whose frequency and damping it has; what they
    carry has one inertia."""
    inertia: Share = 0.1
    """That of the nominal inertia of what it carries, about its axis: how far it swings
    nobody measures, and so only the CAD model tells it."""


@dataclass(frozen=True)
class Torquer:
    """A magnetic torquer in the base."""

    name: Name
    axis: Annotated[Float[np.ndarray, "3"], UNIT_VECTOR]
    """Unit vector of its dipole, base axes."""
    gain: Share = 0.1
    """Standard deviation of its dipole, over that which a recording says."""


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A spacecraft with arms and reaction wheels.

    Body 0 is the base. Its body frame is the paper's frame b: origin at the tracked
    feature point S, axes of the base link. The body frame of link `i` is at its
    joint. Fixed joints are fused. `theta` is nominal (CAD): a starting point, never
    the answer. A robot is equal to itself alone.
    """

    name: str
    motion: Literal["spatial", "planar"]
    bodies: tuple[str, ...]
    joints: tuple[Joint, ...]
    theta: Float[np.ndarray, "bodies 10"]
    feature_point: Float[np.ndarray, "3"]
    """S in the base link's frame, m."""
    couplings: tuple[Coupling, ...] = ()
    """Joints that follow others; where a recording shows them move apart, it counts."""
    wheels: tuple[Wheel, ...] = ()
    rotors: Mapping[str, GearedRotor] = field(default_factory=dict)
    """The rotors of joints' motors, by joint, no part of `theta`; a joint that turns
    and is absent may have one."""
    torque_constants: Mapping[str, float] = field(default_factory=dict)
    """Torque at a joint over its motor's current, behind any gear, by joint, N m/A or
    N/A."""
    friction: Mapping[str, Friction] = field(default_factory=dict)
    """What is known of joints' friction, by joint."""
    thrusters: tuple[Thruster, ...] = ()
    torquers: tuple[Torquer, ...] = ()
    known: KnownQuantities = field(default_factory=KnownQuantities)
    """What was measured of it beside recordings."""
    structure: Mapping[str, Structure] = field(default_factory=dict)
    """Structure of bodies by name; a body that is absent is arbitrary."""
    pads: Mapping[str, Float[np.ndarray, "3"]] = field(default_factory=dict)
    """The middle of each body's air bearings, in the body's frame, m, by its name."""
    disturbances: Mapping[str, MayAct] | None = None
    """What may act from outside, by `DisturbanceGroup`, and nothing else does; None
    if nobody has said: then what its world is known for may act."""
    momentum_walk: MomentumWalk = field(default_factory=MomentumWalk)
    """How strong unknown torques and forces are that change quickly."""
    passive: Mapping[str, Passive] = field(default_factory=dict)
    """Joints that nobody measures, by name."""
    at_rest: AtRest = field(default_factory=AtRest)
    """How still it is where a recording is said to begin at rest."""
    orbit: Orbit | None = None
    """Where it is while it is recorded; inertial axes are J2000's then."""
    sensors: SensorsSpec = field(default_factory=SensorsSpec)
    """What is measured, how often and how well."""
    tolerances: Tolerances = field(default_factory=Tolerances)
    """How far calibrations may be off; without tolerances they are exact."""
    warnings: tuple[str, ...] = ()
    """What the readers found odd, in words: non-physical inertias and the like."""
    document: Mapping[str, Any] = field(default_factory=dict)
    """The robot file as read, so that a result can keep what it was made from."""
    urdf: str = ""
    """The URDF's text."""

    def __repr__(self) -> str:
        """What it is, in a line."""
        return (
            f"{self.name}: {self.motion}, {counted(len(self.joints), 'joint')}, "
            f"{counted(len(self.wheels), 'wheel')}, {self.mass:.6g} kg nominal"
        )

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of `q`."""
        return tuple(joint.name for joint in self.joints)

    @property
    def wheel_names(self) -> tuple[str, ...]:
        """Names of the wheels, in the order of `qd_rw`."""
        return tuple(wheel.name for wheel in self.wheels)

    @property
    def mass(self) -> float:
        """Nominal total mass, kg."""
        return float(self.theta[:, 0].sum())

    @property
    def conserved_axes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The base axes of angular and of linear momentum that are conserved.

        All; on a table (planar motion) z of the one, x and y of the other.
        """
        if self.motion == "planar":
            return (2,), (0, 1)
        return (0, 1, 2), (0, 1, 2)

    @property
    def said_to_act(self) -> tuple[str, ...]:
        """The groups of disturbances that a file names: pads float on a film."""
        film = ("drag",) if self.pads and self.motion == "planar" else ()
        walks = (
            f"{name}_walk" for name, q in self.momentum_walk._asdict().items() if q
        )
        return tuple(dict.fromkeys((*(self.disturbances or ()), *film, *walks)))

    @property
    def free_parameters(self) -> tuple[int, ...]:
        """Indices into the flat `theta` that `structure` does not make zero."""
        return tuple(
            PER_BODY * i + k
            for i, body in enumerate(self.bodies)
            for k, symbol in enumerate(SYMBOLS)
            if symbol not in self.structure.get(body, Structure()).zero_parameters()
        )
