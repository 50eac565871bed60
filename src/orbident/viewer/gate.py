"""Who may talk to the viewer: pages of its own address, and nobody without the token.

A browser lets every page that is open in it send requests to this machine. It says in
`Origin` which page asks, and in `Host` by which name it was led here; a page cannot
change either.
"""

import asyncio
import ipaddress
import logging
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "[::1]"})
TOKEN_BYTES = 16
"""128 random bits cannot be guessed."""
HTTP_PORT = 80
"""The port that a browser leaves out of `Host` and `Origin`."""

REFUSED = (
    "Refused: this viewer answers only pages of its own address. Open the address that "
    "orbident has printed, with its port and token.\n"
)

SILENT = logging.getLogger("orbident.viewer")
"""What a stranger sends is no error of the user: nothing is written about it."""
SILENT.disabled = True


@dataclass(frozen=True)
class Gate:
    """Decides which requests reach the viewer."""

    names: frozenset[str]
    """Names by which `Host` may call the viewer; empty where any name is good."""
    token: str
    """Must begin the path; empty where only this machine can connect."""

    @classmethod
    def at(cls, host: str, bound: str) -> "Gate":
        """The gate of a viewer that listens there.

        Args:
            host: as the user gave it.
            bound: the numeric address that it means.
        """
        address = ipaddress.ip_address(bound)
        if address.is_unspecified:
            # Any name of this machine leads here, and no list of them is complete. A
            # foreign page that is led here under its own name still lacks the token.
            names = frozenset()
        else:
            names = frozenset({in_address(host).lower(), in_address(bound)})
        if address.is_loopback:
            return cls(names | LOOPBACK_NAMES, "")
        return cls(names, secrets.token_urlsafe(TOKEN_BYTES))

    @property
    def is_open(self) -> bool:
        """Whether other machines can connect."""
        return bool(self.token)

    @property
    def path(self) -> str:
        """The path of the page."""
        return f"/{self.token}/" if self.token else "/"

    def admits(
        self, port: int, hosts: Sequence[str], origins: Sequence[str], plain: bool
    ) -> bool:
        """Whether a request comes from a page of this viewer, or leads to one.

        `Host` must be one of the names with the port. `Origin` must be the same
        address; only a plain request for the page may come without it.

        Args:
            port: at which the request arrived.
            hosts: every `Host` header of it.
            origins: every `Origin` header of it.
            plain: whether it asks for a page, not for a websocket.
        """
        if len(hosts) != 1 or not self._is_called(hosts[0].lower(), port):
            return False
        if plain and not origins:
            return True
        return [each.lower() for each in origins] == [f"http://{hosts[0].lower()}"]

    def _is_called(self, host: str, port: int) -> bool:
        name, colon, given = host.rpartition(":")
        if not colon or host.endswith("]"):
            name, given = host, str(HTTP_PORT)
        return given == str(port) and (not self.names or name in self.names)

    def without_token(self, path: str) -> str | None:
        """The path behind the token; None where the token is not the right one."""
        if not self.token:
            return path
        prefix = f"/{self.token}"
        start, rest = path[: len(prefix)], path[len(prefix) :]
        same = secrets.compare_digest(
            start.encode(errors="surrogateescape"), prefix.encode()
        )
        if not same or (rest and rest[0] not in "/?"):
            return None
        return rest if rest.startswith("/") else f"/{rest}"


def in_address(host: str) -> str:
    """A host as it stands in an address: IPv6 in brackets."""
    return f"[{host}]" if ":" in host else host


class Gated:
    """Whether a server was made while the gate stood in its way."""

    served = False


@contextmanager
def gated(gate: Gate) -> Iterator[Gated]:
    """Put the gate before every websockets server that is made meanwhile.

    viser has no argument for it, but makes its server by
    `websockets.asyncio.server.serve`, of which `process_request` and `logger` are
    documented arguments. The caller must check `served`.
    """
    # Late: websockets comes with the extra `view`.
    from unittest.mock import patch

    import websockets.asyncio.server as servers

    plain, done = servers.serve, Gated()

    def serve(*arguments: Any, process_request: Any, **options: Any) -> Any:
        done.served = True
        # What a client sends is handled in tasks of this loop.
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: None)
        checked = _checked(gate, process_request)
        return plain(*arguments, process_request=checked, logger=SILENT, **options)

    with patch.object(servers, "serve", serve):
        yield done


def _checked(gate: Gate, answer: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """The same answers, to those only whom the gate admits."""

    def checked(connection: Any, request: Any) -> Any:
        path = gate.without_token(request.path)
        headers = request.headers
        admitted = gate.admits(
            connection.local_address[1],
            headers.get_all("Host"),
            headers.get_all("Origin"),
            plain=not headers.get_all("Upgrade"),
        )
        if path is None or not admitted:
            return connection.respond(403, REFUSED)
        response = answer(connection, replace(request, path=path))
        if response is not None:
            for name, value in restrictions(headers["Host"]).items():
                response.headers[name] = value
        return response

    return checked


def restrictions(host: str) -> dict[str, str]:
    """Headers that keep the page from being used by another one.

    No page may hold it in a frame, where a click could be led onto it. It may connect
    to nothing but this server: viser's page takes a server's address from its own
    (`?websocket=`), and a server can run programs in the page.
    """
    sources = f"'self' ws://{host} data: blob:"
    return {
        "Content-Security-Policy": f"connect-src {sources}; frame-ancestors 'none'",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Frame-Options": "DENY",
    }
