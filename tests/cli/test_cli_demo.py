"""`demo`: a robot that CAD has wrong, from its flight to a report."""

import json
import sys
import webbrowser
from pathlib import Path

import pytest
from running import Orbident


def test_it_is_right_where_cad_is_wrong(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch
):
    # Output that is no terminal's opens no window.
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", pytest.fail)
    ran = orbident("demo", "-o", "kept", "--json", "demo.json", "--seed", 1).done()
    for words in ("its report: kept/run/report.html\n", "orbident view kept/run"):
        assert words in ran.out
    shown = json.loads(Path("demo.json").read_text())
    assert shown["status"] == "ok"
    # A chance of one in ten thousand, of eighteen independent ones.
    assert shown["farthest_std"]["identified"] < 4.5
    assert shown["farthest_std"]["CAD"] > 100
    assert shown["attitude_off_deg"]["identified"] < 0.5
    assert shown["attitude_off_deg"]["CAD"] > 1
    # What it leaves can be used by hand, with the robot as its file says.
    words = ("identify", "kept/run/robot.yaml", "kept/flight.csv", "--json", "-")
    found = orbident(*words).done().json
    kept = json.loads(Path("kept/run/result.json").read_text())
    assert found["mass"] == kept["mass"]


@pytest.mark.slow
def test_a_terminal_with_a_display_opens_the_report(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch
):
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setattr(webbrowser, "open", lambda url: not opened.append(url))
    monkeypatch.delenv("NO_COLOR", raising=False)
    orbident("demo", "--quiet")
    assert opened == []
    shown = orbident("demo", "--force").out
    assert "(it is open in the browser)" in shown
    # In bold green.
    assert "\npaper-spatial: \x1b[1;32m✓ trusted\x1b[0m, " in shown
    assert opened == [Path("demo/run/report.html").resolve().as_uri()]


@pytest.mark.parametrize("name", ["flight.csv", "other_flight.csv", "run/notes.txt"])
def test_it_spares_what_is_there(orbident: Orbident, name: str):
    there = Path("demo") / name
    there.parent.mkdir(parents=True)
    there.write_text("precious")
    orbident("demo").refused("demo")
    assert there.read_text() == "precious"
