"""Measured and predicted signals of a RUN, in one compact file: a row a signal."""

import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.estimation.signals import Signal, Signals
from orbident.files.bounds import LARGEST
from orbident.files.names import quoted

SCHEMA = pa.schema(
    [
        ("name", pa.string()),
        ("axes", pa.list_(pa.string())),
        ("units", pa.list_(pa.string())),
        ("t", pa.list_(pa.float64())),
        ("measured", pa.list_(pa.float32())),
        # Less predicted: beside large values float32 would lose it.
        ("error", pa.list_(pa.float32())),
        ("std", pa.float64()),
    ]
)


def write_signals(signals: Signals, path: Path) -> None:
    """Write them; an existing file is replaced."""
    rows = [
        {
            **signal._asdict(),
            "measured": signal.measured.astype(np.float32).ravel(),
            "error": (signal.measured - signal.predicted).astype(np.float32).ravel(),
        }
        for signal in signals
    ]
    table = pa.table(
        [pa.array([row[field.name] for row in rows], field.type) for field in SCHEMA],
        schema=SCHEMA,
    )
    # Bytes: as text Arrow takes no name that is not UTF-8.
    with pa.OSFile(os.fsencode(path), "wb") as file:
        parquet.write_table(
            table,
            file,
            compression="zstd",
            use_dictionary=False,
            # Neighbours share their upper bytes.
            use_byte_stream_split=[  # pyright: ignore[reportArgumentType]: stubs know bool
                f"{column}.list.element" for column in ("t", "measured", "error")
            ],
        )


def read_signals(path: Path) -> Signals:
    """Read them.

    Raises:
        InputError: it is not what `write_signals` writes.
    """
    try:
        with pa.OSFile(os.fsencode(path)) as file:
            table = parquet.read_table(file, schema=SCHEMA)
        return tuple(_signal(table, k) for k in range(table.num_rows))
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"{path}: is not what 'orbident identify' wrote ({reason}); identify again"
        ) from error


def _signal(table: pa.Table, k: int) -> Signal:
    """The signal of a row.

    Raises:
        ValueError: its lists do not fit together.
    """
    name, axes, units, std = (
        table[column][k].as_py() for column in ("name", "axes", "units", "std")
    )
    lists = [table[column][k].values for column in ("t", "measured", "error")]
    if None in {name, std, *(axes or [None]), *(units or [None])} or any(
        each is None or each.null_count for each in lists
    ):
        raise ValueError("a value is missing")
    t, measured, error = (np.asarray(each).astype(np.float64) for each in lists)
    sizes = {measured.size, error.size, t.size * len(axes), t.size * len(units)}
    if len(sizes) > 1 or not np.all(np.abs(t) <= LARGEST):
        raise ValueError(f"the times, axes and values of {quoted(name)} do not fit")
    measured, error = (x.reshape(t.size, len(axes)) for x in (measured, error))
    return Signal(name, tuple(axes), tuple(units), t, measured, measured - error, std)
