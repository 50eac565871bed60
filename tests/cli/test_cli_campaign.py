"""`campaign`, its `status` and its `rerun`, as people call them."""

import json
import socket
from pathlib import Path

import pytest
from running import Orbident
from small_campaigns import write_campaign

from orbident.files.replacing import locked
from orbident.identified.run_folder import load_result


def test_a_campaign_from_beginning_to_end(orbident: Orbident, tmp_path: Path):
    spec = write_campaign(tmp_path / "given", runs=3)
    made = orbident("campaign", spec, "-o", "out", "--workers", 1, "--json", "-")
    assert made.done().json["made"] == made.json["runs"] == 3
    assert made.json["failed"] == []
    assert "least-squares" in orbident("campaign", "status", "out").done().out

    again = orbident("campaign", "rerun", "out", 2, "--json", "-")
    assert again.status == 0
    assert again.json["same"] is True
    assert set(again.json["draws"]) >= {"inertia.base.mass", "inertia.link3.com"}
    run = load_result(Path("out/rerun/2/least-squares"))
    assert (
        run.base.values.tolist()
        == again.json["results"]["least-squares"]["base"]["values"]
    )
    # The same command once more has nothing to do, and another campaign no place.
    orbident("campaign", spec, "-o", "out", "--quiet").done()
    other = write_campaign(tmp_path / "other", runs=4)
    orbident("campaign", other, "-o", "out").refused("holds another campaign")


def test_what_cannot_be_run_is_refused_in_one_line(orbident: Orbident, tmp_path: Path):
    spec = write_campaign(tmp_path, disperse={"inertia": {"gaussian": 1}})
    orbident("campaign", spec, "-o", "out").refused("unknown distribution 'gaussian'")
    orbident("campaign", "none.yaml", "-o", "out").refused("no such file")
    orbident("campaign", "status", "out").refused("is not a campaign's folder")
    orbident("campaign", "rerun", "out", 0).refused("is not a campaign's folder")
    assert not Path("out").exists()


@pytest.mark.parametrize("answers", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_cluster_that_is_none(
    orbident: Orbident,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    answers: bool,
):
    """Who takes the connection says nothing; or nobody takes it."""
    pytest.importorskip("distributed", reason="clusters need the extra 'cluster'")
    # s: ten for users.
    monkeypatch.setattr("orbident.campaigns.executors.ANSWER", 1)
    spec = write_campaign(tmp_path)
    with socket.socket() as stranger:
        stranger.bind(("127.0.0.1", 0))
        if answers:
            stranger.listen()
        address = f"tcp://127.0.0.1:{stranger.getsockname()[1]}"
        asked = orbident("campaign", spec, "-o", "out", "--cluster", address)
    asked.refused(f"--cluster {address}: does not answer as a scheduler within 1 s")
    orbident("campaign", spec, "-o", "out", "--cluster", "none.json").refused(
        "--cluster none.json: neither an address"
    )
    assert not Path("out").exists()


def test_two_commands_for_one_folder(orbident: Orbident, tmp_path: Path):
    spec = write_campaign(tmp_path / "given", runs=1)
    orbident("campaign", spec, "-o", "out", "--workers", 1, "--quiet").done()
    with locked(Path("out/rows")):
        again = orbident("campaign", spec, "-o", "out")
    again.refused("another orbident process is writing there")


def test_where_every_run_fails(orbident: Orbident, tmp_path: Path):
    tumbling = {"initial": {"angular_velocity": {"signs": "30 rad/s"}}}
    spec = write_campaign(tmp_path, runs=2, disperse=tumbling)
    made = orbident("campaign", spec, "-o", "out", "--workers", 1)
    assert made.status == 1
    assert "2 of 2 runs failed; the first is run 0: " in made.err
    assert json.loads(Path("out/failed/1.json").read_text())["run"] == 1
    orbident("campaign", "rerun", "out", 1).refused("turns")


def test_options_may_come_first(orbident: Orbident, tmp_path: Path):
    write_campaign(tmp_path / "given", runs=1)
    words = ("-o", "out", "--workers", 1, "--quiet", "given/campaign.yaml")
    orbident("campaign", *words).done()
