"""`orbident demo`."""

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.identify import keep
from orbident.cli.options import Force, as_typed
from orbident.cli.output import Output, progress
from orbident.files.replacing import check_free, replacing_files
from orbident.files.text import sha256

RUN = "run"
FLIGHTS = ("flight.csv", "other_flight.csv")


def demo(
    output: Output,
    out: Annotated[
        Path,
        typer.Option(
            "-o", metavar="DIR", help="The folder for two recordings and the RUN."
        ),
    ] = Path("demo"),
    seed: Annotated[
        int, typer.Option(help="Random seed of robot, noise and torque.", min=0)
    ] = 0,
    force: Force = False,
) -> None:
    """See it work: a robot that CAD has wrong is flown and identified.

    The flight is simulated, with noise, errors of instruments and a torque that nobody
    knows. What it shows of the robot predicts another flight, beside what CAD predicts.
    The report opens in the browser, where there is one.
    """
    import numpy as np

    from orbident.cli.identify_tables import summary, warnings_of
    from orbident.identified.prediction import predict
    from orbident.identified.run_folder import check_absent
    from orbident.scene.replay import with_cad_values
    from orbident.studies import demo as study

    check_absent(out / RUN, force)
    for name in FLIGHTS if out.exists() else ():
        check_free(out / name, force)
    with progress("flying"):
        flown = study.fly_demo(seed)
    robot, lasted = flown.robot, flown.first.t[-1] - flown.first.t[0]
    output.say(
        f"the robot: {robot.name}, {len(robot.joints)} joints, {len(robot.wheels)} "
        f"wheels; each mass, CM and inertia is {100 * study.WRONG:g} % off CAD",
        f"its flight: {lasted:g} s, simulated, with noise, errors of instruments and a "
        f"torque of {1e3 * study.TORQUE:g} mN m",
        "identified from it, with nothing known of these but how large they usually "
        "are:",
        "",
    )
    with progress("identifying") as done:
        result = oi.identify(robot, flown.first, progress=done)
    unmade, result = _kept(result, flown, out, force)
    output.warn([*unmade, *warnings_of(result, everything=False)])
    output.say(*summary(result, None, everything=False))
    if result.status == "rejected":
        raise typer.Exit(1)
    both = {"identified": result, "CAD": with_cad_values(result)}
    away = {name: flown.farthest(each) for name, each in both.items()}
    off = {
        name: float(np.degrees(study.turned_off(predict(each, flown.other))[-1]))
        for name, each in both.items()
    }
    output.say(
        "",
        f"the truth: at most {away['identified']:.2g} std from what is identified, "
        f"{away['CAD']:.3g} from CAD",
        "another flight, predicted from how joints and wheels move: at its end the "
        "attitude",
        f"is {off['identified']:.2g} deg off as identified, {off['CAD']:.2g} by CAD",
        "",
        *_next(out, shown=not output.silent),
    )
    output.write_json(
        {
            "run": str(out / RUN),
            "status": result.status,
            "farthest_std": away,
            "attitude_off_deg": off,
        }
    )


def _kept(result: Any, flown: Any, out: Path, force: bool) -> tuple[list[str], Any]:
    """Write recordings and RUN: warnings, and the result, which knows its input."""
    with replacing_files(out, FLIGHTS) as new:
        for name, recording in zip(FLIGHTS, (flown.first, flown.other), strict=True):
            oi.write_recording(recording, new / name)
        known = {"file": FLIGHTS[0], "sha256": sha256(new / FLIGHTS[0])}
        result = replace(result, input=known | as_typed())
        return keep(result, flown.robot, flown.first, out / RUN, force), result


def _next(out: Path, shown: bool) -> list[str]:
    """Where to look, and what to do with a robot of one's own."""
    from orbident.identified.run_folder import REPORT

    page = out / RUN / REPORT
    there = page.exists()
    opened = " (it is open in the browser)" if there and shown and _opened(page) else ""
    return [
        *([f"its report: {page}{opened}"] if there else []),
        f"in 3D: orbident view {out / RUN} --recording {out / FLIGHTS[1]}",
        "your robot: orbident check arm.urdf (or xacro, MJCF, SDF); what such a file "
        "cannot say is",
        "in a robot file, which orbident new robot.yaml writes for you to edit",
    ]


def _opened(page: Path) -> bool:
    """Whether a browser shows it; none is asked where nobody would see its window."""
    import webbrowser

    windows = {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()
    seen = sys.platform in {"darwin", "win32"} or windows
    if not (seen and sys.stdout.isatty()):
        return False
    return webbrowser.open(page.resolve().as_uri())
