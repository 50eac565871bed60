"""`orbident excite ROBOT -o TRAJ`, and `orbident excite ROBOT --compare TRAJ`."""

import math
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.choices import Objective
from orbident.cli.options import Force, Json, Quiet, RobotName
from orbident.errors import InputError
from orbident.files.names import counted

DURATION = 60.0
HARMONICS = 3
LIMITS = ("acceleration", "base_rate", "excursion", "wheel_speed")


Out = Annotated[
    Path | None, typer.Option("-o", metavar="TRAJ", help="The trajectory file.")
]
Duration = Annotated[
    float | None, typer.Option(help="Duration of the motion, s (default 60).")
]
Harmonics = Annotated[
    int | None, typer.Option(help="Number of Fourier harmonics (Eq. 41; default 3).")
]
Criterion = Annotated[
    Objective | None,
    typer.Option(
        help="What is made small. cond: the condition number of the "
        "stacked regressor. d, a, e: the "
        "geometric mean, root mean square or largest standard deviation of all "
        "parameters. The default is d where the robot file declares sensors, and cond "
        "otherwise or with --like-paper."
    ),
]
Starts = Annotated[
    int | None,
    typer.Option(help="Number of random starts of the search (default 24 or more)."),
]
Budget = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Search time, instead of a number of starts. One start takes minutes with "
        "40 harmonics, or with 1e5 s of motion.",
    ),
]
Uncertainty = Annotated[
    float,
    typer.Option(
        help="Relative uncertainty of masses and sizes, such as 0.1: the motion is "
        "made for the worst robot within it."
    ),
]
Like = Annotated[
    Path | None,
    typer.Option(
        "--like",
        metavar="TRAJ",
        help="Take both ends of the motion and the initial state from this trajectory.",
    ),
]
LikePaper = Annotated[
    bool,
    typer.Option("--like-paper", help="Use the paper's conditions for its two robots."),
]
Limit = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="NAME=VALUE",
        help="Add a limit, in SI; may be given several "
        f"times. NAME is one of {', '.join(LIMITS)}.",
    ),
]
Compare = Annotated[
    list[Path] | None,
    typer.Option(
        "--compare",
        metavar="TRAJ",
        help="Score this trajectory instead of designing one; may be given "
        "several times.",
    ),
]
Seed = Annotated[int, typer.Option(help="Random seed of the starts.", min=0)]


