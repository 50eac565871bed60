"""`orbident export RUN -o FILE`, `orbident export RUN --flight DIR --recording REC`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import Force, Json, Quiet
from orbident.errors import InputError


def export(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN",
            help="A folder that 'identify -o' wrote; with --flight, a robot too.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="FILE",
            help="A .urdf with the identified inertias, a .json with H+ and the "
            "Jacobians at --q, or the parameters with their deviations as .csv or, for "
            "a paper, .tex.",
        ),
    ] = None,
    q: Annotated[
        str | None,
        typer.Option(
            metavar="Q1,Q2,..",
            help="Joint positions in the robot's order, rad or m; for .json.",
        ),
    ] = None,
    flight: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="A new folder with the recursive filter in C++ for a flight computer, "
            "and a program that replays --recording.",
        ),
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="A recording: CSV or Parquet; for --flight. It says how noisy the "
            "sensors are.",
        ),
    ] = None,
    force: Force = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Write the identified model, or a filter for flight computers."""
    from orbident.cli.output import Output
    from orbident.files.replacing import check_free
    from orbident.identified.run_folder import load_result

    output = Output(json, quiet)
    _check_what(out, q, flight, recording)
    if flight is not None and recording is not None:
        _export_flight(output, run, flight, recording, force)
        return
    assert out is not None
    _check_kind(out, q)
    check_free(out, force)
    result = load_result(run)
    if q is not None:
        _export_matrices(output, result, out, _numbers(q))
    elif out.suffix.lower() == ".urdf":
        _export_urdf(output, result, out)
    else:
        _export_parameters(output, result, out)


def _check_what(
    out: Path | None, q: str | None, flight: Path | None, recording: Path | None
) -> None:
    if (out is None) == (flight is None):
        raise InputError("export: give either -o FILE or --flight DIR")
    if flight is None and recording is not None:
        raise InputError("--recording: is for --flight; leave it out")
    if flight is not None and recording is None:
        raise InputError(
            "--flight: a filter needs the noise of its sensors, and something to "
            "replay; give --recording REC"
        )
    if flight is not None and q is not None:
        raise InputError("--q: is for a .json; leave it out")


def _export_flight(
    output: Any, run: Path, folder: Path, recording: Path, force: bool
) -> None:
    from orbident.cli.output import progress
    from orbident.identified.flight_export import check_empty, export_flight
    from orbident.identified.flight_samples import samples_for_flight
    from orbident.identified.run_folder import load_result
    from orbident.recordings.tables import read_recording
    from orbident.robot.robot_file import load_robot

    check_empty(folder, force)
    source = load_result(run) if run.is_dir() else load_robot(str(run))
    with progress("filtering"):
        given = samples_for_flight(source, read_recording(recording))
        written = export_flight(*given, folder, force)
    if not written.scale:
        output.warn(
            [
                f"{recording}: does not determine the scale of the parameters, so "
                "what 'replay' estimates must not be trusted; record while a wheel "
                "spins"
            ]
        )
    output.say(
        f"written: {folder}, which replays {written.steps} steps; a filter takes "
        f"{written.memory} numbers, {written.state} of them its state",
        f"cmake -S {folder} -B {folder}/build && cmake --build {folder}/build && "
        f"{folder}/build/replay",
    )
    output.write_json({"folder": str(folder), **written._asdict()})


def _check_kind(out: Path, q: str | None) -> None:
    kind = out.suffix.lower()
    if kind not in {".urdf", ".json", ".csv", ".tex"}:
        raise InputError(f"{out}: give a name that ends in .urdf, .json, .csv or .tex")
    if kind != ".json" and q is not None:
        raise InputError(
            f"{out}: --q is for .json; a URDF and the parameters hold in every position"
        )
    if kind == ".json" and q is None:
        raise InputError(f"{out}: matrices are of one configuration; give it with --q")


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",") if text.strip()]
    except ValueError:
        raise InputError(
            f"--q: found '{text}'; give numbers with commas between them"
        ) from None


def _export_urdf(output: Any, result: Any, out: Path) -> None:
    from orbident.files.text import write_text
    from orbident.identified.physical import physical_bodies
    from orbident.identified.urdf_export import exported_urdf, rotor_parts

    robot = result.robot
    bodies = physical_bodies(result, rotor_parts(robot))
    if bodies is None:
        output.warn(
            [
                f"{out} is not written: no bodies that can exist have the identified "
                "parameters within their 95 % region; check the robot's geometry and "
                "structure, or record a richer trajectory"
            ]
        )
        raise typer.Exit(1)
    write_text(out, exported_urdf(robot, bodies.theta))
    moved = "exactly as identified"
    if bodies.deviation:
        moved = (
            f"moved by {bodies.deviation:.2g} sigma in all, so that bodies can exist"
        )
    output.say(
        f"written: {out}, {len(robot.bodies)} bodies, base parameters {moved}",
        "directions that free floating cannot observe stay as close to CAD as possible",
    )
    output.write_json(
        {
            "file": str(out),
            "deviation": bodies.deviation,
            "masses": dict(zip(robot.bodies, bodies.theta[:, 0].tolist(), strict=True)),
        }
    )


def _export_matrices(output: Any, result: Any, out: Path, q: list[float]) -> None:
    from json import dumps

    from orbident.files.text import write_text
    from orbident.identified.matrices import matrices_at

    document = matrices_at(result, q)
    write_text(out, dumps(document, indent=1, allow_nan=False) + "\n")
    output.say(f"written: {out}, H+ over {', '.join(document['speeds'])}")
    output.write_json({"file": str(out)})


def _export_parameters(output: Any, result: Any, out: Path) -> None:
    from orbident.files.text import write_text
    from orbident.identified.parameter_files import (
        parameters_as_csv,
        parameters_as_latex,
    )

    latex = out.suffix.lower() == ".tex"
    write_text(out, parameters_as_latex(result) if latex else parameters_as_csv(result))
    count = sum(len(found.names) for found in (result.base, result.phi, result.pi))
    output.say(
        f"written: {out}, {count} parameters: M, sigma and iota, then phi, then pi"
    )
    output.write_json({"file": str(out), "parameters": count})
