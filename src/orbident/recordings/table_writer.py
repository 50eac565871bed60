"""Tables written block by block: memory holds one block, however long the table."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

from orbident.files.replacing import replacing


def write_blocks(
    path: Path, names: Sequence[str], blocks: Iterable[np.ndarray]
) -> None:
    """Writes a table as .csv or .parquet, whole or not at all; NaN is an empty cell.

    Args:
        path: the suffix says how.
        names: of the columns.
        blocks: `(rows, columns)` each, in order.

    Raises:
        InputError: a folder that does not exist, or no permission.
    """
    schema = pa.schema([(name, pa.float64()) for name in names])
    batches = (_batch(block, schema) for block in blocks)
    with replacing(path) as temporary:
        if path.suffix.lower() == ".csv":
            _write_csv(batches, schema, temporary)
        else:
            _write_parquet(batches, schema, temporary)


def _batch(block: np.ndarray, schema: pa.Schema) -> pa.RecordBatch:
    columns = [pa.array(column, from_pandas=True) for column in block.T]
    return pa.RecordBatch.from_arrays(columns, schema=schema)


def _write_csv(
    batches: Iterable[pa.RecordBatch], schema: pa.Schema, path: Path
) -> None:
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow(schema.names)
    # Arrow prints the shortest decimal that reads back as the same float64.
    options = arrow_csv.WriteOptions(include_header=False)
    with pa.OSFile(str(path), "wb") as sink:
        sink.write(header.getvalue().encode())
        with arrow_csv.CSVWriter(sink, schema, write_options=options) as writer:
            for batch in batches:
                writer.write_batch(batch)


def _write_parquet(
    batches: Iterable[pa.RecordBatch], schema: pa.Schema, path: Path
) -> None:
    # Measured values hardly repeat: a dictionary would cost time and memory only.
    with parquet.ParquetWriter(
        str(path), schema, compression="zstd", use_dictionary=False
    ) as writer:
        for batch in batches:
            writer.write_batch(batch)
