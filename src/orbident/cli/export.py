"""`orbident export RUN -o FILE`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import Json, Quiet, RunFolder
from orbident.errors import InputError


def export(
    run: RunFolder,
    out: Annotated[
        Path,
        typer.Option(
            "-o",
            metavar="FILE",
            help="A .urdf with the identified inertias, or a .json with H+ and the "
            "Jacobians at --q.",
        ),
    ],
    q: Annotated[
        str | None,
        typer.Option(
            metavar="Q1,Q2,..",
            help="Joint positions in the robot's order, rad or m; for .json.",
        ),
    ] = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Write the identified model as a URDF, or its matrices in one configuration."""
    from orbident.cli.output import Output
    from orbident.files.replacing import check_place
    from orbident.identified.run_folder import load_result

    output = Output(json, quiet)
    _check_kind(out, q)
    check_place(out)
    result = load_result(run)
    if q is None:
        _export_urdf(output, result, out)
    else:
        _export_matrices(output, result, out, _numbers(q))


def _check_kind(out: Path, q: str | None) -> None:
    kind = out.suffix.lower()
    if kind not in {".urdf", ".json"}:
        raise InputError(f"{out}: give a name that ends in .urdf or .json")
    if kind == ".urdf" and q is not None:
        raise InputError(f"{out}: --q is for .json; a URDF holds in every position")
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
        f"{out}: {len(robot.bodies)} bodies, base parameters {moved}",
        "what does not show in momentum is as near to the nominal bodies as can be",
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
    output.say(f"{out}: H+ over {', '.join(document['speeds'])}")
    output.write_json({"file": str(out)})
