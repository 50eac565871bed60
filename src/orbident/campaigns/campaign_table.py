"""The table of a campaign: a row for each run and method, a Parquet file a chunk."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet

from orbident.campaigns.folder import ROWS, Campaign
from orbident.errors import InputError
from orbident.estimation.checks import LEVELS
from orbident.files.replacing import replacing
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets

Row = dict[str, Any]

_ANEW = "remove it and run the campaign again, which computes it anew"

WORDS = ("robot", "method", "level", "refused_by")


def path_of(folder: Path, chunk: range) -> Path:
    """Where a chunk's rows go."""
    return folder / ROWS / f"{chunk.start:08}.parquet"


def schema_of(campaign: Campaign) -> pa.Schema:
    """The columns, the same in every chunk.

    `run`, `robot`, `method`, `level` as `identify` gives it, the check that refuses;
    `draw.*` as they were drawn; and of every base parameter `.value`, `.std` and
    `.true`. What there is not is null.
    """
    firsts = range(len(campaign.subjects))
    draws = dict.fromkeys(name for k in firsts for name in campaign.case(k).draws)
    parameters = dict.fromkeys(
        name
        for subject in campaign.subjects
        for name in formulas_of(subject.robot, minimal_sets(subject.robot)).base.names
    )
    return pa.schema(
        [
            ("run", pa.int64()),
            *((name, pa.string()) for name in WORDS),
            *((f"draw.{name}", pa.float64()) for name in draws),
            *(
                (f"{name}.{what}", pa.float64())
                for name in parameters
                for what in ("value", "std", "true")
            ),
        ]
    )


def arrow_table(rows: Sequence[Row], schema: pa.Schema) -> pa.Table:
    """Rows with these columns; NaN is null."""
    columns = [
        pa.array([row.get(field.name) for row in rows], field.type, from_pandas=True)
        for field in schema
    ]
    return pa.Table.from_arrays(columns, schema=schema)


def write_rows(path: Path, rows: Sequence[Row], schema: pa.Schema) -> None:
    """Write a chunk whole or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    table = arrow_table(rows, schema)
    with replacing(path) as temporary, pa.OSFile(os.fsencode(temporary), "wb") as sink:
        parquet.write_table(table, sink, compression="zstd", use_dictionary=False)


def read_rows(
    campaign: Campaign, folder: Path, columns: Sequence[str] | None = None
) -> pa.Table:
    """The rows of all chunks that are done, in the order of runs.

    Args:
        campaign: of the folder.
        folder: of the campaign.
        columns: those that are wanted; all by default.

    Raises:
        InputError: a file is damaged.
    """
    schema = schema_of(campaign)
    tables = [
        read_chunk(campaign, folder, chunk, schema, columns)
        for chunk in campaign.spec.chunks
        if path_of(folder, chunk).exists()
    ]
    empty = schema.empty_table().select(columns or schema.names)
    return pa.concat_tables([empty, *tables]).combine_chunks()


def read_chunk(
    campaign: Campaign,
    folder: Path,
    chunk: range,
    schema: pa.Schema,
    columns: Sequence[str] | None = None,
) -> pa.Table:
    """The rows of one chunk.

    Raises:
        InputError: the file is damaged, or was not written by this campaign.
    """
    path = path_of(folder, chunk)
    try:
        with pa.OSFile(os.fsencode(path)) as source:
            # A chunk is small: threads would take longer to start than to read it.
            file = parquet.ParquetFile(source)
            found = file.schema_arrow
            table = file.read(columns, use_threads=False)
    except (pa.ArrowException, ValueError, OSError) as error:
        # A name that is no UTF-8 is a ValueError.
        reason = " ".join(str(error).split())[:80]
        raise InputError(f"{path}: cannot be read ({reason}); {_ANEW}") from error
    if found != schema:
        raise InputError(
            f"{path}: has other columns than this campaign, or other types in them; "
            f"{_ANEW}"
        )
    known = {
        "run": chunk,
        "robot": [subject.robot.name for subject in campaign.subjects],
        "method": campaign.spec.methods,
        "level": LEVELS,
    }
    for name in known.keys() & set(table.column_names):
        if not set(table[name].unique().to_pylist()) <= set(known[name]):
            raise InputError(
                f"{path}: column '{name}' has values that are not of this campaign; "
                f"{_ANEW}"
            )
    return table


def column(table: pa.Table, name: str) -> np.ndarray:
    """A column of numbers; null is NaN."""
    return table[name].to_numpy().astype(float)
