"""Pieces that are read again are those that were worked out."""

import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from orbident.preprocessing.stretches import KeptPieces, Piece


class Worked:
    """Three pieces, one of them empty, and how often they were worked out."""

    def __init__(self) -> None:
        random = np.random.default_rng(0)
        self.times = 0
        self.pieces = [
            Piece(random.random(n), random.random((n, 5))) for n in (7, 0, 40)
        ]

    def __call__(self) -> Iterator[Piece]:
        self.times += 1
        yield from self.pieces


def assert_same(found: Iterator[Piece], worked: Worked) -> None:
    for piece, wanted in zip(found, worked.pieces, strict=True):
        np.testing.assert_array_equal(piece.t, wanted.t)
        np.testing.assert_array_equal(piece.samples, wanted.samples)


def kept_by(worked: Worked) -> KeptPieces:
    kept = KeptPieces(worked)
    for piece in worked.pieces:
        kept.keep(piece)
    return kept


def test_they_are_not_worked_out_again():
    worked = Worked()
    kept = kept_by(worked)
    for _ in range(3):
        assert_same(kept(), worked)
    assert worked.times == 0


@pytest.mark.parametrize("place", ["/dev/full", "/nowhere/at/all"])
def test_without_room_they_are_worked_out_again(
    monkeypatch: pytest.MonkeyPatch, place: str
):
    monkeypatch.setattr(tempfile, "TemporaryFile", partial(Path(place).open, "wb"))
    worked = Worked()
    kept = kept_by(worked)
    for _ in range(2):
        assert_same(kept(), worked)
    assert worked.times == 2
