"""One run of a campaign once more, to look at."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa
import pyarrow.compute as pc

from orbident.campaigns.campaign_table import (
    arrow_table,
    path_of,
    read_chunk,
    schema_of,
)
from orbident.campaigns.case import Case
from orbident.campaigns.folder import RERUN, Campaign
from orbident.campaigns.run import identified_by_method, result_rows
from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.files.checksum import sha256
from orbident.files.writing import writing
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording

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
    # Before anything is written: it may be refused.
    kept = _kept(campaign, folder, k)
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


def _kept(campaign: Campaign, folder: Path, k: int) -> pa.Table | None:
    """The rows that the campaign has of a run."""
    chunk = next(chunk for chunk in campaign.spec.chunks if k in chunk)
    if not path_of(folder, chunk).exists():
        return None
    kept = read_chunk(campaign, folder, chunk, schema_of(campaign))
    return kept.filter(pc.field("run") == k)
