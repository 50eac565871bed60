"""A server on a free port, and pages on it."""

from collections.abc import Iterator
from typing import Any

import pytest

from orbident.viewer.server import close, open_server


@pytest.fixture
def server() -> Iterator[Any]:
    opened = open_server("127.0.0.1", 0)
    yield opened
    close(opened)
