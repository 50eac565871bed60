"""Parquet files with columns of any names."""

import os
from contextlib import ExitStack
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as parquet

from orbident.recordings.logs.arrow_columns import fields_of
from orbident.recordings.logs.group import Tree


def read_parquet_log(path: Path, stack: ExitStack) -> Tree:
    """Columns by name."""
    del stack
    with pa.OSFile(os.fsencode(path)) as file:
        table = parquet.read_table(file)
    names = table.column_names
    return fields_of(table.columns, names, [""] * len(names), str(path))