def excite(
    robot: RobotName,
    out: Out = None,
    duration: Duration = None,
    harmonics: Harmonics = None,
    objective: Criterion = None,
    starts: Starts = None,
    budget: Budget = None,
    uncertainty: Uncertainty = 0.0,
    like: Like = None,
    like_paper: LikePaper = False,
    limit: Limit = None,
    compare: Compare = None,
    seed: Seed = 0,
    force: Force = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Design a motion that excites every parameter.

    Limits of positions and rates hold at all times, between samples too. With
    --compare, motions that exist are scored instead.
    """
    from orbident.cli.output import Output, progress
    from orbident.files.replacing import check_free
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    if compare:
        _compare(load_robot(robot), compare, like_paper, output)
        return
    if out is None:
        raise InputError("-o is missing; say where the trajectory is to be written")
    check_free(out, force)
    described = load_robot(robot)
    limits = _limits(limit or [])
    given, paper = _conditions(
        described, (duration, harmonics), like, like_paper, limits
    )
    from orbident.excitation.design import design_excitation
    from orbident.excitation.floating import was_at_rest
    from orbident.trajectories.trajectory_file import save_trajectory

    with progress("preparing") as show:
        found = design_excitation(
            described,
            objective=objective,
            starts=starts,
            budget=budget,
            uncertainty=uncertainty,
            seed=seed,
            conditions=given,
            progress=lambda found: show(
                found.fraction, f"start {found.starts}, best {found.best:.4g}"
            ),
        )
    save_trajectory(found, out)
    trusted = excites_all(found)
    output.warn(design_doubts(found))
    if found.design["interrupted"]:
        output.warn([INTERRUPTED])
    at_rest = was_at_rest(described, given.initial, given.start)
    output.say(*designed(found, paper, at_rest), f"written: {out}")
    output.write_json(written(found, paper, out))
    if found.design["interrupted"]:
        sys.stdout.flush()
        raise KeyboardInterrupt
    if not trusted:
        raise typer.Exit(1)


def _compare(robot: Any, paths: list[Path], like_paper: bool, output: Any) -> None:
    from orbident.cli.output import progress
    from orbident.excitation.scores import compare_trajectories
    from orbident.trajectories.trajectory_file import load_trajectory

    basis = None
    if like_paper:
        from orbident.studies.spatial import paper_case

        basis = paper_case(robot).conditions.basis
    trajectories = [load_trajectory(path) for path in paths]
    with progress("comparing"):
        found = compare_trajectories(robot, trajectories, basis)
    tables, document = compared(found)
    output.say(*tables)
    output.write_json(document)


def _conditions(
    robot: Any,
    wanted: tuple[float | None, int | None],
    like: Path | None,
    like_paper: bool,
    limits: dict[str, float],
) -> tuple[Any, Any]:
    """What to keep to, and the paper's case where it is meant."""
    from dataclasses import replace

    from orbident.excitation.conditions import conditions_for, limits_of
    from orbident.trajectories.trajectory_file import load_trajectory

    duration, harmonics = wanted
    within = limits_of(robot, **limits)
    if like_paper:
        if like is not None:
            raise InputError("--like and --like-paper exclude each other; give one")
        from orbident.studies.spatial import paper_case

        paper = paper_case(robot)
        given = replace(
            paper.conditions,
            duration=paper.conditions.duration if duration is None else duration,
            harmonics=paper.conditions.harmonics if harmonics is None else harmonics,
            limits=within,
        )
        return given, paper
    source = None if like is None else load_trajectory(like)
    usual = DURATION if source is None else source.duration
    return conditions_for(
        robot,
        usual if duration is None else duration,
        HARMONICS if harmonics is None else harmonics,
        within,
        source,
    ), None


def _limits(entries: list[str]) -> dict[str, float]:
    limits = {}
    for entry in entries:
        name, _, value = entry.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = float("nan")
        if name not in LIMITS or number != number:
            raise InputError(
                f"--limit: found '{entry}'; give NAME=VALUE with a number in SI and "
                f"NAME one of {', '.join(LIMITS)}"
            )
        limits[name] = number
    return limits


CRITERIA = {
    "cond_Y": "cond Y-hat",
    "cond_Y_normalised": "cond Y-hat, unit columns",
    "cond_W": "cond W-hat",
    "cond_W_normalised": "cond W-hat, unit columns",
    "d": "d: geometric mean deviation",
    "a": "a: root mean square deviation",
    "e": "e: largest deviation",
}


SINGULAR = 1e6
"""Condition number from which encoders, good to 1e-5 rad or so, hide parameters."""

NO_WHEEL = (
    "no motion determines all parameters, because the robot has no wheel: without a "
    "momentum that is known nothing fixes their scale; declare the robot's wheels, or "
    "the joints that are wheels"
)

NOT_EXCITED = (
    "the motion does not determine all parameters; give more harmonics or a longer "
    "duration, or declare sensors and use the objective d"
)


INTERRUPTED = (
    "interrupted: the trajectory that was written is the best that was found until then"
)

AGREEMENT = 0.02
"""Relative difference of the search's score and the final one that is worth a word."""


KNOWN_AT_REST = (
    "the base turns because its wheels spin up from rest: identify the recording with\n"
    "--initial-momentum at-rest"
)


def design_doubts(found: Any) -> list[str]:
    """What makes a design doubtful."""
    made, sentences = found.design, []
    value, searched = made["value"], made["searched_value"]
    if not excites_all(found):
        sentences.append(NOT_EXCITED if found.initial.wheel_speed else NO_WHEEL)
    elif abs(searched - value) > AGREEMENT * value:
        sentences.append(
            f"the search valued this motion at {searched:.4g}, but the motion that it "
            f"really makes is worth {value:.4g}: the base turns or nutates faster than "
            "the grid of the search follows, so a better motion may exist; start with "
            "less momentum, or give less time"
        )
    return sentences


def excites_all(found: Any) -> bool:
    """Whether the criterion that was made small shows every parameter."""
    value = found.design["value"]
    return value is not None and value < SINGULAR


def designed(found: Any, paper: Any, at_rest: bool) -> list[Any]:
    """A designed trajectory in words.

    Args:
        found: the trajectory.
        paper: the paper's case, or None.
        at_rest: the robot is at rest before its wheels spin up.
    """
    from orbident.data_table import table_of

    made = found.design
    lines: list[Any] = [
        f"designed a motion of {found.duration:g} s and "
        f"{counted(len(found.joints), 'joint')}",
        f"objective {made['objective']}: {_number(made['value'])}, the best of "
        f"{counted(made['starts'], 'start')} (random motions: "
        f"{made['median_random_start']:.4g}, the best of them "
        f"{_number(made['best_random_start'])})",
    ]
    if paper is not None and paper.quoted is not None:
        lines.append(f"the paper quotes a condition number of {paper.quoted:g} for its")
    lines += [
        f"  {words:30} {_number(made['scores'][key])}"
        for key, words in CRITERIA.items()
    ]
    rows = (
        (
            name,
            _range(joint["position"]),
            _range(joint["position_limit"]),
            f"{joint['velocity']:.4g}",
            _number(joint["velocity_limit"]),
        )
        for name, joint in made["proven"]["joints"].items()
    )
    table = table_of("", ("joint", "position", "limit", "rate", "limit"), rows)
    proven = made["proven"]
    base = (
        f"base: rate {_number(proven['rate'])} rad/s, turn "
        f"{_number(proven['excursion'])} rad; wheels {_number(proven['wheel_speed'])} "
        "rad/s"
    )
    proof = ["", "proven for all times, with nominal inertia:", table, base]
    known = [KNOWN_AT_REST] if at_rest else []
    return [*lines, *proof, *known]


def written(found: Any, paper: Any, out: Path) -> dict[str, Any]:
    """The same as JSON."""
    document = {"trajectory": str(out), "duration": found.duration, **found.design}
    if paper is not None:
        document["paper_condition_number"] = paper.quoted
    return document


def compared(found: Any) -> tuple[list[Any], dict[str, Any]]:
    """Trajectories side by side, as tables and as JSON."""
    from orbident.data_table import Numeric, table_of

    rows = (
        (words, *(Numeric(_finite(getattr(s, key)), ".4g") for s in found.scores))
        for key, words in CRITERIA.items()
    )
    criteria = table_of("", ("criterion", *found.sources), rows)
    rows = (
        (
            name,
            Numeric(found.nominal[k], ".5g"),
            *(Numeric(_finite(std), ".4g") for std in found.deviations[:, k]),
        )
        for k, name in enumerate(found.parameters)
    )
    parameters = table_of("", ("parameter", "nominal", *found.sources), rows)
    document = {
        "trajectories": [
            {
                "source": source,
                "scores": {key: _finite(getattr(score, key)) for key in CRITERIA},
                "std": [_finite(float(std)) for std in deviations],
            }
            for source, score, deviations in zip(
                found.sources, found.scores, found.deviations, strict=True
            )
        ],
        "parameters": list(found.parameters),
        "nominal": found.nominal.tolist(),
    }
    title = "predicted standard deviations (Cramer-Rao):"
    first = f"compared {len(found.sources)} trajectories"
    return [first, "", criteria, "", title, parameters], document


def _number(value: float | None) -> str:
    return "-" if _finite(value) is None else f"{value:.4g}"


def _range(ends: list[float | None]) -> str:
    return f"{_number(ends[0])} .. {_number(ends[1])}"


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
