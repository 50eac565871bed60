"""Where little shows how large a robot is, cost is least below zero, too."""

import pytest

import orbident as oi


def link(parent: str, joint: str) -> dict:
    shape = {"com": [0.2, 0, 0], "inertia": [0.02, 0.08, 0.08]}
    place = {"axis": [0, 0, 1], "xyz": [0.35, 0, 0.1]}
    return {"parent": parent, "joint": joint, "mass": 2.5, **shape, **place}


@pytest.fixture(scope="module")
def robot() -> oi.Robot:
    """Wheels that hardly change their speed, and a short arm that moves slowly."""
    axes = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}
    return oi.load_robot(
        {
            "name": "slow",
            "bodies": {
                "base": {"mass": 120, "com": [0, 0, 0.1], "inertia": [18, 16, 20]},
                "upper": link("base", "shoulder"),
                "lower": link("upper", "elbow"),
            },
            "feature_point": [0, 0, 0.5],
            "wheels": [
                {"name": name, "axis": axis, "inertia": 0.02}
                for name, axis in axes.items()
            ],
            "sensors": {
                "rate": 10,
                "gyro": {"angle_random_walk": "0.01 deg/sqrt(h)"},
                "joints": {"position": 1e-5},
                "wheels": {"position": 1e-5},
                "attitude": {"angle": 1e-4},
                "position": {"std": 1e-4},
            },
        }
    )


@pytest.fixture(scope="module")
def motion(robot: oi.Robot, tmp_path_factory: pytest.TempPathFactory) -> oi.Trajectory:
    file = tmp_path_factory.mktemp("motion") / "slow.yaml"
    file.write_text(
        "schema: orbident/trajectory/1\n"
        "duration: 10\n"
        "joints:\n"
        "  shoulder: {a: [0.1, -0.05], b: [0.05, 0.04]}\n"
        "  elbow: {a: [0.1, -0.05], b: [0.05, 0.04]}\n"
        "initial:\n"
        "  angular_velocity: [0.01, 0.02, 0.015]\n"
        "  wheel_speed: {x: 45, y: 45, z: 45}\n"
    )
    return oi.load_trajectory(file)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_a_good_recording_says_too_little_and_nothing_false(robot, motion, seed: int):
    result = oi.identify(robot, oi.simulate(robot, motion, noise="sensors", seed=seed))
    if result.status == "rejected":
        assert result.solved is not None
        assert result.solved.estimate.mass.value > 0
        checks = {each.name: str(each) for each in result.with_causes().checks}
        assert "cause" not in checks
        assert "record a richer or longer motion" in checks["mass"]
