"""`orbident live`: lines in, JSON lines out, and a restart."""

import json
import shlex
import signal
import socket
from functools import partial
from pathlib import Path

import pytest
from live_streams import NAME, csv_lines, documents, json_lines, samples, stream_file
from processes import ORBIDENT, finished, started
from running import Orbident

COMMAND = (*ORBIDENT, "live", NAME, "--velocity-std", "1e-3", "--every", "5")
HEADER = csv_lines(samples())[0]
slow = partial(pytest.param, marks=pytest.mark.slow)
long = partial(pytest.param, marks=pytest.mark.long)


def ran(stream: Path, *options: object, status: int = 0) -> list[dict]:
    with stream.open("rb") as given:
        run = finished(*COMMAND, *options, stdin=given)
    assert (run.returncode, run.stderr) == (status, "")
    return documents(run.stdout)


def test_estimates_and_an_alarm(tmp_path: Path):
    start, *told, end = ran(stream_file(tmp_path, csv_lines(samples(15.0))))
    assert start["robot"] == NAME
    kinds = [document["event"] for document in told]
    assert sorted(kinds) == ["change", *5 * ["estimate"]]
    assert 15.0 < next(d for d in told if d["event"] == "change")["onset"] < 15.2
    assert len(end["beta"]) == len(end["std"]) == len(start["names"])
    assert end["mass"]["value"] == end["beta"][0]
    assert end["counts"]["counted"] == 579
    assert end["counts"]["unreadable"] == end["lost_datagrams"] == 0


@pytest.mark.slow
def test_a_restart_ends_with_the_same_bits(tmp_path: Path):
    lines = json_lines(samples())
    whole = ran(stream_file(tmp_path, lines))[-1]
    state = tmp_path / "state"
    ran(stream_file(tmp_path, lines[:300]), "--state", state)
    start, *_, end = ran(stream_file(tmp_path, lines[300:]), "--state", state)
    assert start["resumed_at"] == 14.35
    assert end == whole


def test_datagrams(tmp_path: Path):
    lines = json_lines(samples())
    with started("live", NAME, "--velocity-std", "1e-3", "--udp", "0") as process:
        assert process.stdout is not None
        start = json.loads(process.stdout.readline())
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.connect(("127.0.0.1", start["udp"]))
            sender.send(b"{}")
            refused = json.loads(process.stdout.readline())
            assert (refused["event"], refused["t"]) == ("unreadable", None)
            assert "found no column 't'" in refused["why"]
            for k in range(0, 200, 2):
                sender.send(b"\n".join(lines[k : k + 2]))
            sender.send(b"\xff\x00 no sample")
            sender.send(b"\n".join(lines[200:202]))
            told = json.loads(process.stdout.readline())
            assert told["event"] == "estimate"
            for _ in range(8):
                process.stdout.readline()
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=60)
    end = documents(rest)[-1]
    assert end["event"] == "end"
    assert end["counts"]["unreadable"] == 2
    # All that came in time, and what the last half second waits for.
    assert sum(end["counts"].values()) == 204
    assert end["counts"]["waiting"] == 12
    assert process.returncode == 130
    assert errors == "orbident: interrupted\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "no sample came"),
        slow(b"1,2,3\n4,5,6\n", "no line names the columns"),
        (b"{}\n" + b"\n".join(csv_lines(samples())[:20]), "1 unreadable, 19 waiting"),
        # The same words with other counts, and what `tests/unit/live` has of lines.
        long(b"t,gyro.x\n", "found no column 'joint.joint1.position'"),
        long(HEADER + 60 * (b"\n" + b",".join(20 * [b"much"])), "60 unreadable"),
        long(HEADER + 60 * (b"\n1" + 19 * b",nan"), "60 missing"),
    ],
)
def test_streams_that_cannot_be(tmp_path: Path, text: bytes, message: str):
    stream, state = tmp_path / "stream", tmp_path / "state"
    stream.write_bytes(text)
    with stream.open("rb") as given:
        run = finished(*COMMAND, "--state", state, stdin=given)
    assert run.returncode == 2
    assert message in run.stderr
    assert run.stderr.count("\n") == 1
    assert not state.exists()


def test_standard_input_that_is_closed():
    run = finished("sh", "-c", f"exec {shlex.join(COMMAND)} <&-")
    assert run.returncode == 2
    assert "standard input: no sample came" in run.stderr
    assert run.stderr.count("\n") == 1


def test_a_robot_without_noise(tmp_path: Path):
    robot = tmp_path / "robot.yaml"
    robot.write_text("schema: orbident/robot/1\nname: bare\nurdf: r.urdf\n")
    library = Path(__file__).parents[2] / "src/orbident/robot/library"
    (tmp_path / "r.urdf").write_text((library / "paper-spatial.urdf").read_text())
    with stream_file(tmp_path, csv_lines(samples())).open("rb") as given:
        run = finished(*ORBIDENT, "live", robot, stdin=given)
    assert run.returncode == 2
    assert "give gyro.angle_random_walk" in run.stderr


def test_options_that_cannot_be(orbident: Orbident):
    live = COMMAND[len(ORBIDENT) :]
    orbident(*live, "--host", "0.0.0.0").refused(
        "--host: standard input is read; add --udp PORT"
    )
    with Path(__file__).open() as lines:
        run = finished(*COMMAND, "--state", Path(__file__), stdin=lines)
    assert (run.returncode, run.stderr.count("\n")) == (2, 1)
    assert "is no state of a filter, or is damaged; name another file" in run.stderr
    orbident(*live[:-1], "0").refused("--every: found 0.0; give a number above zero")
