"""`orbident excite ROBOT -o TRAJ`, and `orbident excite ROBOT --compare TRAJ`."""

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import orbident as oi
from orbident.choices import Objective
from orbident.cli.excite_tables import (
    INTERRUPTED,
    compared,
    design_doubts,
    designed,
    excites_all,
    pulsed,
    swinging,
    together,
    written,
)
from orbident.cli.options import Force, RobotName
from orbident.cli.output import Output, progress
from orbident.errors import InputError
from orbident.files.bounds import MOST_RECORDINGS
from orbident.files.replacing import check_free

DURATION = 60.0
LIMITS = ("acceleration", "base_rate", "excursion", "wheel_speed", "impulse")


def excite(
    output: Output,
    robot: RobotName,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="TRAJ",
            help="The trajectory file; with --recordings 3, a.yaml stands for "
            "a-1.yaml, a-2.yaml and a-3.yaml.",
        ),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Duration of the motion, s (default 60).")
    ] = None,
    harmonics: Annotated[
        int | None,
        typer.Option(
            help="Number of Fourier harmonics (Eq. 41). By default 3; where anything "
            "may act from outside, the search chooses, up to 32."
        ),
    ] = None,
    objective: Annotated[
        Objective | None,
        typer.Option(
            help="What is made small. cond: the condition number of the "
            "stacked regressor. d, a, e: the geometric mean, root mean square or "
            "largest standard deviation of all parameters. The default is d where the "
            "robot file declares sensors, and cond otherwise or with --like-paper."
        ),
    ] = None,
    recordings: Annotated[
        int,
        typer.Option(
            help="Design so many motions of this duration, for as many recordings that "
            "are identified together.",
            min=1,
            max=MOST_RECORDINGS,
        ),
    ] = 1,
    starts: Annotated[
        int | None,
        typer.Option(
            help="Number of random starts of the search (default 24 or more)."
        ),
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Search time, instead of a number of starts. One start takes minutes "
            "with 40 harmonics, or with 1e5 s of motion.",
        ),
    ] = None,
    uncertainty: Annotated[
        float,
        typer.Option(
            help="Relative uncertainty of masses and sizes, such as 0.1: the motion is "
            "made for the worst robot within it."
        ),
    ] = 0.0,
    like: Annotated[
        Path | None,
        typer.Option(
            "--like",
            metavar="TRAJ",
            help="Take both ends of the motion and the initial state from this "
            "trajectory.",
        ),
    ] = None,
    wheel_speed: Annotated[
        float | None,
        typer.Option(
            metavar="RAD/S", help="Speed of all wheels at the start (default 200)."
        ),
    ] = None,
    initial_momentum: Annotated[
        Literal["unknown", "at-rest"] | None,
        typer.Option(
            help="The start. unknown: the base tumbles slowly. at-rest: all was at "
            "rest before the wheels spun up. The default is at-rest on a table, and "
            "unknown in space."
        ),
    ] = None,
    like_paper: Annotated[
        bool,
        typer.Option(
            "--like-paper", help="Use the paper's conditions for its two robots."
        ),
    ] = False,
    limit: Annotated[
        list[str] | None,
        typer.Option(
            "--limit",
            metavar="NAME=VALUE",
            help="Add a limit, in SI; may be given several times. NAME is one of "
            f"{', '.join(LIMITS)}, or table, whose VALUE is a width and a depth such "
            "as 1.2x0.8, or the radius of a round one such as 0.6.",
        ),
    ] = None,
    compare: Annotated[
        list[Path] | None,
        typer.Option(
            "--compare",
            metavar="TRAJ",
            help="Score this trajectory instead of designing one, or those of several "
            "recordings together; may be given several times. With --limit, say what "
            "it exceeds.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Random seed of the starts.", min=0)] = 0,
    force: Force = False,
) -> None:
    """Design a motion that excites every parameter.

    Limits of positions and rates hold at all times, between samples too. A robot
    without joints is excited by pulses of its thrusters. With --compare, motions that
    exist are scored instead.
    """
    from orbident.trajectories.trajectory_file import numbered

    if compare:
        _compare(robot, compare, recordings, like_paper, limit, output)
        return
    if out is None:
        raise InputError("-o is missing; say where the trajectory is to be written")
    places = numbered(out, recordings)
    for place in places:
        check_free(place, force)
    described = oi.load_robot(robot)
    limits = _limits(limit or [])
    output.warn(_beforehand(described))
    given, paper = _conditions(
        described, (duration, harmonics), like, like_paper, limits
    )
    told = like is not None or like_paper
    given = _started(described, given, wheel_speed, initial_momentum, told)
    from orbident.excitation.floating import was_at_rest
    from orbident.robot.oddities import not_shown

    asked = {"objective": objective, "starts": starts, "budget": budget, "seed": seed}
    made = _designed(described, places, given, asked | {"uncertainty": uncertainty})
    last = made[-1]
    output.warn(design_doubts(last, bool(not_shown(described))))
    interrupted = last.design["interrupted"]
    if interrupted:
        output.warn([INTERRUPTED])
    at_rest = was_at_rest(described, given.initial, given.start)
    shown = partial(designed, paper=paper, at_rest=at_rest)
    shown = shown if described.joints else pulsed
    swings = partial(swinging, robot=described, at_rest=at_rest)
    shown = swings if described.passive else shown
    for number, (found, place) in enumerate(zip(made, places, strict=False), 1):
        output.say(*together(number, recordings))
        output.say(*shown(found), f"written: {place}")
    documents = list(map(partial(written, paper=paper), made, places))
    output.write_json(documents[0] if recordings == 1 else {"recordings": documents})
    if interrupted:
        sys.stdout.flush()
        raise KeyboardInterrupt
    if not excites_all(last):
        raise typer.Exit(1)


