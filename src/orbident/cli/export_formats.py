"""What `orbident export` writes, by the suffix of the file."""

from pathlib import Path
from typing import Any

import typer

MODELS = {
    ".urdf": "URDF",
    ".xml": "MJCF for MuJoCo",
    ".sdf": "SDF for Gazebo",
    ".py": "a script for Basilisk",
}
"""Files that name bodies one by one."""

SUFFIXES = (*MODELS, ".mcap", ".mat", ".csv", ".tex", ".json")


def write_model(output: Any, result: Any, out: Path) -> None:
    """The robot of bodies that can exist; status 1 where there are none."""
    from orbident.files.text import write_text
    from orbident.identified.exported_robot import NoBodiesError, exported_robot

    try:
        made = exported_robot(result)
    except NoBodiesError as refusal:
        output.warn([f"{out} is not written: {refusal}"])
        raise typer.Exit(1) from refusal
    write_text(out, _model_text(made, out.suffix.lower()))
    robot, moved = made.robot, "exactly as identified"
    if made.deviation:
        moved = f"moved by {made.deviation:.2g} sigma in all, so that bodies can exist"
    output.say(
        f"written: {out}: {MODELS[out.suffix.lower()]}, {len(robot.bodies)} bodies, "
        f"base parameters {moved}",
        "directions that free floating cannot observe stay as close to CAD as possible",
    )
    masses = dict(zip(robot.bodies, robot.theta[:, 0].tolist(), strict=True))
    output.write_json({"file": str(out), "deviation": made.deviation, "masses": masses})


def _model_text(made: Any, suffix: str) -> str:
    if suffix == ".urdf":
        from orbident.identified.urdf_export import exported_urdf

        return exported_urdf(made.robot, made.robot.theta)
    if suffix == ".xml":
        from orbident.identified.mjcf_export import mjcf

        return mjcf(made.mechanism)
    if suffix == ".sdf":
        from orbident.identified.sdf_export import sdf

        return sdf(made.mechanism)
    from orbident.identified.basilisk_export import basilisk_script

    return basilisk_script(made)


def write_matrices(output: Any, result: Any, out: Path, q: list[float]) -> None:
    """`H+` and Jacobians in one configuration, as JSON."""
    from json import dumps

    from orbident.files.text import write_text
    from orbident.identified.parameter_files import matrices_at

    document = matrices_at(result, q)
    write_text(out, dumps(document, indent=1, allow_nan=False) + "\n")
    output.say(f"written: {out}: H+ over {', '.join(document['speeds'])}")
    output.write_json({"file": str(out)})


def write_parameters(output: Any, result: Any, out: Path) -> None:
    """All parameters with their deviations, as CSV, LaTeX or MATLAB."""
    from orbident.files.text import write_text
    from orbident.identified.parameter_files import (
        parameters_as_csv,
        parameters_as_latex,
    )

    suffix, more = out.suffix.lower(), ""
    if suffix == ".mat":
        from orbident.identified.mat_export import write_mat

        write_mat(result, out)
        more = "; covariances, and what was measured and predicted"
    elif suffix == ".tex":
        write_text(out, parameters_as_latex(result))
    else:
        write_text(out, parameters_as_csv(result))
    count = sum(len(found.names) for found in (result.base, result.phi, result.pi))
    output.say(
        f"written: {out}: {count} parameters: M, sigma, iota, then phi, then pi{more}"
    )
    output.write_json({"file": str(out), "parameters": count})


def write_motion(output: Any, result: Any, out: Path, recording: Path) -> None:
    """What was recorded and what is predicted, as messages of ROS 2."""
    from orbident.cli.output import progress
    from orbident.files.checksum import sha256
    from orbident.recordings.tables import read_recording
    from orbident.scene.mcap_export import write_mcap

    motion = read_recording(recording)
    # What was predicted of its sensors is of the one that the RUN is from.
    own = result.input.get("sha256") == sha256(recording)
    with progress("writing") as done:
        signals = result.signals() if own else ()
        counts = write_mcap(result, motion, out, signals, done)
    output.say(
        f"written: {out}: {sum(counts.values())} ROS 2 messages, on {', '.join(counts)}"
    )
    output.write_json({"file": str(out), "messages": dict(counts)})
