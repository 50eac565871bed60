"""What was measured and predicted, kept: residuals lose nothing that shows."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from orbident.errors import InputError
from orbident.estimation.signals import Signal
from orbident.identified.run_folder import read_signals, write_signals

RANDOM = np.random.default_rng(5)


def _signal(name: str, n: int, axes: str) -> Signal:
    predicted = 100 + RANDOM.standard_normal((n, len(axes)))
    error = 1e-7 * RANDOM.standard_normal(predicted.shape)
    units = ("m",) * len(axes)
    t = np.cumsum(RANDOM.exponential(size=n))
    return Signal(name, tuple(axes), units, t, predicted + error, predicted, 1e-7)


def test_read_back(tmp_path):
    path = tmp_path / "signals.parquet"
    signals = _signal("position", 1000, "xyz"), _signal("<b>'é", 5, "x")
    write_signals(signals, path)
    for kept, made in zip(read_signals(path), signals, strict=True):
        assert kept._replace(t=0, measured=0, predicted=0) == made._replace(
            t=0, measured=0, predicted=0
        )
        assert (kept.t == made.t).all()
        # float32: 24 bits of each.
        np.testing.assert_allclose(kept.measured, made.measured, rtol=1e-7)
        error = kept.measured - kept.predicted
        # 1e-14 is the rounding of 100 in float64.
        np.testing.assert_allclose(
            error, made.measured - made.predicted, rtol=1e-6, atol=5e-14
        )


def test_none(tmp_path):
    write_signals((), tmp_path / "empty")
    assert read_signals(tmp_path / "empty") == ()


def test_size_of_100_000_samples(tmp_path):
    path = tmp_path / "signals.parquet"
    write_signals(tuple(_signal(name, 100_000, "xyz") for name in "abcdef"), path)
    # The aim; here not even times repeat.
    assert path.stat().st_size < 20e6


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("name", None),
        ("axes", ["x", "y"]),
        ("axes", ["x", "y", None]),
        ("units", None),
        ("units", ["m"]),
        ("t", [0.0, 1.0, float("nan"), 3.0]),
        ("measured", [1.0] * 11),
        ("error", [None] * 12),
        ("std", None),
    ],
)
def test_altered(tmp_path, column: str, value: object):
    """Whoever alters it can make its checksum anew."""
    path = tmp_path / "signals.parquet"
    write_signals((_signal("position", 4, "xyz"),), path)
    table = parquet.read_table(path)
    at = table.schema.get_field_index(column)
    altered = pa.array([value], table.schema.types[at])
    parquet.write_table(table.set_column(at, table.schema.field(at), altered), path)
    with pytest.raises(InputError, match="is not what 'orbident identify' wrote"):
        read_signals(path)


def test_damaged(tmp_path):
    path = tmp_path / "signals.parquet"
    path.write_bytes(b"nothing")
    with pytest.raises(InputError, match="identify again"):
        read_signals(path)
