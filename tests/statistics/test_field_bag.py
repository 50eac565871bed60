"""A bag of the field is as good as the clean table it was made from."""

from typing import NamedTuple

import numpy as np
import pytest
from field_bag import IMU, MOCAP, OFFSET, field_bag, topic_map
from random_motions import Start, random_motion

import orbident as oi
from orbident.estimation.linear_fits import InitialMomentum
from orbident.model.minimal_sets import minimal_sets


class Case(NamedTuple):
    robot: str
    base: str
    momentum: InitialMomentum
    wheel_speed: float
    start: Start
    bag: str


CASES = {
    "table": Case("cepheus-like", MOCAP, "at-rest", -170.0, "spun up", "ros1"),
    "spacecraft": Case("paper-spatial", IMU, "unknown", 200.0, "turning", "ros2-mcap"),
}
SEEDS = 3
METHODS = ["least-squares", pytest.param("maximum-likelihood", marks=pytest.mark.long)]


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "case", [pytest.param("table", marks=pytest.mark.long), "spacecraft"]
)
def test_a_bag_is_identified_as_well_as_its_table(case, method, tmp_path):
    name, base, momentum, speed, start, kind = CASES[case]
    robot = oi.load_robot(name)
    sets = minimal_sets(robot)
    true = [*sets.pi(robot.theta), *sets.phi(robot.theta), robot.mass]
    motion = random_motion(robot, 3, 60.0, speed, start)
    (tmp_path / "map.yaml").write_text(topic_map(robot, base))
    errors = {"table": [], "bag": []}
    for seed in range(SEEDS):
        table = oi.simulate(robot, motion, noise="sensors", seed=seed)
        folder = tmp_path / str(seed)
        folder.mkdir()
        bag = field_bag(kind, folder, robot, table, seed)
        report = oi.convert_file(bag, tmp_path / "map.yaml", folder / "bag.parquet")
        counts = report.to_json()["topics"]
        assert all(topic["rejected"] for topic in counts)
        converted = oi.read_recording(folder / "bag.parquet")
        for source, recording in (("table", table), ("bag", converted)):
            result = oi.identify(robot, recording, method, momentum)
            assert result.status == "ok"
            found = [*result.pi.values, *result.phi.values, result.mass.value]
            errors[source].append(np.array(found) / true - 1)
        clock = result.clocks["joints"]
        assert clock.believed
        assert clock.late == pytest.approx(-OFFSET, abs=1e-3)
        assert any("the clock of joints and wheels" in w for w in result.warnings)
    rms = {key: np.sqrt(np.mean(np.square(rows))) for key, rows in errors.items()}
    assert rms["bag"] < 2 * rms["table"]
