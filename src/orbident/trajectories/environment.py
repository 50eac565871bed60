"""What acts on a robot from outside, as the `environment` of a file says it; SI."""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import (
    MappingSchema,
    Positive,
    Vector3,
    WrongValueError,
)
from orbident.robot.orbit_schema import OrbitEntry
from orbident.robot.units import (
    Lasting,
    Time,
    each_of,
    measure_of,
    quantity,
    quantity_of,
)


def _lasting(value: object) -> float:
    number = quantity(value, "time")
    if number <= 0:
        raise WrongValueError("give a time above zero")
    return number


Axes = tuple[float, float, float]
Torque = Annotated[Axes, each_of("torque")]
Force = Annotated[Axes, each_of("force")]
Dipole = Annotated[Axes, each_of("magnetic moment")]
Lengths = Annotated[Axes, each_of("length")]
Slope = Annotated[float, quantity_of("slope")]


class SlowTorque(MappingSchema):
    """A Gauss-Markov process along each inertial axis."""

    std: Annotated[float, measure_of("torque")]
    correlation_time: Lasting


class SlowForce(MappingSchema):
    """The same of a force, at S."""

    std: Annotated[float, measure_of("force")]
    correlation_time: Lasting


class Burst(MappingSchema):
    """A constant force at S for a while, base axes, which nobody recorded."""

    start: Time
    duration: Annotated[float, BeforeValidator(_lasting)]
    force: Force


class Firing(MappingSchema):
    """When a thruster is on, and the force that the recording says."""

    on: Time
    off: Time
    force: Annotated[float, measure_of("force")]


class Thrust(MappingSchema):
    """A thruster of the robot file, whose force is recorded."""

    pulses: tuple[Firing, ...]
    gain: Positive = 1.0
    """The true force over that which is recorded."""


class Uneven(MappingSchema):
    """A symmetric pull: `a = [[xx, xy], [xy, yy]] r`, 1/s^2, `r` from the origin."""

    xx: Slope = 0.0
    xy: Slope = 0.0
    yy: Slope = 0.0


class Film(MappingSchema):
    """Drag of the air film below a body's pads."""

    c: Annotated[float, measure_of("drag")] = 0.0
    """N s/m."""
    c_r: Annotated[float, measure_of("turning drag")] = 0.0
    """N m s."""


class AirDrag(MappingSchema):
    """Drag of the thin air in an orbit, at a point of the base."""

    density: Annotated[float, measure_of("density")]
    area: Annotated[float, measure_of("area")]
    coefficient: Positive = 2.2
    centre: Lengths
    """The centre of pressure in the base link's frame."""


class SolarPressure(MappingSchema):
    """The pressure of the sun's light, at a point of the base."""

    sun: Vector3 | None = None
    """Its direction, inertial axes, of any length, where no shadow is cast; by default,
    that of the orbit's epoch, where the Earth casts one."""
    area: Annotated[float, measure_of("area")]
    coefficient: Positive = 1.3
    """1 where all light is absorbed, 2 where it is reflected straight back."""
    centre: Lengths
    """The centre of pressure in the base link's frame."""

    @model_validator(mode="after")
    def _somewhere(self) -> "SolarPressure":
        if self.sun is not None and not any(self.sun):
            raise InputError("sun: found no direction; give a nonzero 3-vector")
        return self


class Environment(MappingSchema):
    """What acts from outside; what is absent does not."""

    torque: Torque | None = None
    """Constant, inertial axes."""
    force: Force | None = None
    """Constant, at S, inertial axes."""
    slow_torque: SlowTorque | None = None
    slow_force: SlowForce | None = None
    bursts: tuple[Burst, ...] = ()
    thrusters: dict[str, Thrust] = Field(default_factory=dict)
    """Thrusters by the names of the robot file."""
    tilt: Annotated[tuple[float, float], each_of("angle", 2)] | None = None
    """How far the table falls along inertial x and y."""
    uneven: Uneven | None = None
    film_drag: dict[str, Film] = Field(default_factory=dict)
    """Drag of the air film, by body."""
    hose: Annotated[float, measure_of("stiffness")] | None = None
    """Pulls S of a robot on a table back to the origin, N/m."""
    orbit: OrbitEntry | None = None
    """Instead of the robot file's."""
    gravity_gradient: bool = False
    air_drag: AirDrag | None = None
    solar_pressure: SolarPressure | None = None
    dipole: Dipole | None = None
    """The magnetic moment that is left in the base, base axes."""

    @model_validator(mode="after")
    def _elements(self) -> "Environment":
        if self.orbit is not None and self.orbit.oem is not None:
            raise InputError(
                "orbit: 'oem' stands under 'orbit:' of the robot file, which also acts "
                "here; move it there, or give elements"
            )
        return self

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """Only what is given."""
        return ((name, value) for name, value in super().__repr_args__() if value)

    @property
    def on_table(self) -> tuple[str, ...]:
        """The names of what is given that acts on a table only."""
        return self._given("tilt", "uneven", "film_drag", "hose")

    @property
    def in_space(self) -> tuple[str, ...]:
        """The names of what is given that acts in space only."""
        return self._given("orbit", *self.in_orbit, "solar_pressure")

    @property
    def in_orbit(self) -> tuple[str, ...]:
        """The names of what is given that needs an orbit."""
        return self._given("gravity_gradient", "air_drag", "dipole")

    def _given(self, *names: str) -> tuple[str, ...]:
        return tuple(name for name in names if getattr(self, name))
