"""Datagrams while nobody takes them."""

import itertools
import socket
import sys
import time

import pytest

from orbident.live import sources
from orbident.live.sources import KERNEL, Datagrams

LAST = b"last"


def sent(receiver: Datagrams, datagrams: list[bytes], pause: float = 0.001) -> None:
    """Send them with pauses, in which the receiving thread runs."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", receiver.port))
        for datagram in datagrams:
            sender.send(datagram)
            time.sleep(pause)


def taken(receiver: Datagrams) -> list[bytes]:
    """All lines that are not empty, before the last one."""
    lines = itertools.chain.from_iterable(receiver.lines())
    return [line for line in itertools.takewhile(lambda x: x != LAST, lines) if line]


def test_a_pause_loses_none():
    """While nobody takes them, more come than the system would keep."""
    receiver = Datagrams("127.0.0.1", 0)
    datagrams = [f"{k:09} ".encode() * 1000 for k in range(2000)]
    # Linux doubles what it is asked for, since it counts what it adds to a datagram.
    assert sum(map(len, datagrams)) > 2 * KERNEL
    sent(receiver, [*datagrams, LAST])
    assert taken(receiver) == datagrams
    assert receiver.lost == 0


def test_what_nobody_took_is_counted():
    receiver = Datagrams("127.0.0.1", 0)
    sent(receiver, [b"1\n2", b"", b"3\n", LAST])
    while receiver.waiting < 4:
        time.sleep(0.01)
    assert taken(receiver) == [b"1", b"2", b"3"]
    assert receiver.waiting == 0


def test_what_there_is_no_room_for_is_counted(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sources, "WAITING", 1000)
    receiver = Datagrams("127.0.0.1", 0)
    sent(receiver, 5 * [b"x" * 299])
    while receiver.lost < 2:
        time.sleep(0.01)
    assert next(receiver.lines())[:-1] == 3 * [b"x" * 299]
    sent(receiver, [b"1\n2", LAST])
    assert taken(receiver) == [b"1", b"2"]
    assert receiver.lost == 2


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux counts what it drops")
def test_what_the_system_drops_is_counted(monkeypatch: pytest.MonkeyPatch):
    """How many that are is not for us to say: at times none."""
    monkeypatch.setattr(sources, "KERNEL", 1)
    receiver = Datagrams("127.0.0.1", 0)
    sent(receiver, 5000 * [b"x" * 300], pause=0)
    sent(receiver, [LAST], pause=0)
    assert len(taken(receiver)) + receiver.lost == 5000
