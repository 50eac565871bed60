"""`orbident export RUN -o FILE`, `orbident export RUN --flight DIR --recording REC`."""

from json import dumps
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import Force
from orbident.cli.output import Output, progress
from orbident.errors import InputError
from orbident.files.replacing import check_free, write_text
from orbident.files.text import sha256


def export(
    output: Output,
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN",
            help="A folder that 'identify -o' wrote. With --flight, it may be a robot.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="FILE",
            help="The identified robot as .urdf, .xml (MJCF), .sdf or .py (Basilisk); "
            "H+ and c+ as functions in .c or .m (MATLAB); its parameters as .csv, .mat "
            "or, for a paper, .tex; what was measured and predicted as .mcap, with "
            "--recording; or H+ and the Jacobians at --q as .json.",
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
            help="A recording: CSV or Parquet. For a .mcap: the motion, any of this "
            "robot. For --flight: it says how noisy the sensors are.",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Write the identified model, or a filter for flight computers."""
    _check_what(out, q, flight, recording)
    if flight is not None and recording is not None:
        _export_flight(output, run, flight, recording, force)
        return
    assert out is not None
    suffix = _checked_suffix(out, q, recording)
    check_free(out, force)
    result = oi.load_result(run)
    if q is not None:
        words, lines, told = write_matrices(result, out, _numbers(q))
    elif recording is not None:
        words, lines, told = write_motion(result, out, recording)
    elif suffix in MODELS:
        words, lines, told = write_model(output, result, out, suffix)
    elif suffix in CODE:
        words, lines, told = write_code(result, out, suffix)
    else:
        words, lines, told = write_parameters(result, out, suffix)
    output.say(f"written: {out}: {words}", *filter(None, lines))
    output.write_json({"file": str(out), **told})


def _check_what(
    out: Path | None, q: str | None, flight: Path | None, recording: Path | None
) -> None:
    if (out is None) == (flight is None):
        raise InputError("export: give either -o FILE or --flight DIR")
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
    from orbident.identified.flight_export import (
        check_empty,
        export_flight,
        samples_for_flight,
    )

    check_empty(folder, force)
    source = oi.load_result(run) if run.is_dir() else oi.load_robot(str(run))
    with progress("filtering"):
        given = samples_for_flight(source, oi.read_recording(recording))
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


def _checked_suffix(out: Path, q: str | None, recording: Path | None) -> str:
    suffix, known = out.suffix.lower(), SUFFIXES
    if suffix not in known:
        ends = f"{', '.join(known[:-1])} or {known[-1]}"
        raise InputError(f"{out}: give a name that ends in {ends}")
    if suffix != ".json" and q is not None:
        raise InputError(f"{out}: --q is for .json; all else holds in every position")
    if suffix == ".json" and q is None:
        raise InputError(f"{out}: matrices are of one configuration; give it with --q")
    if suffix != ".mcap" and recording is not None:
        raise InputError("--recording: is for .mcap and --flight; leave it out")
    if suffix == ".mcap" and recording is None:
        raise InputError(
            f"{out}: a RUN does not keep how the joints moved; give the recording, or "
            "another of this robot, with --recording REC"
        )
    return suffix


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",") if text.strip()]
    except ValueError:
        raise InputError(
            f"--q: found '{text}'; give numbers with commas between them"
        ) from None


MODELS = {
    ".urdf": "URDF",
    ".xml": "MJCF for MuJoCo",
    ".sdf": "SDF for Gazebo",
    ".py": "a script for Basilisk",
}
"""Files that name bodies one by one."""

CODE = {
    ".c": "C99, H_plus(q, H) and c_plus(q, v, c)",
    ".m": "MATLAB, [H, c] = {name}(q, v)",
}
"""Files of functions that need nothing else."""

SUFFIXES = (*MODELS, *CODE, ".mcap", ".mat", ".csv", ".tex", ".json")

Written = tuple[str, tuple[str, ...], dict[str, Any]]
"""What was written, what else is said of it, and what its JSON tells."""


def write_model(output: Any, result: Any, out: Path, suffix: str) -> Written:
    """The robot of bodies that can exist; status 1 where there are none."""
    from orbident.identified.exported_robot import NoBodiesError, exported_robot

    try:
        made = exported_robot(result, without_rotors=suffix == ".urdf")
    except NoBodiesError as refusal:
        output.warn([f"{out} is not written: {refusal}"])
        raise typer.Exit(1) from refusal
    text, lacks = _model_text(made, suffix)
    write_text(out, text)
    robot, moved = made.robot, "exactly as identified"
    if made.deviation:
        moved = f"moved by {made.deviation:.2g} sigma in all, so that bodies can exist"
    near = (
        "directions that free floating cannot observe stay as close to CAD as possible"
    )
    masses = dict(zip(robot.bodies, robot.theta[:, 0].tolist(), strict=True))
    told = {"deviation": made.deviation, "masses": masses, "lacks": lacks}
    words = f"{MODELS[suffix]}, {len(robot.bodies)} bodies, base parameters {moved}"
    return words, (near, lacks), told


def _model_text(made: Any, suffix: str) -> tuple[str, str]:
    """The file, and what is said of motors' rotors that are not in it."""
    from orbident.identified.exported_robot import (
        NO_ARMATURE,
        NO_ROTORS,
        exported_urdf,
    )
    from orbident.identified.simulator_models import basilisk_script, mjcf, sdf
    from orbident.model.core_robot import lacking_rotors

    if suffix == ".urdf":
        return exported_urdf(made.robot), lacking_rotors(made.robot, NO_ROTORS)
    if suffix == ".xml":
        return mjcf(made), lacking_rotors(made.robot)
    text = sdf(made) if suffix == ".sdf" else basilisk_script(made)
    return text, lacking_rotors(made.robot, NO_ARMATURE)


def write_code(result: Any, out: Path, suffix: str) -> Written:
    """`H+` and `c+` as functions in another language."""
    from orbident.identified.generated_code import equations_as_c, equations_as_matlab
    from orbident.model.core_robot import lacking_rotors

    name, model = out.stem, result.dynamics()
    c = suffix == ".c"
    write_text(out, equations_as_c(model) if c else equations_as_matlab(model, name))
    return CODE[suffix].format(name=name), (lacking_rotors(model.robot),), {}


def write_matrices(result: Any, out: Path, q: list[float]) -> Written:
    """`H+` and Jacobians in one configuration, as JSON."""
    from orbident.identified.parameter_files import matrices_at

    document = matrices_at(result, q)
    write_text(out, dumps(document, indent=1, allow_nan=False) + "\n")
    return f"H+ over {', '.join(document['speeds'])}", (document["lacks"],), {}


def write_parameters(result: Any, out: Path, suffix: str) -> Written:
    """All parameters with their deviations, as CSV, LaTeX or MATLAB."""
    from orbident.identified.parameter_files import (
        parameters_as_csv,
        parameters_as_latex,
        write_mat,
    )

    more = ""
    if suffix == ".mat":
        write_mat(result, out)
        more = "; covariances, and what was measured and predicted"
    elif suffix == ".tex":
        write_text(out, parameters_as_latex(result))
    else:
        write_text(out, parameters_as_csv(result))
    count = sum(len(found.names) for found in (result.base, result.phi, result.pi))
    words = f"{count} parameters: M, sigma, iota, then phi, then pi{more}"
    return words, (), {"parameters": count}


def write_motion(result: Any, out: Path, recording: Path) -> Written:
    """What was recorded and what is predicted, as messages of ROS 2."""
    from orbident.scene.mcap_export import write_mcap

    motion = oi.read_recording(recording)
    # What was predicted of its sensors is of the one that the RUN is from.
    own = result.input.get("sha256") == sha256(recording)
    with progress("writing") as done:
        signals = result.signals() if own else ()
        counts = write_mcap(result, motion, out, signals, done)
    words = f"{sum(counts.values())} ROS 2 messages, on {', '.join(counts)}"
    return words, (), {"messages": dict(counts)}