def _beforehand(robot: Any) -> tuple[str, ...]:
    """What is odd about the instruments, whatever motion is designed.

    Raises:
        InputError: `pi` has no scale, so that `identify` refuses every recording.
    """
    from orbident.robot.oddities import not_shown, odd_sensors, shows_scale

    unshown = not_shown(robot)
    if not shows_scale(robot):
        raise InputError(f"{robot.name}: {unshown[0]}")
    return (*unshown, *(odd_sensors(robot) if robot.sensors.declared else ()))


def _started(
    robot: Any, given: Any, wheel_speed: float | None, momentum: str | None, told: bool
) -> Any:
    """The conditions, with another initial state where that is asked for."""
    from orbident.excitation.floating import usual_initial

    if wheel_speed is None and momentum is None:
        return given
    if told:
        raise InputError(
            "--wheel-speed and --initial-momentum: --like and --like-paper give the "
            "initial state already; leave one of them out"
        )
    if wheel_speed is not None and not robot.wheels:
        raise InputError(f"--wheel-speed: {robot.name} has no wheels; leave it out")
    at_rest = None if momentum is None else momentum == "at-rest"
    initial = usual_initial(robot, given.start, wheel_speed, at_rest)
    return replace(given, initial=initial)


def _designed(
    robot: Any, places: list[Path], given: Any, asked: dict[str, Any]
) -> list[Any]:
    """The trajectories, each written as soon as it is found."""
    from orbident.excitation.design import design_recordings

    made = []
    with progress("preparing") as show:

        def report(found: Any) -> None:
            fraction = (len(made) + found.fraction) / len(places)
            show(fraction, f"start {found.starts}, best {found.best:.4g}")

        for found in design_recordings(
            robot, len(places), given, progress=report, **asked
        ):
            oi.save_trajectory(found, places[len(made)])
            made.append(found)
    return made


def _compare(
    name: str,
    paths: list[Path],
    recordings: int,
    like_paper: bool,
    limit: list[str] | None,
    output: Any,
) -> None:
    from orbident.excitation.conditions import limits_of
    from orbident.excitation.scores import compare_trajectories
    from orbident.trajectories.trajectory_file import load_experiment

    if recordings > 1:
        raise InputError(
            f"--recordings {recordings}: --compare scores motions that exist, and "
            "those of several recordings where TRAJ stands for several files; leave "
            "--recordings out"
        )
    limits, robot, basis = _limits(limit or []), oi.load_robot(name), None
    if like_paper:
        from orbident.studies.spatial import paper_case

        basis = paper_case(robot).conditions.basis
    if not robot.joints:
        raise InputError(
            f"{robot.name}: --compare scores motions of joints, and there are none; "
            "'orbident inspect ROBOT --trajectory TRAJ' tells what pulses promise"
        )
    experiments = [load_experiment(path) for path in paths]
    with progress("comparing"):
        within = limits_of(robot, **limits) if limits else None
        found = compare_trajectories(robot, experiments, basis, within)
    output.warn([words for exceeded in found.exceeded for words in exceeded])
    tables, document = compared(found)
    output.say(*tables)
    output.write_json(document)


def _conditions(
    robot: Any,
    wanted: tuple[float | None, int | None],
    like: Path | None,
    like_paper: bool,
    limits: dict[str, Any],
) -> tuple[Any, Any]:
    """What to keep to, and the paper's case where it is meant."""
    from orbident.excitation.conditions import conditions_for, limits_of

    duration, harmonics = wanted
    within = limits_of(robot, **limits)
    if like_paper:
        if like is not None:
            raise InputError("--like and --like-paper exclude each other; give one")
        from orbident.studies.spatial import paper_case

        paper = paper_case(robot)
        asked = {"duration": duration, "harmonics": harmonics}
        asked = {name: value for name, value in asked.items() if value is not None}
        return replace(paper.conditions, limits=within, **asked), paper
    source = None if like is None else oi.load_trajectory(like)
    if duration is None:
        duration = DURATION if source is None else source.duration
    return conditions_for(robot, duration, harmonics, within, source), None


def _limits(entries: list[str]) -> dict[str, Any]:
    from orbident.excitation.table_points import TableSize

    limits = {}
    for entry in entries:
        name, _, value = entry.partition("=")
        try:
            numbers = [float(each) for each in value.split("x")]
        except ValueError:
            numbers = []
        most = 2 if name == "table" else 1
        if name not in (*LIMITS, "table") or not 1 <= len(numbers) <= most:
            raise InputError(
                f"--limit: found '{entry}'; give NAME=VALUE with a number in SI and "
                f"NAME one of {', '.join(LIMITS)}, or table=WIDTHxDEPTH or "
                "table=RADIUS in m"
            )
        size = TableSize(*numbers) if numbers[1:] else TableSize(radius=numbers[0])
        limits[name] = size if name == "table" else numbers[0]
    return limits
