"""`orbident robots` and `orbident inspect`."""

import json
from pathlib import Path

import pytest
import yaml
from running import Orbident

from orbident.robot.robot_file import load_robot, write_robot

BUNDLED = ("cepheus-like", "dual-arm", "paper-spatial")


def test_robots_lists_the_bundled_ones(orbident: Orbident):
    ran = orbident("robots").done()
    for name in BUNDLED:
        assert name in ran.out


def test_robots_json(orbident: Orbident):
    robots = orbident("robots", "--json", "-").done().json["robots"]
    assert [robot["name"] for robot in robots] == list(BUNDLED)
    assert robots[1] == {
        "name": "dual-arm",
        "motion": "spatial",
        "joints": 14,
        "wheels": 3,
        "mass": pytest.approx(1354.67),
    }


@pytest.mark.parametrize(
    ("robot", "pi", "phi", "base"),
    [
        ("paper-spatial", 19, 5, 18),
        ("cepheus-like", 8, 4, 8),
        ("dual-arm", None, 31, 108),
    ],
)
def test_inspect_counts(
    orbident: Orbident, robot: str, pi: int | None, phi: int, base: int
):
    count = orbident("inspect", robot, "--json", "-").done().json["count"]
    assert count["pi"] == (pi or count["pi"])
    assert (count["phi"], count["base"]) == (phi, base)


def test_inspect_counts_without_structure(orbident: Orbident, tmp_path: Path):
    path = write_robot(load_robot("paper-spatial"), tmp_path)
    document = yaml.safe_load(path.read_text())
    del document["structure"]
    path.write_text(yaml.safe_dump(document))
    count = orbident("inspect", path, "--json", "-").done().json["count"]
    assert count == {"pi": 45, "phi": 9, "base": 31}


def test_inspect_fits_two_screens(orbident: Orbident, tmp_path: Path):
    """What is too much for them is shown with `--all`."""
    path = write_robot(load_robot("paper-spatial"), tmp_path)
    document = yaml.safe_load(path.read_text())
    del document["structure"]
    path.write_text(yaml.safe_dump(document))
    brief = orbident("inspect", path).done().out.splitlines()
    assert len(brief) <= 48
    assert "  and 7 more" in brief
    assert any(line.split()[:3] == ["total", "mass", "M"] for line in brief)
    every = orbident("inspect", path, "--all").done().out
    assert "  M                1110   m(base) + m(link1) + m(link2) + m(link3)" in every
    assert "  pi_45 " in every


def test_inspect_json(orbident: Orbident):
    document = orbident("inspect", "paper-spatial", "--json", "-").done().json
    assert set(document) == {
        "name",
        "bodies",
        "joints",
        "wheels",
        "mass",
        "count",
        "pi",
        "phi",
        "base",
        "unidentifiable",
        "warnings",
    }
    assert document["name"] == "paper-spatial"
    assert document["bodies"] == ["base", "link1", "link2", "link3"]
    assert document["joints"] == ["joint1", "joint2", "joint3"]
    assert document["wheels"] == ["rw_x", "rw_y", "rw_z"]
    assert document["mass"] == 1110.0
    for name, count in document["count"].items():
        entries = document[name]
        assert set(entries) == {"names", "formulas", "values"}
        assert {len(values) for values in entries.values()} == {count}
    assert document["base"]["names"][0] == "M"
    assert document["base"]["values"][0] == pytest.approx(1110.0)
    assert document["warnings"] == []


def test_inspect_writes_its_json_to_a_file_too(orbident: Orbident, tmp_path: Path):
    ran = orbident("inspect", "cepheus-like", "--json", "found.json").done()
    assert "cepheus-like: planar, 13.56 kg" in ran.out
    assert json.loads((tmp_path / "found.json").read_text())["name"] == "cepheus-like"
    assert list(tmp_path.iterdir()) == [tmp_path / "found.json"]


def test_inspect_says_what_cannot_be_identified(orbident: Orbident, tmp_path: Path):
    out = orbident("inspect", "cepheus-like").done().out
    assert "not identifiable from free floating" in out
    assert "link1: not seen at all: Ixx, Ixy, Iyy, Ixz, Iyz" in out

    robot = load_robot("cepheus-like")
    (tmp_path / "wheelless.urdf").write_text(robot.urdf)
    document = orbident("inspect", "wheelless.urdf", "--json", "-").done().json
    assert "declare the robot's wheels" in document["unidentifiable"][0]


def test_quiet_prints_nothing(orbident: Orbident):
    assert orbident("robots", "--quiet").done().out == ""
    assert orbident("inspect", "cepheus-like", "--quiet").done().out == ""
