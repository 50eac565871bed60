"""`orbident validate RUN REC`."""

from orbident.cli.options import Json, Quiet, RecordingFile, RunFolder


def validate(
    run: RunFolder,
    recording: RecordingFile,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Predict a recording that was not used, score the errors, and judge them.

    Exit status 1 where the parameters' deviations and the sensors do not explain them.
    """
    import typer

    from orbident.cli.output import Output, progress
    from orbident.identified.run_folder import load_result
    from orbident.identified.validate import validate as validated
    from orbident.recordings.tables import read_recording

    output = Output(json, quiet)
    result = load_result(run)
    table = read_recording(recording)
    with progress("predicting"):
        scores = validated(result, table)
    output.say(f"{scores.samples} samples predicted by {run}")
    output.say(*scores.summary())
    words = f"{scores.verdict}: {scores.reason}"
    refused = scores.verdict == "not explained"
    if refused:
        output.warn([words])
    else:
        output.say(words)
    output.write_json(scores.to_json())
    if refused:
        raise typer.Exit(1)
