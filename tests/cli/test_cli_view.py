"""`orbident view`: what it refuses, what it says, and how it ends."""

import json
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
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


def test_it_serves_until_it_is_interrupted():
    command = [sys.executable, "-m", "orbident.cli.app", "view", "cepheus-like"]
    with subprocess.Popen(
        [*command, "--port", "0", "--json", "-"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        lines = [process.stdout.readline() for _ in range(4)]
        said = json.loads("".join(lines))
        assert said["shown"] == "cepheus-like"
        with urllib.request.urlopen(said["url"]) as answer:
            assert answer.status == 200
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
        assert process.stdout.read() == ""
        assert process.stderr.read() == ""


def test_a_viewer_on_the_network_says_so_and_asks_for_its_token():
    command = [sys.executable, "-m", "orbident.cli.app", "view", "cepheus-like"]
    with subprocess.Popen(
        [*command, "--port", "0", "--host", "0.0.0.0", "--json", "-"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stderr is not None
            url = json.loads("".join(process.stdout.readline() for _ in range(4)))[
                "url"
            ]
            warning = process.stderr.readline()
            assert "the viewer is open to the network" in warning
            assert url in warning
            port, path = url.rpartition(":")[2].split("/", 1)
            own = f"http://127.0.0.1:{port}/"
            with urllib.request.urlopen(own + path, timeout=60) as answer:
                assert answer.status == 200
            with pytest.raises(urllib.error.HTTPError, match="403") as refused:
                urllib.request.urlopen(own, timeout=60)
            refused.value.close()
        finally:
            process.terminate()
            process.wait(timeout=20)
