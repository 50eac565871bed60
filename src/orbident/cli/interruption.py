"""How a run is stopped from outside: by Ctrl-C (SIGINT) or by SIGTERM.

Either raises `KeyboardInterrupt` in the main thread, so that files are closed and
temporary ones removed. Compiled code that does not return, and imported code that
swallows the exception, would let the run go on: a second thread ends the process when
it has not ended by itself, and removes what was being written.
"""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from orbident.cli.streams import complain
from orbident.files.unfinished import undo_all

PATIENCE = 1.5
"""What it may take to unwind, s: users are promised two seconds."""

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class Interruption:
    """Which signal has asked this run to stop, if any has."""

    def __init__(self) -> None:
        """None has so far."""
        self.by: signal.Signals | None = None
        self._said = False

    def handle(self, number: int, _: object) -> None:
        """Raise at the first signal; later ones shall not disturb the unwinding."""
        if self.by is None:
            self.by = signal.Signals(number)
            raise KeyboardInterrupt

    def end(self, by: signal.Signals) -> int:
        """Say it once; the exit status that shells know: 128 and the signal."""
        if not self._said:
            self._said = True
            complain(WORDS[by])
        return 128 + by


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Let signals stop the block.

    A signal that is ignored from the start stays so, as shells want it of what runs in
    their background.
    """
    interruption = Interruption()
    heeded = [s for s in WORDS if signal.getsignal(s) is not signal.SIG_IGN]
    before = {s: signal.signal(s, interruption.handle) for s in heeded}
    # Python writes a signal's number there at once, whatever the main thread does.
    numbers, written = os.pipe()
    os.set_blocking(written, False)
    wakeup = signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    unraisable, sys.unraisablehook = sys.unraisablehook, _show_unraisable
    ended = threading.Event()
    arguments = numbers, ended, interruption
    threading.Thread(target=_watch, args=arguments, daemon=True).start()
    try:
        yield interruption
    finally:
        sys.unraisablehook = unraisable
        signal.set_wakeup_fd(wakeup)
        os.close(written)
        for each, handler in before.items():
            signal.signal(each, handler)
        if interruption.by is None:
            ended.set()


def _show_unraisable(unraisable: "sys.UnraisableHookArgs") -> None:
    """Where a finaliser has swallowed the interrupt, the second thread will end all."""
    if unraisable.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(unraisable)


def _watch(numbers: int, ended: threading.Event, interruption: Interruption) -> None:
    """End the process when it goes on for long after a signal."""
    with os.fdopen(numbers, "rb", buffering=0) as received:
        while number := received.read(1):
            if number[0] in set(WORDS) and not ended.wait(PATIENCE):
                undo_all()
                os._exit(interruption.end(signal.Signals(number[0])))
