"""A server on a free port, and pages on it."""

from collections.abc import Iterator
from typing import Any

import pytest

from orbident.viewer.server import Served, close, open_server


@pytest.fixture
def served() -> Iterator[Served]:
    opened = open_server("127.0.0.1", 0)
    yield opened
    close(opened.server)


@pytest.fixture
def server(served: Served) -> Any:
    return served.server
