"""Making all runs of a campaign that are not made yet.

Workers compute; only this process writes. A chunk is done when its file is there, and
the failures in it were written before: whatever is killed at whatever moment, what is
missing is computed again, to the same numbers.
"""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import closing, suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa

from orbident.campaigns.campaign_table import (
    path_of,
    read_chunk,
    schema_of,
    write_rows,
)
from orbident.campaigns.executors import Executors, computed
from orbident.campaigns.folder import FAILED, Campaign, check_versions, working
from orbident.campaigns.run import Chunk, run_chunk
from orbident.errors import InputError
from orbident.files.text import read_text, write_text
from orbident.files.writing import writing


class Done(NamedTuple):
    """How far a campaign is."""

    runs: int
    """Made so far, failed ones too."""
    of: int
    failed: int


Progress = Callable[[Done], object]


def conduct(
    campaign: Campaign,
    folder: Path,
    executors: Executors,
    progress: Progress = lambda _: None,
) -> Done:
    """Make what is missing.

    Args:
        campaign: of the folder.
        folder: that `begin` made.
        executors: where runs are made.
        progress: is called after every chunk, and before the first.

    Raises:
        InputError: another command is at it, the folder cannot be written, rows that
            are there are damaged, or workers die again and again.
    """
    schema = schema_of(campaign)
    with working(folder):
        # That rows cannot be used is said before others are made for hours.
        for chunk in campaign.spec.chunks:
            if path_of(folder, chunk).exists():
                read_chunk(campaign, folder, chunk, schema)
        done = campaign_progress(campaign, folder)
        progress(done)
        work = partial(run_chunk, campaign)
        missing = _missing(campaign, folder)
        kept = f"what is done is kept in {folder}: "
        with closing(computed(executors, work, missing, kept)) as made:
            for runs, future in made:
                chunk = _result(future)
                check_versions(folder, chunk.versions, "a worker's")
                _keep(folder, runs, chunk, schema)
                more = len(runs), 0, len(chunk.failures)
                done = Done(*map(sum, zip(done, more, strict=True)))
                progress(done)
    return campaign_progress(campaign, folder)


def campaign_progress(campaign: Campaign, folder: Path) -> Done:
    """How far a campaign is, whoever runs it."""
    done = [chunk for chunk in campaign.spec.chunks if path_of(folder, chunk).exists()]
    failed = sum(1 for _ in failed_runs(folder))
    return Done(sum(map(len, done)), campaign.spec.runs, failed)


def failed_runs(folder: Path) -> Iterator[Path]:
    """The files of runs that could not be made, in their order."""
    found = (path for path in (folder / FAILED).glob("*.json") if path.stem.isdigit())
    return iter(sorted(found, key=lambda path: int(path.stem)))


def reason_in(path: Path) -> str:
    """Why a run could not be made.

    Raises:
        InputError: the file is damaged.
    """
    with suppress(RecursionError, LookupError, TypeError, json.JSONDecodeError):
        return str(json.loads(read_text(path))["reason"])
    raise InputError(
        f"{path}: is damaged; see with 'orbident campaign rerun' why the run fails"
    )


def failure_of(folder: Path, k: int) -> Path:
    """Where it is said why run `k` could not be made."""
    return folder / FAILED / f"{k}.json"


def _missing(campaign: Campaign, folder: Path) -> Iterator[range]:
    for chunk in campaign.spec.chunks:
        if not path_of(folder, chunk).exists():
            yield chunk


def _result(future: Future[Chunk]) -> Chunk:
    try:
        return future.result()
    except InputError:
        raise
    # A run that raises is in its chunk; this is the worker itself.
    except Exception as error:
        raise InputError(
            f"a worker cannot work ({type(error).__name__}: {error}); what is done is "
            "kept: see that every worker has this Orbident and memory for it, and run "
            "the same command again"
        ) from error


def _keep(folder: Path, runs: range, chunk: Chunk, schema: pa.Schema) -> None:
    # The rows last: their file says that the chunk is done.
    if chunk.failures:
        with writing(folder):
            (folder / FAILED).mkdir(exist_ok=True)
    for failure in chunk.failures:
        text = json.dumps(failure.document, indent=1)
        write_text(failure_of(folder, failure.k), text)
    write_rows(path_of(folder, runs), chunk.rows, schema)
