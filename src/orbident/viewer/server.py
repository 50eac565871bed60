"""The server behind the page; viser's one import."""

import errno
import os
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple, Protocol, runtime_checkable

from orbident.errors import InputError
from orbident.extras import extra
from orbident.viewer.gate import Gate, gated, in_address

PERIOD = 1 / 30
"""Time from one picture to the next, s."""


@runtime_checkable
class Page(Protocol):
    """What is shown, and moves by itself."""

    def advance(self, seconds: float) -> None:
        """Let so much time pass."""
        ...


class Served(NamedTuple):
    """An empty page in the browser."""

    server: Any
    """viser's."""
    url: str
    """Where to point the browser; holds the token where there is one."""
    is_open: bool
    """Whether other machines can connect."""


def open_server(host: str, port: int) -> Served:
    """Serve an empty page to those whom the gate admits.

    Args:
        host: address of this machine to listen at.
        port: of it; 0 for any that is free.

    Raises:
        InputError: viser is not installed, the host is no address of this machine, or
            the port is taken or not allowed.
    """
    with extra("view", "the viewer"):
        import viser

    bound = _free(host, port)
    gate = Gate.at(host, bound)
    with _silent(), gated(gate) as gating:
        server = viser.ViserServer(bound, port, verbose=False)
    if not gating.served:
        close(server)
        raise RuntimeError(f"viser {viser.__version__} serves past the gate")
    # What casts shadows takes most of the time where there is no graphics card.
    server.scene.configure_default_lights(cast_shadow=False)
    # What the share button makes is a public address elsewhere.
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return Served(server, _address(host, server.get_port(), gate), gate.is_open)


def _address(host: str, port: int, gate: Gate) -> str:
    name = host if gate.names else socket.gethostname()
    return f"http://{in_address(name)}:{port}{gate.path}"


def keep_moving(page: Page) -> None:
    """Let the page move until the process is interrupted."""
    before = time.monotonic()
    with _silent():
        while True:
            time.sleep(PERIOD)
            now = time.monotonic()
            page.advance(now - before)
            before = now


def close(server: Any) -> None:
    """Stop serving."""
    with _silent():
        server.stop()


@contextmanager
def _silent() -> Iterator[None]:
    """Standard output is for results, and viser writes there too."""
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
        yield


def _free(host: str, port: int) -> str:
    """The numeric address that the host means, once it is known that it can be used."""
    # viser would silently take the next port, and any failure for a taken one.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
            return probe.getsockname()[0]
        except (socket.gaierror, UnicodeError):
            raise InputError(
                f"--host: found '{host}'; give an address of this machine, such as "
                "127.0.0.1, or 0.0.0.0 for all of them"
            ) from None
        except OSError as error:
            raise InputError(_refused(host, port, error)) from None


def _refused(host: str, port: int, error: OSError) -> str:
    reason = error.strerror or str(error)
    if error.errno == errno.EADDRNOTAVAIL:
        return (
            f"--host: '{host}' is no address of this machine; give 127.0.0.1, or "
            "0.0.0.0 for all of them"
        )
    remedy = "give another, or 0 for any that is free"
    return f"--port: {port} at {host} cannot be used ({reason}); {remedy}"
