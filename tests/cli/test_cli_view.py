"""`orbident view`: what it refuses, what it says, and how it ends."""

import socket
from pathlib import Path

import pytest
from running import Orbident


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
