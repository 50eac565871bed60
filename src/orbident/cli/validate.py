"""`orbident validate RUN REC`."""

from orbident.cli.options import Json, Quiet, RecordingFile, RunFolder


def validate(
    run: RunFolder,
    recording: RecordingFile,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Predict a recording that was not used, and score the prediction."""
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
    for name, unit in (("gyro", "rad/s"), ("velocity", "m/s")):
        rms, nrmse = scores.rms[name], scores.nrmse[name]
        if rms == rms:
            percent = f"{100 * nrmse:.3g} % of the signal"
            output.say(f"{name:9} error {rms:.3g} {unit} RMS, {percent}")
            if (std := scores.std[name]) == std:
                inside = f"{100 * scores.inside[name]:.3g} % of the errors"
                output.say(
                    f"{'':9} +- {std:.3g} {unit} RMS is what the parameters' deviations"
                    f" explain; within 1.96 of it {inside} (95 % without sensor noise)"
                )
        else:
            output.say(f"{name:9} was not measured")
    output.write_json(scores.to_json())
