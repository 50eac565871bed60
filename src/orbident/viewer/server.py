"""The server behind the page; viser's one import."""

import errno
import io
import socket
import sys
import time
from contextlib import AbstractContextManager, redirect_stdout
from typing import Any, Protocol, runtime_checkable

from orbident.errors import InputError

PERIOD = 1 / 30
"""From one picture to the next, s."""


@runtime_checkable
class Page(Protocol):
    """What is shown, and moves by itself."""

    def advance(self, seconds: float) -> None:
        """Let so much time pass."""
        ...


def open_server(host: str, port: int) -> Any:
    """A viser server with an empty page.

    Args:
        host: address of this machine to listen at.
        port: of it; 0 for any that is free.

    Raises:
        InputError: viser is not installed, the host is no address of this machine, or
            the port is taken or not allowed.
    """
    viser = _viser()
    _check_free(host, port)
    with _silent():
        server = viser.ViserServer(host, port, verbose=False)
    # What casts shadows takes most of the time where there is no graphics card.
    server.scene.configure_default_lights(cast_shadow=False)
    # What the share button makes is a public address elsewhere.
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return server


def address(server: Any, host: str) -> str:
    """Where to point the browser."""
    if host in {"0.0.0.0", "::"}:
        host = socket.gethostname()
    shown = f"[{host}]" if ":" in host else host
    return f"http://{shown}:{server.get_port()}"


def run(page: Page) -> None:
    """Let the page move until the process is interrupted."""
    before = time.monotonic()
    while True:
        time.sleep(PERIOD)
        now = time.monotonic()
        page.advance(now - before)
        before = now


def close(server: Any) -> None:
    """Stop serving."""
    with _silent():
        server.stop()


def _silent() -> AbstractContextManager[Any]:
    """Standard output is for results, and viser writes there too."""
    return redirect_stdout(io.StringIO())


def _viser() -> Any:
    try:
        import viser
    except ModuleNotFoundError as error:
        raise InputError(
            f"viewing needs `pip install orbident[view]` ({error.name} is missing)"
        ) from error
    return viser


def _check_free(host: str, port: int) -> None:
    # viser would silently take the next port, and any failure for a taken one.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
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
