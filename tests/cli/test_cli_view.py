"""`orbident view`: what it refuses, what it says, and how it ends."""

import socket
from pathlib import Path

import pytest
from PIL import Image
from running import Orbident, written

from orbident.recordings.recording import Recording


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["cepheus"], "did you mean 'cepheus-like'"),
        (["."], "result.json: cannot be read"),
        (["cepheus-like", "--recording", "none.csv"], "none.csv: does not exist"),
        (["cepheus-like", "--host", "nowhere.invalid"], "--host: found"),
        (["cepheus-like", "--port", "70000"], "--port"),
    ],
)
def test_what_cannot_be_shown(orbident: Orbident, arguments: list[str], words: str):
    orbident("view", *arguments).refused(words)


def test_a_taken_port(orbident: Orbident):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        orbident("view", "cepheus-like", "--port", port).refused(f"--port: {port}")


def test_a_broken_run(orbident: Orbident):
    Path("run").mkdir()
    Path("run/result.json").write_text("{")
    orbident("view", "run").refused("run/result.json: is not JSON")


@pytest.mark.slow
def test_a_clip(orbident: Orbident, flight: Recording):
    written(flight, "r.csv", rows=slice(12))
    draw = ("view", "paper-spatial", "--recording", "r.csv", "--record", "clip.gif")
    said = orbident(*draw, "--json", "-").json
    assert said == {"shown": "paper-spatial", "clip": "clip.gif", "frames": 12}
    with Image.open("clip.gif") as clip:
        assert clip.n_frames == 12  # pyright: ignore[reportAttributeAccessIssue]
    before = Path("clip.gif").read_bytes()
    orbident(*draw).refused("clip.gif: exists already", "--force")
    # The same data give the same file.
    ran = orbident(*draw, "--force").done()
    assert ran.out == "written: clip.gif, 12 frames\n"
    assert Path("clip.gif").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--recording", "r.csv", "--record", "r.mp4"), "a clip ends in .gif"),
        (("--recording", "r.csv", "--record", "gone/r.gif"), "'gone' does not exist"),
        (("--recording", "gone.csv", "--record", "r.gif"), "gone.csv: does not exist"),
        (("--record", "r.gif"), "--record: there is no motion to draw"),
    ],
)
def test_no_clip(orbident: Orbident, arguments: tuple[str, ...], words: str):
    orbident("view", "paper-spatial", *arguments).refused(words)
    assert not list(Path().glob("*.gif"))
