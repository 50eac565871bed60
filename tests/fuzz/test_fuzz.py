"""The fuzzer sees what it should, and a short seeded run finds nothing."""

import os
from dataclasses import replace
from pathlib import Path
from random import Random

import mutations
import oddities
import pytest
from campaign import Campaign
from case import CLOSED, DELETED, STDIN, Case, stored
from oracle import fault, signature
from shrinking import shrunk
from watcher import HANG, HEAVY, Outcome, Watcher

SHORT = (20, 4)
"""Cases, and of these recordings to identify: some seconds of a processor."""
LONGER = (60, 16)

NO_FILES = Case("test", ("robots",), {})
DONE = Outcome(status=0, out="", err="", seconds=0.0, peak=0)


@pytest.mark.parametrize(
    ("cases", "identified"), [SHORT, pytest.param(*LONGER, marks=pytest.mark.slow)]
)
def test_a_short_run(tmp_path: Path, cases: int, identified: int):
    summary = Campaign(tmp_path, workers=1).run(cases, identified, 0, absurd=False)
    assert summary.faults == {}, summary.table()
    assert summary.cases == cases
    assert summary.groups["identify"].statuses.total() == identified


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, None),
        ({"status": 2, "err": "orbident: r.csv: give t\n"}, None),
        ({"status": 1, "err": "orbident: warning: check units\n"}, None),
        ({"status": -11}, "ended by signal 11"),
        ({"status": 3}, "status 3"),
        ({"status": 130}, "interrupted by nobody"),
        ({"status": 143}, "interrupted by nobody"),
        ({"status": 70, "err": "orbident: internal error: KeyError\n"}, "KeyError"),
        ({"status": 70}, "without a word"),
        ({"status": 2, "err": ""}, "status 2 with 0 lines"),
        ({"status": 2, "err": "orbident: a\norbident: b\n"}, "status 2 with 2 lines"),
        ({"status": 2, "err": "orbident: a\n", "out": "x"}, "standard output"),
        ({"status": 2, "err": "orbident: a\n", "left": {"r": b""}}, "leaves"),
        ({"status": 1}, "without a reason"),
        ({"status": 0, "err": "orbident: no\n"}, "with a refusal"),
        ({"err": "orbident: internal error: KeyError: 'x'\n"}, "internal error"),
        ({"err": "Traceback (most recent call last):\n"}, "a raw line"),
        ({"err": "f.py:1: RuntimeWarning: overflow\n"}, "a raw line"),
        ({"err": "orbident: warning: " + "x" * 2000}, "a line of 2019"),
        ({"peak": 3 * 1024**3}, "memory"),
        ({"stopped": HANG, "status": -9}, "hang"),
    ],
)
def test_what_is_wrong(changes: dict, words: str | None):
    wrong = fault(NO_FILES, replace(DONE, **changes))
    assert (wrong is None) == (words is None)
    assert words is None or words in str(wrong)


def test_json_on_standard_output():
    case = Case("test", ("robots", "--json", "-"), {})
    assert fault(case, replace(DONE, out='{"a": 1.5}')) is None
    assert fault(case, replace(DONE, out='{"a": NaN}')) is not None
    assert fault(case, replace(DONE, out='{"a"')) is not None
    to_a_file = Case("test", ("robots", "--json", "-", "--json", "r.json"), {})
    assert fault(to_a_file, replace(DONE, out="words")) is None
    help_asked = Case("test", ("robots", "--json", "-", "--help"), {})
    assert fault(help_asked, replace(DONE, out="Usage: orbident robots")) is None


def test_faults_of_one_kind_have_one_signature():
    one = "internal error: KeyError: 'abc' in row 12"
    assert signature(one) == signature("internal error: KeyError: 'x' in row 7")
    assert signature(one) != signature("internal error: ValueError: 'abc' in row 12")


def program(body: str) -> str:
    """A worker that answers its first request, and then does this."""
    return (
        "import json, os, sys\n"
        "print(json.dumps({'status': 0, 'peak': 0, 'held': 0}), flush=True)\n"
        f"sys.stdin.readline(); sys.stdin.readline()\n{body}\n"
    )


@pytest.mark.parametrize(
    ("body", "status", "stopped"),
    [
        ("while True: pass", -9, HANG),
        ("x = bytearray(400_000_000)\nimport time; time.sleep(60)", -9, HEAVY),
        ("os.kill(os.getpid(), 11)", -11, ""),
        ("os._exit(3)", 3, ""),
    ],
)
def test_a_worker_is_watched(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    body: str,
    status: int,
    stopped: str,
):
    worker = tmp_path / "worker.py"
    worker.write_text(program(body))
    monkeypatch.setattr("watcher.WORKER", worker)
    monkeypatch.setattr("watcher.MOST_MEMORY", 200_000_000)
    with Watcher() as watcher:
        outcome = watcher.run(NO_FILES, longest=1.0)
        assert (outcome.status, outcome.stopped) == (status, stopped)
        assert fault(NO_FILES, outcome) is not None
        # Another worker takes its place.
        assert watcher.run(NO_FILES, longest=1.0).status == status


def test_what_stands_for_files():
    """A FIFO is none that can be read twice; the working directory may be gone."""
    with Watcher() as watcher:
        pipe = Case("test", ("check", "fifo.urdf"), {"fifo.urdf": b"<robot"})
        assert "is a pipe" in watcher.run(pipe).err
        read = Case("test", ("campaign", "run", "/dev/stdin", "-o", "o"), {STDIN: b"a"})
        assert "/dev/stdin" in watcher.run(read).err
        gone = Case("test", ("robots",), {}, DELETED)
        assert watcher.run(gone).status == 0


def test_a_case_is_kept_whole(tmp_path: Path):
    files = {"a/b.csv": b"\0\xff", "\udcff.csv": b"", "arguments.json": b"{"}
    case = Case("test", ("identify", "\udcff.csv"), files, CLOSED)
    case.store(tmp_path / "case")
    assert stored(tmp_path / "case") == case


def test_a_case_shrinks_to_what_matters():
    rows = b"".join(b"row %d\n" % k for k in range(100))
    files = {"r.csv": rows + b"bad\n" + rows, "other": b"x" * 100}
    case = Case("test", ("weigh", "r.csv", "--quiet", "--json", "-"), files)

    def fails(each: Case) -> bool:
        return b"bad" in each.files.get("r.csv", b"") and "r.csv" in each.arguments

    small = shrunk(case, fails)
    assert small.files == {"r.csv": b"bad"}
    assert small.arguments == ("weigh", "r.csv")


@pytest.mark.parametrize("ways", [mutations.TEXT, mutations.BINARY])
def test_a_file_is_spoiled_in_the_same_way_by_the_same_seed(
    ways: tuple[mutations.Mutation, ...],
):
    content = b"name: joint1\nvalue: 1.5\n" * 10
    for seed in range(200):
        one, other = (mutations.spoiled(Random(seed), content, ways) for _ in range(2))
        assert one == other


def test_no_argument_is_beyond_what_the_system_passes():
    # Linux: 128 kB, and no zero byte.
    for each in (*oddities.WORDS, *oddities.NUMBERS):
        assert len(os.fsencode(each)) < 100_000
        assert "\0" not in each
