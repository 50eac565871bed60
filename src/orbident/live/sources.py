"""Where lines come from: standard input, or datagrams."""

import os
import queue
import socket
import threading
from collections.abc import Iterator

from orbident.errors import InputError
from orbident.live.lines import LONGEST

BLOCK = 2**16
"""Bytes that are read at once, at most."""

BUFFER = 2**22
"""Bytes of datagrams that the system is asked to keep while we are busy."""

WAITING = 10_000
"""Datagrams that wait for the filter: ten seconds of a kilohertz."""


def lines_of_input(handle: int) -> Iterator[list[bytes]]:
    """Whole lines as they come; of what comes faster than it is taken, many at once.

    Args:
        handle: of an open file or pipe.
    """
    rest = b""
    while block := os.read(handle, BLOCK):
        *lines, rest = (rest + block).split(b"\n")
        rest = rest[:LONGEST]
        if lines:
            yield lines
    if rest:
        yield [rest]


class Datagrams:
    """Lines of UDP datagrams; those that come while too many wait are counted."""

    def __init__(self, host: str, port: int) -> None:
        """Listen.

        Raises:
            InputError: the host is no address of this machine, or the port is taken.
        """
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except (OSError, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"--udp: port {port} at '{host}' cannot be used ({reason}); give a "
                "free port, and with --host an address of this machine"
            ) from None
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        self._waiting: queue.Queue[bytes] = queue.Queue(WAITING)
        self.lost = 0
        """Datagrams that were left out because too many waited."""
        threading.Thread(target=self._receive, daemon=True).start()

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return int(self._socket.getsockname()[1])

    def lines(self) -> Iterator[list[bytes]]:
        """Lines as they come, without an end."""
        while True:
            lines = self._waiting.get().split(b"\n")
            while not self._waiting.empty() and len(lines) < WAITING:
                lines += self._waiting.get().split(b"\n")
            yield lines

    def _receive(self) -> None:
        while True:
            datagram = self._socket.recv(BLOCK)
            try:
                self._waiting.put_nowait(datagram)
            except queue.Full:
                self.lost += 1
