"""A process killed before each of its calls of the file system, one after the other.

Run as a program: a fork of a process that has threads, as pytest's may, is not safe.
"""

import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from made_results import exact_result

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import Signal
from orbident.files.replacing import UNFINISHED, is_committed, write_text
from orbident.identified.run_folder import REPLAY, REPORT, load_result, saving
from orbident.robot.robot_file import load_robot

CHANGES = {"open", "os.mkdir", "os.remove", "os.rename", "os.rmdir"}
"""Audit events of Python before calls that change something, or may."""

Act = Callable[[], None]


def killed_before(call: int, act: Act) -> bool:
    """Whether a process was killed before this call; else it had fewer, and is done."""
    child = os.fork()
    if child == 0:
        _kill_before(call)
        act()
        os._exit(0)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


def _kill_before(call: int) -> None:
    calls = 0

    def count(event: str, _: object) -> None:
        nonlocal calls
        if event in CHANGES:
            calls += 1
            if calls == call:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(count)


def kills(act: Act, restore: Act) -> Iterator[int]:
    """Every call before which `act` can be killed, each time from the same state."""
    call = 1
    restore()
    while killed_before(call, act):
        yield call
        call += 1
        restore()


def made(mass: float, name: str) -> Result:
    """A result, told apart from others by its mass."""
    t = np.arange(50.0)
    signal_ = Signal("gyro", ("x",), ("rad/s",), t, t[:, None], t[:, None], mass)
    result = exact_result(load_robot("paper-spatial"))
    known = replace(result.mass, value=mass)
    return replace(result, mass=known, input={"file": name}, signals=lambda: (signal_,))


OLD, NEW = made(1.0, "old"), made(2.0, "new")
NOTES = {"notes.txt": "mine", "sub/notes.txt": "mine too"}


def save(result: Result, folder: Path, force: bool = True) -> None:
    """As `identify -o` does; a replay only with the old one."""
    with saving(result, folder, force) as new:
        if result is OLD:
            write_text(new / REPLAY, "{}")
        write_text(new / REPORT, f"{result.mass.value}</html>")


def check_complete(folder: Path) -> float:
    """The RUN is one of the two, with its own files and all of them; its mass."""
    result = load_result(folder)
    mass = result.mass.value
    assert result.input["file"] == {1.0: "old", 2.0: "new"}[mass]
    assert result.signals()[0].std == mass
    assert (folder / REPORT).read_text() == f"{mass}</html>"
    assert (folder / REPLAY).exists() == (mass == 1.0)
    return mass


def check_notes(folder: Path) -> None:
    for name, words in NOTES.items():
        assert (folder / name).read_text() == words


def leftovers(folder: Path) -> list[Path]:
    """What is ours and not complete."""
    return list(folder.rglob(f"*{UNFINISHED}*"))


def single_file(place: Path) -> int:
    """A file that is replaced."""
    path, count = place / "a.txt", 0
    old, new = "old" * 9999, "new" * 999
    for _ in kills(lambda: write_text(path, new), lambda: write_text(path, old)):
        assert path.read_text() in {old, new}
        assert len(leftovers(place)) <= 1
        write_text(path, new)
        assert leftovers(place) == []
        count += 1
    return count


def first_run(place: Path) -> int:
    """A RUN where there was none: refused, or complete."""
    folder, count = place / "deep" / "run", 0

    def restore() -> None:
        shutil.rmtree(place / "deep", ignore_errors=True)

    for _ in kills(lambda: save(NEW, folder, force=False), restore):
        complete = False
        with suppress(InputError):
            complete = check_complete(folder) == 2.0
        save(NEW, folder, force=complete)
        assert check_complete(folder) == 2.0
        assert leftovers(folder) == []
        count += 1
    return count


def replaced_run(place: Path) -> int:
    """A RUN with a user's own files that is replaced: the old one, or the new one."""
    folder, whole, count = place / "run", place / "whole", 0
    save(OLD, whole)
    (whole / "sub").mkdir()
    for name, words in NOTES.items():
        (whole / name).write_text(words)

    def restore() -> None:
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)

    seen = set()
    for _ in kills(lambda: save(NEW, folder), restore):
        if is_committed(folder):
            count += _kill_readers(folder)
        seen.add(check_complete(folder))
        check_notes(folder)
        save(NEW, folder)
        assert check_complete(folder) == 2.0
        check_notes(folder)
        assert leftovers(folder) == []
        count += 1
    assert seen == {1.0, 2.0}
    return count


def _kill_readers(folder: Path) -> int:
    """Who reads puts in place what was committed, and may be killed at that too."""
    count = 0
    while killed_before(8 + count, lambda: _read(folder)):
        count += 1
    assert check_complete(folder) == 2.0
    return count


def _read(folder: Path) -> None:
    load_result(folder)


CASES = (single_file, first_run, replaced_run)


MEMORY = Path("/dev/shm")
"""A disk, on Linux, for which nobody waits."""


def main() -> None:
    """Print how many kills each case saw."""
    disk = MEMORY if MEMORY.is_dir() else None
    for case in CASES:
        with tempfile.TemporaryDirectory(dir=disk) as place:
            print(case.__name__, case(Path(place)))


if __name__ == "__main__":
    main()
