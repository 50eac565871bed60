"""`orbident validate RUN REC`."""

from contextlib import suppress
from pathlib import Path
from typing import Any

from orbident.cli.options import (
    End,
    Json,
    Quiet,
    RecordingFile,
    RunFolder,
    Start,
    cut,
)


def validate(
    run: RunFolder,
    recording: RecordingFile,
    start: Start = None,
    end: End = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Predict a recording that was not used, and judge the errors.

    The exit status is 1 if the standard deviations of the parameters and the noise of
    the sensors do not explain the errors.
    """
    import typer

    from orbident.cli.output import Output, progress
    from orbident.identified.run_folder import load_result
    from orbident.identified.validate import validate as validated
    from orbident.recordings.tables import read_recording

    output = Output(json, quiet)
    result = load_result(run)
    table = cut(read_recording(recording), start, end)
    with progress("predicting"):
        scores = validated(result, table)
    output.say(f"{scores.samples} samples predicted by {run}")
    for name, unit in (("gyro", "rad/s"), ("velocity", "m/s")):
        rms, nrmse = scores.rms[name], scores.nrmse[name]
        if rms == rms:
            percent = f"{100 * nrmse:.3g} % of the signal"
            output.say(f"{name:9} error {rms:.3g} {unit} RMS, {percent}")
            if (std := scores.std[name]) == std:
                left = scores.noise.get(name, float("nan"))
                sensors = f"{left:.3g} {unit}" if left == left else "unknown"
                output.say(
                    f"{'':9} expected: {std:.3g} {unit} by the parameters' deviations, "
                    f"{sensors} by the sensors (what a fit of this recording leaves)"
                )
        else:
            output.say(f"{name:9} was not measured")
    if scores.dof:
        output.say(
            f"chi-square {scores.chi2:.3g} with {scores.dof} degrees of freedom, "
            f"p = {scores.p_value:.2g}"
        )
    words = f"{scores.verdict}: {scores.reason}"
    refused = scores.verdict == "not explained"
    if refused:
        output.warn([words])
    else:
        output.say(words)
    output.write_json(scores.to_json())
    if kept(run, recording, scores.to_json()):
        output.say(f"'orbident report {run} --force' shows it in the report")
    if refused:
        raise typer.Exit(1)


def kept(run: Path, recording: Path, scores: dict[str, Any]) -> bool:
    """Keep the scores in the RUN for its report, where that may be written."""
    import json

    from orbident.errors import InputError
    from orbident.files.checksum import sha256
    from orbident.files.locking import locked
    from orbident.files.text import name_of, write_text
    from orbident.identified.run_folder import VALIDATION

    origin = {"file": name_of(recording), "sha256": sha256(recording)}
    with suppress(InputError, OSError), locked(run):
        write_text(run / VALIDATION, json.dumps({**origin, **scores}, indent=1))
        return True
    return False
