"""State files: whole, cut, changed, forged, and of no kind at all."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
from live_streams import VELOCITY_STD, csv_lines, robot, samples

from orbident.errors import InputError
from orbident.live.live_filter import LiveFilter
from orbident.live.session import nothing_carried, read_state, save_state
from orbident.live.sources import Lines


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    filter_ = LiveFilter(robot(), VELOCITY_STD, 1.0, nothing_carried(robot()))
    filter_.take(Lines(robot(), "stream").take(csv_lines(samples())[:100])[0])
    path = tmp_path_factory.mktemp("state") / "state"
    save_state(path, filter_.carried)
    return path.read_bytes()


def forged(written: bytes, **changes: object) -> bytes:
    """With another head, and a checksum that is right."""
    _, line, body = written.split(b"\n", 2)
    head = json.dumps(json.loads(line) | changes).encode()
    return sealed(head + b"\n" + body)


def sealed(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode() + b"\n" + content


def refused(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"(is damaged|another robot)[^\n]*begin anew"):
        read_state(path, robot(), VELOCITY_STD)


def test_a_changed_byte_is_found(tmp_path: Path, written: bytes):
    for place in np.linspace(0, len(written) - 1, 40).astype(int):
        content = bytearray(written)
        content[place] ^= 1
        refused(tmp_path / "state", bytes(content))


def test_other_files(tmp_path: Path, written: bytes):
    lines = written.split(b"\n", 2)
    for content in (
        b"",
        b"\n\n",
        b"5",
        written[:-8],
        written + b"\0",
        b"\n".join([lines[0], b"[" * 4000, lines[2]]),
        b"PK\x03\x04" + written,
        written.replace(b"\n", b""),
    ):
        refused(tmp_path / "state", content)
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(InputError, match="is damaged"):
        read_state(folder, robot(), VELOCITY_STD)


@pytest.mark.parametrize(
    "changes",
    [
        {"dt": 1e-12},
        {"dt": float("nan")},
        {"dt": "1"},
        {"dt": None},
        {"mark": 5},
        {"mark": "0"},
        {"counts": {"counted": -1}},
        {"counts": {"counted": 0.5}},
        {"counts": []},
        {"rows": [10**9, 12]},
        {"rows": [-1, 12]},
        {"rows": []},
        {"rows": [12, 12, 0]},
        {"kind": "orbident live state 2"},
        {"more": 1},
    ],
)
def test_a_forged_head(tmp_path: Path, written: bytes, changes: dict):
    refused(tmp_path / "state", forged(written, **changes))


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_forged_numbers(tmp_path: Path, written: bytes, value: float):
    _, line, body = written.split(b"\n", 2)
    numbers = np.full(len(body) // 8, value).tobytes()
    refused(tmp_path / "state", sealed(line + b"\n" + numbers))


def test_as_it_was_written(tmp_path: Path, written: bytes):
    path = tmp_path / "state"
    for content in (written, forged(written)):
        path.write_bytes(content)
        save_state(path, read_state(path, robot(), VELOCITY_STD))
        assert path.read_bytes() == written
