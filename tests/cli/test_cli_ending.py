"""How a run ends: exit statuses that survive pipes, signals, and internal errors."""

import json
import signal
import time
import urllib.request
import warnings
from pathlib import Path

import pytest
from processes import ORBIDENT, finished, started
from running import LINEAR, Orbident, written

from orbident.cli import output
from orbident.recordings.recording import Recording

PROMISED = 2.0
"""s, from Ctrl-C to the end of the process."""
SLOW = 8.0
"""s more, for a machine that has other work; a run that goes on takes far longer."""

REFUSED = ("identify", "paper-spatial", "r.csv", *LINEAR)


@pytest.fixture
def refused_run(flight: Recording) -> None:
    """`r.csv`, of which no mass can be had."""
    written(flight, "r.csv", drop=["velocity", "position"], rows=slice(100))


@pytest.mark.parametrize(
    ("reader", "more"),
    [
        ("head -1", ()),
        pytest.param("true", ("--json", "-"), marks=pytest.mark.slow),
        # What these two have, the others have one by one.
        pytest.param("true", (), marks=pytest.mark.long),
        pytest.param("head -1", ("--json", "-"), marks=pytest.mark.long),
    ],
)
@pytest.mark.usefixtures("refused_run")
def test_the_status_of_a_run_whose_reader_goes(reader: str, more: tuple[str, ...]):
    """And its warnings, which come first."""
    line = f'"$@" | {reader}; exit ${{PIPESTATUS[0]}}'
    ran = finished("bash", "-c", line, "bash", *ORBIDENT, *REFUSED, *more)
    assert ran.returncode == 1
    assert "orbident: warning: phi and the mass are not determined" in ran.stderr
    assert all(line.startswith("orbident: ") for line in ran.stderr.splitlines())


@pytest.mark.slow
@pytest.mark.usefixtures("refused_run")
def test_one_reader_of_both_streams_that_goes():
    line = '"$@" 2>&1 | true; exit ${PIPESTATUS[0]}'
    assert finished("bash", "-c", line, "bash", *ORBIDENT, *REFUSED).returncode == 1


@pytest.mark.slow
@pytest.mark.usefixtures("refused_run")
def test_warnings_come_before_results():
    ran = finished("sh", "-c", '"$@" 2>&1', "sh", *ORBIDENT, *REFUSED)
    assert ran.returncode == 1
    assert ran.stdout.startswith("orbident: warning: ")


BEST_SO_FAR = "orbident: warning: interrupted: the trajectory that was written"


@pytest.mark.parametrize(
    ("number", "status", "words"),
    [
        (signal.SIGINT, 130, "orbident: interrupted\n"),
        (signal.SIGTERM, 143, "orbident: terminated\n"),
    ],
)
# s: in the imports, in the preparation, in the search.
@pytest.mark.parametrize("after", [0.4, 1.5, pytest.param(5.0, marks=pytest.mark.slow)])
def test_a_signal_ends_a_run(
    number: signal.Signals, status: int, words: str, after: float
):
    search = ("excite", "paper-spatial", "--starts", 1000, "-o", "made.yaml")
    with started(*search) as process:
        time.sleep(after)
        process.send_signal(number)
        _, said = process.communicate(timeout=PROMISED + SLOW)
    *warnings, last = said.splitlines(keepends=True)
    assert (process.returncode, last) == (status, words)
    # A search that is interrupted writes the best that it has, and says so.
    assert all(line.startswith(BEST_SO_FAR) for line in warnings)
    assert all(path.name == "made.yaml" for path in Path().iterdir())


def test_a_verb_that_does_not_unwind():
    """As in compiled code, or where an import swallows every exception."""
    stubborn = (
        "import sys, time\n"
        "from orbident.cli import app\n"
        "def stubborn():\n"
        "    print('ready', flush=True)\n"
        "    while True:\n"
        "        try: time.sleep(60)\n"
        "        except BaseException: pass\n"
        "app._run = stubborn\n"
        "app.main()\n"
    )
    Path("stubborn.py").write_text(stubborn)
    line = "import runpy; runpy.run_path('stubborn.py')"
    with started(command=(ORBIDENT[0], "-c", line)) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=PROMISED + SLOW)
    assert (process.returncode, said) == (130, "orbident: interrupted\n")


