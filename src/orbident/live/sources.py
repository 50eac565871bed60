"""Where lines come from: standard input, or datagrams."""

import os
import socket
import sys
import threading
import time
from collections.abc import Iterator
from typing import TextIO

from orbident.errors import InputError
from orbident.live.lines import LONGEST

BLOCK = 2**16
"""Bytes that are taken at once, at most; no datagram is longer."""

ATONCE = 2**20
"""Bytes of datagrams that are taken at once, at most: a third of a second of 10 kHz."""

KERNEL = 2**22
"""Bytes that the system is asked to keep while the receiving thread does not run."""

WAITING = 2**26
"""Bytes that wait for the filter: of a kilohertz of a robot with few joints, more than
a minute."""

TOGETHER = 0.02
"""s: what comes in that time is taken at once. The rate is smoothed over a second of
samples, for twenty at once nearly as fast as for one."""

DROPS = 40
"""Linux's SO_RXQ_OVFL, which Python does not name: each datagram then comes with the
number of those that the system had no room for, in four bytes."""


def lines_of_input(given: TextIO | None) -> Iterator[list[bytes]]:
    """Whole lines as they come; of what comes faster than it is taken, many at once.

    Args:
        given: an open file or pipe; None where standard input was closed before the
            command started.
    """
    if given is None:
        return
    handle, rest = given.fileno(), b""
    while block := os.read(handle, BLOCK):
        *lines, rest = (rest + block).split(b"\n")
        rest = rest[:LONGEST]
        if lines:
            yield lines
    if rest:
        yield [rest]


class Datagrams:
    """Lines of UDP datagrams.

    A thread of its own takes them from the system, so that a pause of the filter, or of
    the disk that its state is written to, loses none.
    """

    def __init__(self, host: str, port: int) -> None:
        """Listen.

        Raises:
            InputError: the host is no address of this machine, or the port is taken.
        """
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, KERNEL)
        if sys.platform == "linux":
            self._socket.setsockopt(socket.SOL_SOCKET, DROPS, 1)
        try:
            self._socket.bind((host, port))
        except (OSError, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"--udp: port {port} at '{host}' cannot be used ({reason}); give a "
                "free port, and with --host an address of this machine"
            ) from None
        self._waiting = bytearray()
        self._lock = threading.Lock()
        self._unseen = self._left_out = 0
        threading.Thread(target=self._receive, daemon=True).start()

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return int(self._socket.getsockname()[1])

    @property
    def lost(self) -> int:
        """Datagrams for which there was no room, here or in the system.

        The system tells only with the next datagram, and only Linux does.
        """
        return self._unseen + self._left_out

    @property
    def waiting(self) -> int:
        """Lines that have come and were not taken."""
        with self._lock:
            return sum(bool(line.strip()) for line in self._waiting.split(b"\n"))

    def lines(self) -> Iterator[list[bytes]]:
        """Lines as they come, without an end."""
        while True:
            time.sleep(TOGETHER)
            with self._lock:
                end = self._waiting.rfind(b"\n", 0, ATONCE) + 1
                block = bytes(self._waiting[:end])
                del self._waiting[:end]
            if block:
                yield block.split(b"\n")

    def _receive(self) -> None:
        while True:
            datagram, told, _, _ = self._socket.recvmsg(BLOCK, socket.CMSG_SPACE(4))
            for _, _, number in told:
                self._unseen = int.from_bytes(number, sys.byteorder)
            with self._lock:
                if len(self._waiting) + len(datagram) < WAITING:
                    self._waiting += datagram + b"\n"
                else:
                    self._left_out += 1
