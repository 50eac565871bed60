"""The how-to page on bags: its commands are run, its output is compared."""

import re
from pathlib import Path

import numpy as np
import pytest
from bag_writers import START, Sent, joint_state, pose, write_bag
from running import Orbident

from orbident.recordings.columns import is_known
from orbident.recordings.tables import read_recording

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "ros-bag.md"
MS = 1_000_000


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)


def table_flight() -> list[Sent]:
    """20 s on a table: encoders at 100 Hz, motion capture at 50 Hz."""
    sent = []
    for k in range(2000):
        stamp = START + 10 * MS * k
        q = [0.3 * np.sin(k / 200), 0.2 * np.cos(k / 300), -1.7 * k]
        q_dot = [0.1, 0.2, -170.0]
        names = ["shoulder", "elbow", "wheel_motor"]
        received = stamp + 2 * MS
        sent.append(joint_state("/joint_states", received, stamp, names, q, q_dot))
        if k % 2 == 0:
            angle = k / 2000
            x = [0, 0, np.sin(angle / 2), np.cos(angle / 2)]
            p = [1000 + k / 10, 500, 0] if not 600 <= k < 640 else [np.nan] * 3
            at = stamp + 3 * MS
            sent.append(pose("/mocap/cepheus/pose", received + 9 * MS, at, x, p))
            if k in {100, 102}:
                sent.append(sent[-1]._replace(received=received + 90 * MS))
    return sorted(sent, key=lambda each: each.received)


@pytest.fixture
def bag() -> Path:
    return write_bag("ros1", Path(), table_flight(), "table")


def test_the_page(orbident: Orbident, bag: Path):
    assert bag == Path("table.bag")
    install, topics, convert, identify = (
        line for text in blocks("sh") for line in [text.strip()]
    )
    assert install == 'pip install "orbident[ros]"'
    # These messages are of no flight; tests/statistics identifies from one's.
    assert identify.startswith("orbident identify table.yaml flight.parquet")
    verb, *arguments = topics.split()
    assert verb == "orbident"
    printed = orbident(*arguments).done().out
    listing, report = blocks("text")
    assert printed == listing
    # What is proposed asks for the frames, as the page says.
    verb, *arguments = convert.split()
    refused = orbident(*arguments).refused("map.yaml: topics[1] (/mocap/cepheus/pose)")
    assert "pose: this key is missing" in refused
    (finished,) = blocks("yaml")
    Path("map.yaml").write_text(finished)
    assert orbident(*arguments).done().out == report
    recording = read_recording("flight.parquet")
    assert all(is_known(name) for name in recording.columns)
    position = recording.column("position.x")
    # Millimetres in the messages; the first is 1 m.
    assert position[np.isfinite(position)][0] == pytest.approx(1.0, abs=1e-15)
