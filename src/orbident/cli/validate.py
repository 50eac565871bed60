"""`orbident validate RUN REC`."""

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import typer

import orbident as oi
from orbident.cli.options import End, RecordingFile, RunFolder, Start, cut_to_times
from orbident.cli.output import Output, progress
from orbident.files.replacing import locked, write_text
from orbident.files.text import name_of, sha256


def validate(
    output: Output,
    run: RunFolder,
    recording: RecordingFile,
    start: Start = None,
    end: End = None,
) -> None:
    """Predict a recording that was not used, and judge the errors.

    The exit status is 1 if the parameters differ by more than chance from those that
    this recording alone would give.
    """
    result = oi.load_result(run)
    table = cut_to_times(oi.read_recording(recording), start, end)
    with progress("predicting"):
        scores = oi.validate(result, table)
    output.say(f"{scores.samples} samples predicted by {run}")
    output.say(*scores.summary())
    words = f"{scores.verdict}: {scores.reason}"
    used = was_used(result.input, sha256(recording), start, end)
    refused = scores.verdict == "not explained"
    if refused:
        output.warn([words])
    else:
        output.say(words)
    if used:
        output.say(
            f"{run} was identified from {recording}, so its errors say little about "
            "the parameters: validate with another recording"
        )
    output.write_json(scores.to_json())
    if keep_scores(run, recording, {"used": used, **scores.to_json()}):
        output.say(f"'orbident report {run} --force' shows it in the report")
    if refused:
        raise typer.Exit(1)


def was_used(
    origin: Mapping[str, Any], sha256: str, start: float | None, end: float | None
) -> bool:
    """Whether a result was identified from some of the same samples.

    The samples are those from `start` to `end`, s, where not all are used.
    """
    return any(
        one.get("sha256") == sha256
        and (start is None or one.get("to") is None or start < one["to"])
        and (end is None or one.get("from") is None or one["from"] < end)
        for one in origin.get("recordings", [origin])
    )


def keep_scores(run: Path, recording: Path, scores: dict[str, Any]) -> bool:
    """Keep the scores in the RUN for its report, where that may be written."""
    from orbident.identified.run_folder import VALIDATION

    origin = {"file": name_of(recording), "sha256": sha256(recording)}
    with suppress(oi.InputError, OSError), locked(run):
        write_text(run / VALIDATION, json.dumps({**origin, **scores}, indent=1))
        return True
    return False
