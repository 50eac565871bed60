"""The command as a process: exit status, streams, pipes, start-up."""

import json
import os
import pty
import sys
from pathlib import Path

import pytest
from processes import ORBIDENT, finished, started
from running import LINEAR, written

from orbident.recordings.recording import Recording


def refused(*arguments: object) -> str:
    ran = finished(*ORBIDENT, *arguments)
    assert ran.returncode == 2
    assert ran.stdout == ""
    assert ran.stderr.startswith("orbident: ")
    assert ran.stderr.count("\n") == 1
    assert "Traceback" not in ran.stderr
    return ran.stderr


def test_statuses_and_streams(flight: Recording):
    identify = ("identify", "paper-spatial", "r.csv", *LINEAR, "--json", "-")
    written(flight, "r.csv")
    ran = finished(*ORBIDENT, *identify)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert json.loads(ran.stdout)["status"] == "ok"

    written(flight, "r.csv", drop=["velocity", "position"])
    ran = finished(*ORBIDENT, *identify)
    assert ran.returncode == 1
    assert json.loads(ran.stdout)["status"] == "rejected"
    assert all(
        line.startswith("orbident: warning: ") for line in ran.stderr.splitlines()
    )

    written(flight, "r.csv", drop=["gyro.x"])
    assert "gyro.x" in refused(*identify)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("bogus",), "No such command 'bogus'"),
        (("inspec",), "Did you mean 'inspect'"),
        (("inspect",), "Missing argument 'ROBOT'"),
        (("inspect", "paper-spatial", "--loud"), "No such option: --loud"),
        (("simulate", "paper-spatial", "m.yaml"), "Missing option '-o'"),
        (("identify", "r", "s", "--method", "guess"), "'--method': 'guess'"),
        (("identify", "r", "s", "--initial-momentum", "x"), "'--initial-momentum'"),
        (("simulate", "r", "m", "-o", "s.csv", "--rate", "fast"), "'--rate'"),
        (("study", "lunar"), "'lunar'"),
        (("inspect", "a", "b"), "unexpected extra argument"),
        (("robots", "--json"), "'--json' requires an argument"),
    ],
)
def test_wrong_usage(orbident, arguments: tuple[str, ...], words: str):
    line = orbident(*arguments).refused(words)
    assert line.rstrip().endswith("--help")


def test_wrong_usage_of_the_process():
    assert "No such command" in refused("bogus")


@pytest.mark.parametrize("verb", ["robots", "inspect", "simulate", "identify"])
def test_help(orbident, verb: str):
    words = orbident(verb, "--help").done().out
    assert f"Usage: orbident {verb}" in words
    assert "--json" in words
    assert "--quiet" in words


def test_help_without_arguments_and_version(orbident):
    words = orbident().done().out
    for verb in ("robots", "inspect", "simulate", "identify", "validate", "study"):
        assert f"  {verb} " in words
    assert orbident("--help").done().out == words
    assert orbident("--version").done().out.startswith("orbident ")


def test_a_reader_that_goes_away():
    """`orbident robots | true`, with pipefail."""
    with started("robots") as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(timeout=60) == 0
        process.stdout = None


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs Linux's /dev/full")
def test_a_full_disk():
    with Path("/dev/full").open("w") as full:
        ran = finished(*ORBIDENT, "robots", stdout=full)
    assert ran.returncode == 2
    assert ran.stderr == "orbident: standard output: No space left on device\n"


def test_no_output_at_all():
    ran = finished("sh", "-c", '"$@" >&-', "sh", *ORBIDENT, "robots")
    assert (ran.returncode, ran.stderr) == (0, "")


def test_names_that_the_terminal_cannot_show():
    Path("r.urdf").write_text(
        '<robot name="Gelenk-ä"><link name="b"><inertial><mass value="1"/><inertia '
        'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>',
        encoding="utf-8",
    )
    ascii_only = os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    ran = finished(*ORBIDENT, "inspect", "r.urdf", env=ascii_only)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "Gelenk-\\xe4" in ran.stdout


def test_progress_in_a_terminal(flight: Recording):
    """On standard error, and gone when it is done; none in a pipe."""
    written(flight, "r.csv")
    terminal, inside = pty.openpty()
    verb = ("identify", "paper-spatial", "r.csv", "--json", "-", *LINEAR)
    with started(*verb, stderr=inside) as process:
        os.close(inside)
        shown = b""
        # Linux reports the end of a terminal as an error.
        try:
            while block := os.read(terminal, 1 << 12):
                shown += block
        except OSError:
            pass
        out, _ = process.communicate(timeout=300)
    os.close(terminal)
    assert process.returncode == 0
    assert json.loads(out)["status"] == "ok"
    assert b"identifying" in shown
    # The line is erased at last.
    assert shown.rstrip().endswith(b"\x1b[2K") or b"\x1b[1A" in shown[-60:]


HEAVY = ("numpy", "scipy", "pyarrow", "pydantic", "plotly")


def test_help_loads_nothing_heavy():
    """What keeps `orbident --help` below half a second, without a clock."""
    code = (
        "import sys; import orbident.cli.verbs; "
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    ran = finished(sys.executable, "-c", code)
    assert (ran.stdout, ran.stderr) == ("[]\n", "")


def test_importing_the_package_loads_nothing_heavy():
    code = (
        "import sys; import orbident; "
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    ran = finished(sys.executable, "-c", code)
    assert (ran.stdout, ran.stderr) == ("[]\n", "")
