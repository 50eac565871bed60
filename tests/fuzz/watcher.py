"""Runs cases in a worker, and watches its time, its memory, and whether it lives."""

import json
import os
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from case import Case

WORKER = Path(__file__).parent / "worker.py"

LONGEST = 60.0
"""Seconds of the processor that a case may take: other programs do not count."""
IDLE = 4.0
"""Times as long a case may take by the clock: what waits for ever uses no processor."""
MOST_MEMORY = 2 * 1024**3
"""Bytes a case may hold."""
LOOKS = 0.05
"""Seconds between two looks at a worker's memory."""
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""Threads that wait for each other on a busy machine use the processor too."""
RENEWED_AT = 1400 * 1024**2
"""Bytes held between two cases at which a worker is replaced: they are the libraries'
memory of all cases before, not of the next one."""

HANG, HEAVY = "hang", "memory"


@dataclass(frozen=True)
class Outcome:
    """What a case came to."""

    status: int
    """The exit status; negative where a signal ended the process."""
    out: str
    err: str
    seconds: float
    """Time of the processor."""
    peak: int
    """Bytes."""
    stopped: str = ""
    """`hang` or `memory` where the watcher ended the process, else empty."""
    left: Mapping[str, bytes] = field(default_factory=dict)
    """Files in the folder that were not there before, or have changed."""


class Watcher:
    """One worker, replaced when it dies or has grown."""

    def __init__(self, environment: dict[str, str] | None = None):
        """No worker is started before the first case.

        Args:
            environment: variables beside those of this process.
        """
        self._environment = os.environ | ONE_THREAD | (environment or {})
        self._worker: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> "Watcher":
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """End the worker."""
        self._end()

    def run(self, case: Case, fresh: bool = False, longest: float = LONGEST) -> Outcome:
        """The outcome of a case in a folder of its own.

        Args:
            case: what to run.
            fresh: in a new process, which no other case has touched.
            longest: seconds of the processor that it may take.
        """
        if fresh:
            self._end()
        with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
            folder, output = Path(place) / "folder", Path(place) / "output"
            folder.mkdir()
            output.mkdir()
            case.write(folder)
            worker = self._started()
            request = {"folder": str(folder), "output": str(output)}
            request |= {"arguments": case.arguments, "setting": case.setting}
            answer = self._ask(worker, request, longest)
            return Outcome(
                status=answer["status"],
                out=_text(output / "out"),
                err=_text(output / "err"),
                seconds=answer["seconds"],
                peak=answer["peak"],
                stopped=answer.get("stopped", ""),
                left=_left(case, folder),
            )

    def _started(self) -> subprocess.Popen[bytes]:
        if self._worker is None:
            self._worker = subprocess.Popen(
                [sys.executable, str(WORKER)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=self._environment,
            )
            # Imports are no case's time.
            with tempfile.TemporaryDirectory() as place:
                request = {"folder": place, "output": place, "setting": ""}
                request |= {"arguments": ["robots"]}
                answer = self._ask(self._worker, request, LONGEST)
            if answer["status"] != 0:
                raise RuntimeError(
                    "the worker does not start: run tests/fuzz/worker.py"
                )
        return self._worker

    def _ask(
        self, worker: subprocess.Popen[bytes], request: dict[str, Any], longest: float
    ) -> dict[str, Any]:
        assert worker.stdin is not None
        assert worker.stdout is not None
        before, start = _used(worker.pid), time.monotonic()
        seconds, peak = 0.0, 0
        worker.stdin.write(json.dumps(request).encode() + b"\n")
        worker.stdin.flush()
        while not select.select([worker.stdout], [], [], LOOKS)[0]:
            look = _used(worker.pid)
            seconds, peak = look.seconds - before.seconds, max(peak, look.held)
            late = time.monotonic() - start > IDLE * longest
            stopped = HANG if late or seconds > longest else ""
            stopped = HEAVY if peak > MOST_MEMORY else stopped
            if stopped:
                self._end()
                seen = {"seconds": seconds, "peak": peak}
                return {"status": -9, "stopped": stopped, **seen}
        line = worker.stdout.readline()
        seconds = max(seconds, _used(worker.pid).seconds - before.seconds)
        if not line:
            self._end()
            status = worker.returncode
            return {"status": status, "seconds": seconds, "peak": peak}
        answer = json.loads(line)
        # What was opened while standard input was closed took its number.
        if answer["held"] > RENEWED_AT or request["setting"]:
            self._end()
        return answer | {"seconds": seconds}

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.kill()
            self._worker.communicate(timeout=LONGEST)
            self._worker = None


class _Look(NamedTuple):
    """What a process and those that it has started have used when it is looked at."""

    seconds: float
    """Time of the processor since the process started."""
    held: int
    """Memory, bytes."""


def _used(pid: int) -> _Look:
    # Fields 14 to 17 and 24 of proc(5); the second is a name in brackets.
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    seconds = sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    held = int(fields[21]) * os.sysconf("SC_PAGESIZE")
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        # It may have ended by now; its time then counts as that of its parent.
        with suppress(OSError):
            look = _used(int(child))
            seconds, held = seconds + look.seconds, held + look.held
    return _Look(seconds, held)


def _text(path: Path) -> str:
    return path.read_text(errors="backslashreplace") if path.exists() else ""


def _left(case: Case, folder: Path) -> dict[str, bytes]:
    found = {
        os.fsdecode(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    return {
        name: content
        for name, content in found.items()
        if case.files.get(name) != content
    }
