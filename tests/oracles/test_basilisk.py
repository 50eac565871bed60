"""The example with Basilisk: its own dynamics, wheels and manipulator, and a capture.

pip install bsk
"""

import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "basilisk"


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("Basilisk", reason="Basilisk (pip install bsk) is missing")
    monkeypatch.setattr(sys, "path", [str(EXAMPLE), *sys.path])
    import capture  # pyright: ignore[reportMissingImports]

    return capture


# What Basilisk's own modules warn of is not ours.
@pytest.mark.filterwarnings("ignore")
def test_a_capture_is_found_and_weighed(example):
    found = example.run()
    (change,) = found.changes
    assert 0 < change - example.CAPTURE < 5
    for true, value, std in found.masses.values():
        assert abs(value - true) < 3 * std
        assert std < 1
