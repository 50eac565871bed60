"""Times that go back: what is put right, what is refused, what only came late."""

from pathlib import Path

import numpy as np
import pytest
from conversions import HEAD

from orbident.errors import InputError
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import convert_file

T = 0.05 * np.arange(400)
V = np.arange(400.0)


def converted(folder: Path, times, unit: str = "s", values=V):
    entry = f"  - {{topic: /, type: table, stamp: {{time: {unit}}}, "
    entry += "take: {joint.a.position: rad}, fields: {joint.a.position: q}}\n"
    (folder / "map.yaml").write_text(HEAD + entry)
    rows = [f"{float(t)!r},{float(q)!r}" for t, q in zip(times, values, strict=True)]
    (folder / "log.csv").write_text("\n".join(["time,q", *rows]))
    report = convert_file(folder / "log.csv", folder / "map.yaml", folder / "r.csv")
    return read_recording(folder / "r.csv"), report


WRAPS = {
    "us": (2**32, 1e6, "us"),
    "ms": (2**32, 1e3, "ms"),
    "16 bits": (2**16, 1e3, "ms"),
    "us in seconds": (2**32 / 1e6, 1, "s"),
    "counts of 0.2 s": (2**16, 5, "0.2 s"),
    "time of day": (86400, 1, "s"),
}


@pytest.mark.parametrize("lost", [0, 1])
@pytest.mark.parametrize("case", WRAPS)
def test_counters_that_begin_again(tmp_path: Path, case: str, lost: int):
    end, rate, unit = WRAPS[case]
    t = T * (4 if "0.2" in case else 1)
    counts = (end - 10 * rate + np.round(t * rate, 6)) % end
    keep = np.ones(400, dtype=bool)
    keep[200 - lost : 200 + lost] = False
    recording, report = converted(tmp_path, counts[keep], unit, V[keep])
    np.testing.assert_allclose(recording.t, t[keep], atol=1e-6)
    np.testing.assert_array_equal(recording.column("joint.a.position"), V[keep])
    (said,) = report.topics[0].sentences()
    assert said.startswith("/: its time begins again after ")


STEPS = {
    "restarted": np.r_[100 + T[:200], T[:200]],
    "restarted into what was": np.r_[T[:200], T[:200]],
    "set back by 2 s": np.r_[T[:200], T[200:] - 2],
}


@pytest.mark.parametrize("case", STEPS)
def test_clocks_that_are_set(tmp_path: Path, case: str):
    with pytest.raises(
        InputError, match=r"the time goes back by .* at sample 201, 9.95 s"
    ):
        converted(tmp_path, STEPS[case])


def test_what_only_came_late(tmp_path: Path):
    """A burst that fills its gap or comes twice, a shuffle, parts in another order."""
    burst = np.r_[0:100, 130:160, 100:130, 160:400]
    again = np.r_[0:100, 60:100, 100:400]
    shuffled = np.random.default_rng(4).permutation(400)
    swapped = np.r_[200:400, 0:200]
    backwards = np.arange(400)[::-1]
    for order in (burst, again, shuffled, swapped, backwards):
        recording, report = converted(tmp_path, T[order], "s", V[order])
        np.testing.assert_array_equal(recording.column("joint.a.position"), V)
        assert report.topics[0].rejected["duplicate"] == order.size - 400
        assert report.topics[0].out_of_order
