"""The how-to page on captures, from end to end: noise, 50 kg, maximum likelihood."""

import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import yaml
from made_results import joined
from random_motions import random_motion
from running import Orbident

from orbident.recordings.tables import write_recording
from orbident.robot.parameters import from_mass_com_inertia
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "after-a-capture.md"
NUMBER = re.compile(r"(?<=\s)-?\d[\d.]*(e[-+]\d+)?(?=[\s,)])")
I_COM = np.array([[6.0, 0.5, -0.3], [0.5, 5.0, 0.2], [-0.3, 0.2, 4.0]])
TARGET = from_mass_com_inertia(50.0, np.array([0.4, 0.1, -0.2]), I_COM)


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)


def words(text: str) -> list[str]:
    """Lines without their numbers, whose last digits depend on the machine."""
    return [" ".join(NUMBER.sub("", f" {line} ").split()) for line in text.splitlines()]


def test_the_page(orbident: Orbident):
    library = Path(str(files("orbident.robot") / "library"))
    Path("servicer.urdf").write_text((library / "paper-spatial.urdf").read_text())
    before = yaml.safe_load((library / "paper-spatial.yaml").read_text())
    before["urdf"] = "servicer.urdf"
    (text,) = blocks("yaml")
    after = {**before, **yaml.safe_load(text)}
    Path("servicer.yaml").write_text(yaml.safe_dump(before))
    Path("holding.yaml").write_text(yaml.safe_dump(after))
    # As the page says: all that differs.
    assert before["structure"].pop("link3")
    assert before == after

    robot = load_robot("servicer.yaml")
    held = joined(load_robot("holding.yaml"), "link3", TARGET)
    for seed, (name, flown) in enumerate({"before": robot, "after": held}.items()):
        motion = random_motion(robot, seed=seed, duration=60.0)
        recording = simulate(flown, motion, noise="sensors", seed=seed)
        write_recording(recording, f"{name}.parquet")
    *identify, compare = (text.split()[1:] for text in blocks("sh"))
    for command in identify:
        assert orbident(*command).status == 0
    (shown,) = blocks("text")
    assert words(orbident(*compare).done().out) == words(shown)

    added = orbident(*compare, "--json", "-").done().json["added"]
    mass = added["mass"]
    assert abs(mass["value"] - 50.0) < 3 * mass["std"]
    # Some grams: moments show it, better than the total mass does.
    assert mass["std"] < 0.05
    C, theta = (
        np.array(added["theta"]["covariance"]),
        np.array(added["theta"]["values"]),
    )
    error = theta - TARGET
    # Chi-square with 10 degrees of freedom: more than this once in 10000.
    assert error @ np.linalg.solve(C, error) < 35.6
