"""A function in a child process whose time and memory are limited.

For libraries that compile, run or unpack what a file says: such a file may be small and
ask for hours and gigabytes, and where a library crashes, only the child ends.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

from orbident.errors import InputError

_WAITING = 10
"""So many times the limit of processor time may pass on the clock: other programs may
be busy, but what waits for something that never comes uses no processor."""

_FAILED, _REFUSED, _FULL = 1, 2, 3
"""How the child ends where the function gives nothing; Python's own is 1."""


class ConfinedError(RuntimeError):
    """The function was stopped; a predicate: "needs more than 4 s of the processor"."""


def confined(
    function: Callable[..., Any], *arguments: Any, seconds: int, megabytes: int
) -> Any:
    """Call a function in a process of its own, which imports what it needs itself.

    It is found by the name of its module; arguments, and what it returns, are what JSON
    holds. It may use so many seconds of the processor and, on Linux, megabytes beside
    what Python needs.

    Raises:
        InputError: the function raised it.
        ConfinedError: it used too much, or the child crashed.
    """
    request = [function.__module__, function.__qualname__, arguments]
    try:
        child = subprocess.run(
            [sys.executable, "-P", "-m", __name__, str(seconds), str(megabytes)],
            input=json.dumps(request).encode(),
            capture_output=True,
            check=False,
            # Each thread of a BLAS would take address space.
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            timeout=_WAITING * seconds,
        )
    except subprocess.TimeoutExpired:
        raise ConfinedError(f"takes more than {_WAITING * seconds} s") from None
    if child.returncode == 0:
        return json.loads(child.stdout)
    if child.returncode == _REFUSED:
        raise InputError(json.loads(child.stdout))
    if child.returncode == _FULL:
        raise ConfinedError(f"needs more than {megabytes} MB of memory")
    if child.returncode == _FAILED:
        raise RuntimeError(child.stderr.decode(errors="replace"))
    if sys.platform != "win32" and child.returncode == -signal.SIGXCPU:
        raise ConfinedError(f"needs more than {seconds} s of the processor")
    raise ConfinedError("crashes")


def _serve(seconds: int, megabytes: int) -> int:
    """Do what standard input asks; the status to end with."""
    # Libraries print; standard output holds nothing but the answer.
    answer = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)
    module, name, arguments = json.load(sys.stdin)
    function = attrgetter(name)(import_module(module))
    _limit(seconds, megabytes)
    try:
        status, said = 0, json.dumps(function(*arguments))
    except InputError as error:
        status, said = _REFUSED, json.dumps(str(error))
    except MemoryError:
        return _FULL
    with answer:
        answer.write(said)
    return status


def _limit(seconds: int, megabytes: int) -> None:
    """Limit what is used from now on."""
    if sys.platform == "win32":
        return
    import resource

    def lower(what: int, limit: int) -> None:
        """Lower the limit at which a signal comes, or memory is refused."""
        hard = resource.getrlimit(what)[1]
        if hard != resource.RLIM_INFINITY:
            limit = min(limit, hard)
        resource.setrlimit(what, (limit, hard))

    # A crash shall leave no file of the memory behind.
    lower(resource.RLIMIT_CORE, 0)
    lower(resource.RLIMIT_CPU, int(time.process_time()) + 1 + seconds)
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + megabytes * 1_000_000
        lower(resource.RLIMIT_AS, most)


if __name__ == "__main__":
    sys.exit(_serve(*map(int, sys.argv[1:])))
