"""Joints that nobody measures, as robot files write them."""

import numpy as np
import pytest
from urdf_texts import ARM

from orbident.errors import InputError
from orbident.estimation.weigh import weigh
from orbident.recordings.recording import Recording
from orbident.robot.description import Passive
from orbident.simulation.simulate import simulate
from orbident.trajectories.trajectory_file import load_trajectory

MOTION = """\
schema: orbident/trajectory/1
duration: 10.0
joints: {joint1: {a: [0.05], b: [0.05]}, joint2: {a: [0.05], b: [0.05]}}
"""

RATE = "joint2: {frequency: 0.5 Hz"


def test_in_units(load_yaml):
    found = load_yaml(f"passive: {{{RATE}, damping: 0.5 %, tolerance: 10 %}}}}")
    assert found.passive == {"joint2": Passive(0.5, 0.005, 0.1)}
    assert found.tolerances.joint_frequency == {"joint2": 0.1}
    assert load_yaml().passive == {}


def test_one_make(load_yaml):
    found = load_yaml(f"passive: {{{RATE}}}, joint1: {{like: joint2}}}}").passive
    assert found["joint1"] == found["joint2"]._replace(like="joint2")


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("elbow: {frequency: 1 Hz}", "passive: no joint 'elbow'"),
        ("joint1: {frequency: 0}", "passive.joint1.frequency: found 0; give a rate"),
        ("joint1: {damping: 1 %}", "frequency: this key is missing"),
        ("joint1: {frequency: 1 Hz, damping: -1 %}", "give a damping, such as 0.5 %"),
        ("joint1: {frequency: 1 Hz, damping: 0}", "found 0; give a damping, such as"),
        ("joint1: {rate: 1 Hz}", "unknown key 'rate'"),
        ("joint1: {like: joint2}", "name another joint beside it, with a frequency"),
        ("joint1: {like: joint1}", "name another joint beside it, with a frequency"),
        (
            f"{RATE}}}, joint1: {{like: joint2, frequency: 2 Hz}}",
            "like: joint2 gives frequency and damping; leave out the rest",
        ),
    ],
)
def test_what_is_wrong_is_one_line(load_yaml, entry, words):
    with pytest.raises(InputError, match=words) as error:
        load_yaml(f"passive: {{{entry}}}")
    assert "\n" not in str(error.value)


def test_a_follower_is_not_passive(load_yaml):
    mimic = ARM.replace(
        '<joint name="joint2" type="revolute">',
        '<joint name="joint2" type="revolute"><mimic joint="joint1"/>',
    )
    assert mimic != ARM
    with pytest.raises(InputError, match="'joint2' follows 'joint1' in the model"):
        load_yaml(f"passive: {{{RATE}}}}}", mimic)


def test_what_takes_none_says_so(load_yaml):
    robot = load_yaml(f"passive: {{{RATE}}}}}")
    with pytest.raises(InputError, match=r"is passive, and the .* has it fixed"):
        weigh(robot, Recording(np.arange(3.0), {}, "burn.csv"))


def test_it_is_simulated_and_nothing_shows_it(load_yaml, tmp_path):
    """A trajectory moves the others; the joint is what its spring lets it be."""
    robot = load_yaml(f"passive: {{{RATE}}}}}\nsensors: {{torques: {{std: 0.1}}}}")
    path = tmp_path / "motion.yaml"
    path.write_text(MOTION)
    with pytest.raises(InputError, match="has 'joint1', passive ones apart"):
        simulate(robot, load_trajectory(path))
    path.write_text(MOTION.replace(", joint2: {a: [0.05], b: [0.05]}", ""))
    motion = load_trajectory(path)
    ordered = motion.for_robot(robot)
    assert np.array_equal(ordered.for_robot(robot).start, ordered.start)
    for noise in ("none", "sensors"):
        recording = simulate(robot, motion, noise=noise)
        shown = [name for name in recording.columns if name.startswith("joint.joint2")]
        assert shown == []
        assert recording.with_joints_of(robot)
    true = simulate(robot, motion, noise="sensors", truth=True)
    assert true.column("truth.joint.joint2.position").any()


def test_a_joint_is_passive_or_measured(load_yaml):
    """A column of zeros is what a simulator writes of a joint that it holds."""
    robot = load_yaml(f"passive: {{{RATE}}}}}")
    t = np.linspace(0.0, 1.0, 5)
    columns = {"joint.joint1.position": t, "joint.joint2.position": 0 * t}
    recording = Recording(t, columns, "r.csv")
    assert not recording.with_joints_of(robot).column("joint.joint2.velocity").any()
    with pytest.raises(InputError, match="joint 'joint2' is measured, and"):
        recording.with_columns({"joint.joint2.position": t}).with_joints_of(robot)
