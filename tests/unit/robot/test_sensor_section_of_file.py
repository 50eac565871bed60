import math

import pytest

from orbident.errors import InputError
from orbident.robot.sensor_schema import EncoderSpec, declared_sensors


def test_every_key_of_a_sensor_may_stand_in_the_file(load_yaml):
    found = load_yaml(
        """
sensors:
  rate: 0.1 kHz
  gyro:
    angle_random_walk: 0.6 deg/sqrt(h)
    bias_instability: 1 deg/h
    turn_on_bias: 36 deg/h
    constant_bias: [1 deg/h, 0, -1 deg/s]
    correlation_time: .inf
    scale: [1.0e-3, 0, 0]
    misalignment: [1 mrad, 0, 0]
    rate: 50
  accelerometer: {increments: true, correlation_time: 2 h}
  joints: {position: 1 mrad, resolution: 2 mrad}
  position: {std: 1 mm, latency: 5 ms, drop_out: 0.1}
"""
    ).sensors
    gyro, accelerometer = found.gyro, found.accelerometer
    assert gyro is not None
    assert accelerometer is not None
    assert gyro.turn_on_bias == pytest.approx(math.radians(36) / 3600)
    assert gyro.constant_bias == pytest.approx(
        (math.radians(1) / 3600, 0, -math.radians(1))
    )
    assert gyro.correlation_time == math.inf
    assert gyro.scale == (1e-3, 0, 0)
    assert gyro.misalignment == (1e-3, 0, 0)
    assert gyro.rate == 50.0
    assert accelerometer.increments
    assert accelerometer.correlation_time == 7200.0
    assert found.joints is not None
    assert found.joints.resolution == 2e-3
    assert found.position is not None
    assert (found.position.latency, found.position.drop_out) == (5e-3, 0.1)


def test_coloured_noise_is_of_all_axes_or_of_each(load_yaml):
    found = load_yaml(
        """
sensors:
  attitude: {angle: 60 urad, random_walk: 2 urad/sqrt(s)}
  position:
    std: 8.5 um
    markov_std: [19 um, 11 um, 0]
    correlation_time: [2 s, 100 ms, 1]
    random_walk: 3 um/sqrt(s)
"""
    ).sensors
    assert found.of("attitude").coloured.random_walk == pytest.approx(2e-6)
    lasting = found.of("position").coloured
    assert lasting.markov_std == pytest.approx((19e-6, 11e-6, 0.0))
    assert lasting.correlation_time == pytest.approx((2.0, 0.1, 1.0))
    assert lasting.random_walk == pytest.approx(3e-6)


def test_suites_are_there_unless_the_file_says_otherwise(load_yaml):
    found = load_yaml(
        "sensors: {suites: [paper, phasespace-like], joints: {position: 1 mrad}}"
    ).sensors
    ready = [
        declared_sensors({"suites": [name]}).declared
        for name in ("paper", "phasespace-like")
    ]
    own = {"joints": EncoderSpec(position=1e-3)}
    assert found.declared == ready[0] | ready[1] | own


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("suites: [papers]", "sensor suite 'papers': did you mean 'paper'"),
        ("gyro: {correlation_time: 0}", "gyro.correlation_time: found 0; give a time"),
        ("gyro: {correlation_time: 1 m}", "unknown unit 'm' of a time"),
        ("gyro: {misalignment: 1 mrad}", "give a 3-vector"),
        ("gyro: {constant_bias: [1 g, 0, 0]}", "unknown unit 'g' of an angular rate"),
        ("joints: {position: 0, drop_out: 2}", "found 2; give a probability"),
        ("joints: {position: 0, latency: -1 s}", "found '-1 s'; give zero or more"),
        ("position: {std: 0, rate: 0 Hz}", "found '0 Hz'; give a rate above zero"),
        ("position: {std: 0, markov_std: 1 um}", "needs a correlation_time beside it"),
        ("attitude: {angle: 0, correlation_time: 1}", "needs a markov_std beside it"),
        ("position: {std: 0, random_walk: 1 m}", "unknown unit 'm' of a length random"),
        ("position: {std: 0, markov_std: [1, 2]}", "one for each of x, y, z"),
        (
            "position: {std: 0, markov_std: 1, correlation_time: 0}",
            "give a time above zero",
        ),
    ],
)
def test_what_no_sensor_can_be_is_refused(load_yaml, section, message):
    with pytest.raises(InputError, match=message):
        load_yaml(f"sensors: {{{section}}}")
