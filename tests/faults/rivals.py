"""Processes that write to one place, and others that read there meanwhile.

Run as a program: a fork of a process that has threads, as pytest's may, is not safe.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

from crash_points import MEMORY, NEW, OLD, check_complete, leftovers, save

from orbident.errors import InputError
from orbident.files.replacing import write_text

LASTS = 3.0
"""Seconds: some hundred replacements."""


def in_a_fork(act) -> int:
    """A process that repeats `act` as long as it is meant to last."""
    child = os.fork()
    if child == 0:
        try:
            end = time.monotonic() + LASTS
            while time.monotonic() < end:
                act()
            os._exit(0)
        except BaseException as error:
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
            os._exit(1)
    return child


def patiently(act) -> None:
    """What may be refused because of the other; nothing else may be wrong with it."""
    try:
        act()
    except InputError as error:
        if "another orbident process is writing there" not in str(error):
            raise


def run_folders(place: Path) -> list[int]:
    """Two that replace a RUN, two that read it."""
    folder = place / "run"
    save(OLD, folder)
    writers = [
        in_a_fork(lambda result=result: patiently(lambda: save(result, folder)))
        for result in (OLD, NEW)
    ]
    return [*writers, *(in_a_fork(lambda: _read(folder)) for _ in range(2))]


def _read(folder: Path) -> None:
    from orbident.identified.run_folder import load_result

    assert load_result(folder).mass.value in {1.0, 2.0}


def single_files(place: Path) -> list[int]:
    """Two that replace a file, one that reads it."""
    path = place / "a.txt"
    contents = {"first" * 5000, "second" * 9000}
    path.write_text(min(contents))

    def read() -> None:
        assert path.read_text() in contents

    return [
        in_a_fork(read),
        *(
            in_a_fork(lambda text=text: patiently(lambda: write_text(path, text)))
            for text in contents
        ),
    ]


def main() -> None:
    """End with status 1 if any process saw what it must not."""
    disk = MEMORY if MEMORY.is_dir() else None
    with tempfile.TemporaryDirectory(dir=disk) as name:
        place = Path(name)
        children = [*run_folders(place), *single_files(place)]
        statuses = [os.waitpid(child, 0)[1] for child in children]
        check_complete(place / "run")
        assert leftovers(place) == []
    sys.exit(max(statuses) != 0)


if __name__ == "__main__":
    main()
