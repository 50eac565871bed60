"""`compare`: what was captured between two runs."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_results import REFUSED, exact_result, freed, joined, without
from running import Orbident, resealed

from orbident.identified.run_folder import save_result
from orbident.robot.parameters import SYMBOLS, from_mass_com_inertia
from orbident.robot.robot_file import load_robot

TARGET = from_mass_com_inertia(
    50.0, np.array([0.4, 0.1, -0.2]), np.diag([6.0, 5.0, 4.0])
)


@pytest.fixture
def runs() -> None:
    """`before`, and `after` with another structure."""
    robot = load_robot("paper-spatial")
    save_result(exact_result(robot, 1, 1e-6), Path("before"))
    holding = joined(freed(robot, "link3"), "link3", TARGET)
    save_result(exact_result(holding, 2, 1e-6), Path("after"))


def test_a_capture(orbident: Orbident, runs: None):
    out = orbident("compare", "before", "after").done().out
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert "captured on link3; in the frame of link3" in lines
    assert any(line.startswith("mass, kg 50") for line in lines)
    assert any(line.startswith("cz, m -0.2") for line in lines)
    assert any(line.startswith("Ixx, about its CM, kg m^2 6") for line in lines)

    document = orbident("compare", "before", "after", "--json", "-").done().json
    assert (document["status"], document["body"]) == ("changed", "link3")
    assert document["change"]["p"] < 1e-9
    assert document["explanations"][0]["body"] == "link3"
    added = document["added"]
    low, high = added["mass"]["interval"]
    assert low < 50.0 < high
    assert high - low == pytest.approx(2 * 1.96 * added["mass"]["std"])
    assert added["theta"]["names"] == list(SYMBOLS)
    np.testing.assert_allclose(added["theta"]["values"], TARGET, atol=0.1)
    assert np.shape(added["theta"]["covariance"]) == (10, 10)
    assert len(added["inertia_about_com"]["intervals"]) == 6
    assert orbident("compare", "before", "after", "--quiet").done().out == ""


def test_a_release(orbident: Orbident, runs: None):
    out = orbident("compare", "after", "before", "--body", "link3").done().out
    assert "let go on link3" in out
    assert orbident("compare", "after", "before", "--json", "o.json").done()
    document = json.loads(Path("o.json").read_text())
    assert document["added"]["mass"]["value"] == pytest.approx(-50.0, abs=0.1)
    assert document["added"]["com"]["values"] == pytest.approx(
        [0.4, 0.1, -0.2], abs=0.01
    )


def test_no_change(orbident: Orbident, runs: None):
    ran = orbident("compare", "before", "before", "--json", "-").done()
    assert (ran.json["status"], ran.json["added"]) == ("no change", None)
    assert "no change" in orbident("compare", "before", "before").done().out


def test_parameters_that_are_not_determined(orbident: Orbident, runs: None):
    robot = load_robot("cepheus-like")
    a, b = (exact_result(r, 1, 1e-6) for r in (robot, freed(robot, "link2")))
    held = joined(b.robot, "link2", TARGET / 50)
    b = exact_result(held, 2, 1e-6)
    save_result(a, Path("a"))
    save_result(b, Path("b"))
    ran = orbident("compare", "a", "b").done()
    assert "Ixx is not determined: does not show in the momentum of planar" in ran.out
    told = orbident("compare", "a", "b", "--json", "-").done().json
    assert told["added"]["com"]["values"][2] is None
    assert told["added"]["mass"]["value"] == pytest.approx(1.0, abs=1e-3)

    save_result(without(b, "M"), Path("c"))
    ran = orbident("compare", "a", "c")
    assert ran.status in {0, 1}
    assert "internal error" not in ran.err


def test_untrusted(orbident: Orbident, runs: None):
    robot = load_robot("paper-spatial")
    rejected = replace(exact_result(robot), checks=(REFUSED,))
    save_result(rejected, Path("bad"))
    for arguments, words in (
        (("before", "bad"), "the run after is refused, so nothing is compared: mass"),
        (("before", "after", "--body", "link1"), "does not explain the change"),
    ):
        ran = orbident("compare", *arguments, "--json", "-")
        assert ran.status == 1
        assert ran.err.startswith("orbident: warning: ")
        assert words in ran.err
        assert ran.json["status"] == "rejected"
        assert ran.json["added"] is None
        assert orbident("compare", *arguments).status == 1


def test_refusals(orbident: Orbident, runs: None):
    def refused(*arguments: str, words: str):
        orbident("compare", *arguments).refused(words)

    refused("before", words="Missing argument 'AFTER'")
    refused("before", "nowhere", words="nowhere/result.json: cannot be read")
    refused("before", "after", "--body", "link4", words="no body 'link4'; did you mean")
    refused(
        "before", "after", "--json", "no/x.json", words="folder 'no' does not exist"
    )
    save_result(exact_result(load_robot("dual-arm")), Path("other"))
    refused("before", "other", words="body 'link1' is in the run before only")

    text = Path("after/robot.yaml").read_text()
    assert "inertia: 0.18" in text
    Path("after/robot.yaml").write_text(
        text.replace("inertia: 0.18", "inertia: 0.2", 1)
    )
    resealed(Path("after"))
    refused("before", "after", words="wheel 'rw_x': inertia (kg m^2): 0.18 before, 0.2")
    Path("after/robot.yaml").write_text(text)

    document = json.loads(Path("after/result.json").read_text())
    document["base"]["covariance"] = document["base"]["covariance"][:-1]
    Path("after/result.json").write_text(json.dumps(document))
    resealed(Path("after"))
    refused("before", "after", words="the covariance is not 23 by 23")
    del document["base"]["covariance"]
    Path("after/result.json").write_text(json.dumps(document))
    resealed(Path("after"))
    refused("before", "after", words="base.covariance: this key is missing")
