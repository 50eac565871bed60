"""Making all runs of a campaign that are not made yet, and one of them again.

Workers compute; only this process writes. A chunk is done when its file is there, and
the failures in it were written before: whatever is killed at whatever moment, what is
missing is computed again, to the same numbers.
"""

import json
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import closing, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.compute as pc

from orbident.campaigns.case import Case
from orbident.campaigns.executors import Executors, computed
from orbident.campaigns.folder import (
    FAILED,
    RERUN,
    ROWS,
    Campaign,
    Row,
    arrow_table,
    check_versions,
    done_chunks,
    path_of,
    read_chunk,
    schema_of,
    write_rows,
)
from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.estimation.results import versions
from orbident.files.replacing import locked, write_text, writing
from orbident.files.text import read_text, sha256
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording
from orbident.threads import one_thread


class Chunk(NamedTuple):
    """What a worker gives back."""

    rows: tuple[Row, ...]
    failures: tuple[dict[str, Any], ...]
    """Runs that could not be made: what was drawn, and why, as JSON has it."""
    versions: dict[str, str]
    """The versions of the libraries that computed the chunk."""


@one_thread
def run_chunk(campaign: Campaign, runs: range) -> Chunk:
    """Make these runs; one that raises is a failure, and the rest go on."""
    rows: list[Row] = []
    failures: list[dict[str, Any]] = []
    for k in runs:
        case = campaign.case(k)
        try:
            results = identified_by_method(campaign, case, case.recording())
            rows += result_rows(case, results)
        # Whatever it is: thousands of other runs are not to be lost for it.
        except Exception as error:
            failures.append(_failure(case, error))
    return Chunk(tuple(rows), tuple(failures), versions())


def identified_by_method(
    campaign: Campaign, case: Case, recording: Recording
) -> dict[str, Result]:
    """What each method of the campaign makes of a run's recording.

    Raises:
        InputError: the robot cannot be identified from it.
    """
    return {
        method: identify(case.subject.robot, recording, method)
        for method in campaign.spec.methods
    }


def result_rows(case: Case, results: Mapping[str, Result]) -> list[Row]:
    """A row for each method: its numbers, and the true ones."""
    # Of the formulas that an estimator is given, evaluated for the true bodies.
    true, rows = minimal_sets(case.subject.robot).beta(case.robot.theta), []
    for method, result in results.items():
        refused = (c.name for c in result.checks if c.level == "do not trust")
        row: Row = {
            "run": case.k,
            "robot": case.subject.name,
            "method": method,
            "level": result.level,
            "refused_by": next(refused, None),
        }
        row |= {f"draw.{name}": value for name, value in case.draws.items()}
        base = result.base
        for what, each in (("value", base.values), ("std", base.std), ("true", true)):
            names = (f"{name}.{what}" for name in base.names)
            row |= zip(names, each.tolist(), strict=True)
        rows.append(row)
    return rows


def _failure(case: Case, error: Exception) -> dict[str, Any]:
    kind, draws = type(error).__name__, {}
    # It is to be reported even where what failed is the drawing.
    with suppress(Exception):
        draws = case.draws
    return {
        "run": case.k,
        "robot": case.subject.name,
        "draws": draws,
        "error": kind,
        "reason": " ".join(str(error).split()) or kind,
        "traceback": traceback.format_exception(error),
    }


RECORDING = "recording.parquet"


class Rerun(NamedTuple):
    """What one run made."""

    case: Case
    recording: Recording
    path: Path
    """Where the recording is."""
    results: Mapping[str, Result]
    """The result of each method; a refused one names its likely cause."""
    same: bool | None
    """Whether its rows are those of the campaign; None where it has none yet."""


def repeat_run(campaign: Campaign, folder: Path, k: int) -> Rerun:
    """Make run `k` again, and keep its recording in `rerun/<k>` of the folder.

    Raises:
        InputError: there is no such run, the folder cannot be written, or the run
            fails, as it did in the campaign; the recording is kept if there is one.
    """
    if not 0 <= k < campaign.spec.runs:
        raise InputError(
            f"run {k}: the campaign has runs 0 to {campaign.spec.runs - 1}; give one"
        )
    chunk = next(chunk for chunk in campaign.spec.chunks if k in chunk)
    kept = None
    # Before anything is written: it may be refused.
    if path_of(folder, chunk).exists():
        rows = read_chunk(campaign, folder, chunk, schema_of(campaign))
        kept = rows.filter(pc.field("run") == k)
    case = campaign.case(k)
    recording = case.recording()
    place = folder / RERUN / str(k)
    with writing(place):
        place.mkdir(parents=True, exist_ok=True)
    path = place / RECORDING
    write_recording(recording, path)
    results = identified_by_method(campaign, case, recording)
    rows = arrow_table(result_rows(case, results), schema_of(campaign))
    same = None if kept is None else kept.equals(rows)
    known = {"file": path.name, "sha256": sha256(path), "seed": case.seed}
    explained = {
        method: replace(
            result.with_causes() if result.status == "rejected" else result, input=known
        )
        for method, result in results.items()
    }
    return Rerun(case, recording, path, explained, same)


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

    `progress` is called before the first chunk of runs, and after each.

    Raises:
        InputError: another command is at it, the folder cannot be written, rows that
            are there are damaged, or workers die again and again.
    """
    schema, rows = schema_of(campaign), folder / ROWS
    with writing(folder):
        rows.mkdir(exist_ok=True)
    # No other command is to run the campaign meanwhile.
    with locked(rows):
        # That rows cannot be used is said before others are made for hours.
        for chunk in done_chunks(campaign, folder):
            read_chunk(campaign, folder, chunk, schema)
        done = campaign_progress(campaign, folder)
        progress(done)
        work = partial(run_chunk, campaign)
        every = campaign.spec.chunks
        missing = (each for each in every if not path_of(folder, each).exists())
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
    done = done_chunks(campaign, folder)
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
        text = json.dumps(failure, indent=1)
        write_text(folder / FAILED / f"{failure['run']}.json", text)
    write_rows(path_of(folder, runs), chunk.rows, schema)
