"""What sensors should show: the simulator's values, and automatic derivatives."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from random_robots import random_planar_robot, random_robot, random_wheels
from segments import Segment, segment_of

from orbident.compilation import compiled
from orbident.estimation.output_error.segment import Point, linearised
from orbident.estimation.output_error.unknowns import OWN, Own
from orbident.spatial.rotations import cross

ROBOTS = {
    "spatial": random_robot(
        1, (0, 1, 0), prismatic=(1,), wheels=random_wheels(1, ["held", "free", "held"])
    ),
    "planar": random_planar_robot(
        2, (0, 1), prismatic=(1,), wheels=random_wheels(2, ["held"])
    ),
}


@pytest.fixture(scope="module", params=ROBOTS)
def segment(request) -> Segment:
    return segment_of(ROBOTS[request.param], seed=3, rows=32)


rows_of = compiled(linearised, static_argnames=("planar", "substeps"))


def by_sensor(segment: Segment, table) -> dict[str, np.ndarray]:
    """A segment's rows, sensor by sensor."""
    axes = [w.shape[1] for _, w in sorted(segment.shown.weights.items())]
    parts = np.split(np.asarray(table), np.cumsum(axes)[:-1], axis=1)
    return dict(zip(sorted(segment.shown.weights), parts, strict=True))


def moved(point: Point, beta, x) -> tuple[Point, jax.Array]:
    """A point and `beta`, changed by all unknowns at once."""
    own, joints = Own(*x[:OWN].reshape(-1, 3)), point.corrections.shape[1]
    v, s = jnp.asarray(point.x_WB[:3]), point.x_WB[3]
    vector = v + (s * own.turn + cross(v, own.turn)) / 2
    x_WB = jnp.append(vector, s - jnp.dot(v, own.turn) / 2)
    corrections = x[OWN : OWN + 4 * joints].reshape(4, joints)
    changed = Own(*(a + b for a, b in zip(point.own, own, strict=True)))
    return (
        Point(x_WB, changed, point.corrections + corrections),
        beta + x[OWN + 4 * joints :],
    )


def test_values_are_the_simulators(segment: Segment):
    *given, _ = segment
    found = by_sensor(segment, rows_of(*given).residual)
    for sensor, residual in found.items():
        # RK4 with 50 steps a second at some rad/s, and the simulator's own 1e-12.
        np.testing.assert_allclose(residual, 0.0, atol=1e-9, err_msg=sensor)


def test_a_fast_nutation_needs_smaller_steps():
    """A base that answers its wheels at 5 rad/s, sampled at 20 Hz."""
    robot = ROBOTS["spatial"]
    wheels = tuple(replace(wheel, inertia=0.5) for wheel in robot.wheels)
    robot = replace(robot, wheels=wheels)
    errors = []
    for substeps in (1, 2, 16):
        segment = segment_of(robot, 3, 32, dt=0.05, substeps=substeps)
        *given, _ = segment
        attitude = by_sensor(segment, rows_of(*given).residual)["attitude"]
        errors.append(np.abs(attitude).max())
    # RK4: 16 times less with half the step; then what parabolas leave of the joints.
    assert errors[0] > 1e-5
    assert errors[1] < errors[0] / 8
    assert errors[2] < 1e-3 * errors[0]


def test_slopes_are_the_derivatives_of_the_values(segment: Segment):
    body, planar, substeps, beta, point, course, shown, _ = segment
    unknowns = OWN + point.corrections.size + beta.size

    def residual(x):
        at, beta_x = moved(point, beta, x)
        return linearised(body, planar, substeps, beta_x, at, course, shown).residual

    expected = by_sensor(segment, -compiled(jax.jacfwd(residual))(np.zeros(unknowns)))
    *given, _ = segment
    found = by_sensor(segment, rows_of(*given).slopes)
    for sensor, slopes in found.items():
        for name, of_unknown in columns(segment).items():
            ours, exact = slopes[..., of_unknown], expected[sensor][..., of_unknown]
            # RK4 of the derivative is not the derivative of RK4: a step's error,
            # 0.02^4 relative. The accelerometer's are by a parabola in time: 0.02^2.
            part, least = (1e-3, 1e-4) if sensor == "accelerometer" else (1e-8, 1e-12)
            error = np.abs(ours - exact).max()
            assert error < part * np.abs(exact).max() + least, (sensor, name)


def columns(segment: Segment) -> dict[str, slice]:
    """Where each unknown is."""
    own = {name: slice(3 * k, 3 * k + 3) for k, name in enumerate(Own._fields)}
    end = OWN + segment.point.corrections.size
    return own | {"corrections": slice(OWN, end), "beta": slice(end, None)}