WRITING = """
import sys, time
from pathlib import Path
from orbident.cli import app
from orbident.files.replacing import replacing_files
from orbident.files.replacing import replacing
def stubborn():
    run = replacing_files(Path("new/run"), ["a"])
    with replacing(Path("file.csv")) as file, run as new:
        file.write_text("half")
        (new / "a").write_text("half")
        print("ready", flush=True)
        while True:
            try: time.sleep(60)
            except BaseException: pass
app._run = stubborn
app.main()
"""


def test_a_verb_that_does_not_unwind_leaves_nothing_half_written():
    with started(command=(ORBIDENT[0], "-c", WRITING)) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=PROMISED + SLOW)
    assert (process.returncode, said) == (143, "orbident: terminated\n")
    assert not list(Path().iterdir())


def test_it_serves_until_it_is_interrupted():
    with started(*VIEW) as process:
        said = address_of(process)
        assert said["shown"] == "cepheus-like"
        with urllib.request.urlopen(said["url"], timeout=60) as answer:
            assert answer.status == 200
        process.send_signal(signal.SIGINT)
        out, words = process.communicate(timeout=PROMISED + SLOW)
    assert (process.returncode, out, words) == (130, "", "orbident: interrupted\n")


def test_what_is_written_when_it_is_interrupted_is_written_once():
    """An interrupt that comes after the write, and before Python knows of it."""
    interrupted = (
        "import signal, sys\n"
        "from orbident.cli import app, streams\n"
        "write = streams._Pipe.write\n"
        "def written(self, data):\n"
        "    count = write(self, data)\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    return count\n"
        "streams._Pipe.write = written\n"
        f"sys.argv = {['orbident', *VIEW]}\n"
        "app.main()\n"
    )
    with started(command=(ORBIDENT[0], "-c", interrupted)) as process:
        out, words = process.communicate(timeout=PROMISED + SLOW)
    assert (process.returncode, words) == (130, "orbident: interrupted\n")
    assert json.loads(out)["shown"] == "cepheus-like"


def test_in_the_background_it_serves_until_it_is_terminated():
    with started(*VIEW, ignoring_interrupts=True) as process:
        address_of(process)
        process.send_signal(signal.SIGINT)
        time.sleep(0.5)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=PROMISED + SLOW)
    assert (process.returncode, words) == (143, "orbident: terminated\n")


VIEW = ("view", "cepheus-like", "--port", "0", "--json", "-")


def address_of(process) -> dict[str, str]:
    """What `view --json -` says, in four lines."""
    return json.loads("".join(process.stdout.readline() for _ in range(4)))


@pytest.mark.parametrize("error", [ZeroDivisionError("no"), EOFError("no")])
def test_an_internal_error_is_no_untrusted_result(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch, error: Exception
):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(output.Output, "__init__", fail)
    ran = orbident("robots")
    assert ran.status == 70
    kind = type(error).__name__
    # Typer begins a new line at the end of a file.
    said = ran.err.lstrip("\n")
    assert said.startswith(f"orbident: internal error: {kind}: no (a bug; ")
    assert said.count("\n") == 1

    monkeypatch.setenv("ORBIDENT_TRACEBACK", "1")
    ran = orbident("robots")
    assert ran.status == 70
    assert "Traceback" in ran.err
    assert f"{kind}: no" in ran.err


def test_warnings_of_libraries_are_said_in_a_line(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch
):
    def overflow(*_: object) -> None:
        warnings.warn("overflow encountered", RuntimeWarning, stacklevel=1)

    monkeypatch.setattr(output.Output, "write_json", overflow)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        ran = orbident("robots")
    assert ran.status == 0
    assert ran.err.startswith("orbident: warning: overflow encountered in a computat")
    assert ran.err.count("\n") == 1


@pytest.mark.slow
def test_no_progress_into_a_file(monkeypatch: pytest.MonkeyPatch):
    """Many CI systems set FORCE_COLOR; it makes no terminal of a file."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    for verb in (
        ("inspect", "cepheus-like"),
        ("excite", "cepheus-like", "--harmonics", "1", "--starts", "1", "-o", "m.yaml"),
    ):
        ran = finished(*ORBIDENT, *verb)
        assert (ran.returncode, ran.stderr) == (0, "")
