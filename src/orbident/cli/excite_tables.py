"""What `orbident excite` prints, and its JSON."""

import math
from pathlib import Path
from typing import Any

from orbident.data_table import Numeric, table_of
from orbident.files.names import counted

CRITERIA = {
    "cond_Y": "cond Y-hat",
    "cond_Y_normalised": "cond Y-hat, unit columns",
    "cond_W": "cond W-hat",
    "cond_W_normalised": "cond W-hat, unit columns",
    "d": "d: geometric mean deviation",
    "a": "a: root mean square deviation",
    "e": "e: largest deviation",
}


BESIDE = {
    "price": "times as wide by what may act",
    "price_of_tolerances": "times as wide by tolerances",
    "drift": "moved by what may act, m",
}

SINGULAR = 1e6
"""Condition number from which encoders, good to 1e-5 rad or so, hide parameters."""

INTERRUPTED = (
    "interrupted: the trajectory that was written is the best that was found until then"
)

AGREEMENT = 0.02
"""Relative difference of the search's score and the final one that is worth a word."""

KNOWN_AT_REST = (
    "the base turns because its wheels spin up from rest: identify the recording with\n"
    "--initial-momentum at-rest"
)


def design_doubts(found: Any, unshown: bool) -> list[str]:
    """What makes a design doubtful.

    That instruments leave something `unshown` was said before: no motion helps there.
    """
    made = found.design
    value, searched = made["value"], made["searched_value"]
    if excites_all(found):
        if abs(searched - value) <= AGREEMENT * value:
            return []
        return [
            f"the search valued this motion at {searched:.4g}, but the motion that it "
            f"really makes is worth {value:.4g}: the base turns or nutates faster than "
            "the grid of the search follows, so a better motion may exist; start with "
            "less momentum, or give less time"
        ]
    if unshown:
        return []
    if not found.joints:
        return [
            "the pulses do not determine all parameters; give more time or impulse, or "
            "declare the noise of position and attitude"
        ]
    doubt = (
        "the motion does not determine all parameters; give more harmonics or a longer "
        "duration"
    )
    if made["objective"] == "cond":
        doubt += ", or declare sensors and use the objective d"
    return [doubt]


def excites_all(found: Any) -> bool:
    """Whether the criterion that was made small shows every parameter."""
    value = found.design["value"]
    return value is not None and value < SINGULAR


def designed(found: Any, paper: Any, at_rest: bool) -> list[Any]:
    """A designed trajectory in words.

    The robot may be at rest before its wheels spin up; the paper's case may be None.
    """
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
    scores = made["scores"]
    lines += [f"  {words:30} {_number(scores[key])}" for key, words in CRITERIA.items()]
    if scores["price"] is not None:
        lines.append(
            "what may act from outside makes deviations "
            f"{_number(scores['price'])} times as wide (of the best random motion: "
            f"{_number(made['price_of_random_start'])} times)"
        )
    if scores["price_of_tolerances"] is not None:
        lines.append(
            "what may be off about instruments, within tolerances, makes them "
            f"{_number(scores['price_of_tolerances'])} times as wide"
        )
    proven = made["proven"]
    base = _base_words(proven)
    if scores["drift"]:
        base += (
            f"\nwhat may act moves the robot by {scores['drift']:.2g} m on the table "
            "beside this (one standard deviation)"
        )
    joints = _joint_table(proven["joints"])
    proof = ["", "proven for all times, with nominal inertia:", joints, base]
    known = [KNOWN_AT_REST] if at_rest else []
    return [*lines, *proof, *known]


def _joint_table(joints: Any) -> Any:
    """Extremes beside their limits."""
    rows = (
        (
            name,
            _range(joint["position"]),
            _range(joint["position_limit"]),
            f"{joint['velocity']:.4g}",
            _number(joint["velocity_limit"]),
        )
        for name, joint in joints.items()
    )
    return table_of("", ("joint", "position", "limit", "rate", "limit"), rows)


def _base_words(extremes: Any) -> str:
    base = (
        f"base: rate {_number(extremes['rate'])} rad/s, "
        f"{_turn(extremes['excursion'])}; "
        f"wheels {_number(extremes['wheel_speed'])} rad/s"
    )
    if extremes.get("table"):
        base += f"; {table_words(extremes['table'])}"
    return base


def swinging(found: Any, robot: Any, at_rest: bool) -> list[Any]:
    """A designed motion beside which joints swing, in words."""
    made, extremes = found.design, found.design["extremes"]
    worth = ", ".join(
        f"{_number(each['value'])} with {each['harmonics']}"
        for each in made["by_harmonics"]
    )
    beyond = made["beyond_limits"]
    units = {joint.name: joint.unit for joint in robot.joints}
    return [
        f"designed a motion of {found.duration:g} s and "
        f"{counted(len(found.joints), 'joint')}, beside which others swing",
        f"geometric mean of the deviations: {_number(made['value'])}, the best of "
        f"{counted(made['starts'], 'start')}",
        f"by the number of harmonics: {worth}"
        + (f" ({beyond} more broke a limit)" if beyond else ""),
        "",
        "proven for all times:",
        _joint_table(made["proven"]["joints"]),
        "with nominal inertia and springs as declared, nothing else acting:",
        _base_words(extremes),
        *(
            f"{name} swings by up to {_number(most)} {units[name]}"
            for name, most in extremes["swings"].items()
        ),
        *([KNOWN_AT_REST] if at_rest else []),
    ]


def pulsed(found: Any) -> list[Any]:
    """A designed sequence of thruster pulses in words."""
    made, thrusters = found.design, found.environment.thrusters
    beyond = made["beyond_limits"]
    rows = []
    for name, each in thrusters.items():
        on = [pulse.off - pulse.on for pulse in each.pulses]
        impulse = sum(
            time * pulse.force for time, pulse in zip(on, each.pulses, strict=True)
        )
        cells = (Numeric(sum(on), ".4g"), Numeric(impulse, ".4g"))
        rows.append((name, str(len(on)), *cells))
    extremes = made["extremes"]
    base = (
        f"base: rate {_number(extremes['rate'])} rad/s, "
        f"{_turn(extremes['excursion'])}; S {table_words(extremes['table'])}; "
        f"impulse {_number(extremes['impulse'])} N s"
    )
    return [
        f"designed pulses of {counted(len(thrusters), 'thruster')} for "
        f"{found.duration:g} s",
        f"geometric mean of the deviations: {_number(made['value'])}, the best of "
        f"{counted(made['starts'], 'random sequence')} (median "
        f"{_number(made['median_random_start'])}; {beyond} more broke a limit)",
        table_of("", ("thruster", "pulses", "on (s)", "impulse (N s)"), rows),
        "",
        "with nominal inertia and thrust, nothing else acting, without feedback:",
        base,
    ]


def together(number: int, recordings: int) -> list[str]:
    """What the scores of one of several motions are of."""
    if recordings == 1:
        return []
    scores = "" if number == 1 else "; scores are of all until here together"
    return ["", f"recording {number} of {recordings}{scores}"]


def written(found: Any, out: Path, paper: Any) -> dict[str, Any]:
    """The same as JSON."""
    document = {"trajectory": str(out), "duration": found.duration, **found.design}
    if paper is not None:
        document["paper_condition_number"] = paper.quoted
    return document


def compared(found: Any) -> tuple[list[Any], dict[str, Any]]:
    """Trajectories side by side, as tables and as JSON."""
    from orbident.files.json_parts import nulled

    shown = dict(CRITERIA)
    for key, words in BESIDE.items():
        if any(getattr(score, key) is not None for score in found.scores):
            shown[key] = words
    rows = (
        (words, *(Numeric(nulled(getattr(s, key)), ".4g") for s in found.scores))
        for key, words in shown.items()
    )
    sizes = [table for table in found.tables if table]
    if sizes:
        rows = [
            *rows,
            ("table, m", *map(sides_of, sizes)),
            ("round table, radius in m", *(Numeric(t.radius, ".4g") for t in sizes)),
        ]
    criteria = table_of("", ("criterion", *found.sources), rows)
    rows = (
        (
            name,
            Numeric(found.nominal[k], ".5g"),
            *(Numeric(nulled(std), ".4g") for std in found.deviations[:, k]),
        )
        for k, name in enumerate(found.parameters)
    )
    parameters = table_of("", ("parameter", "nominal", *found.sources), rows)
    document = {
        "trajectories": [
            {
                "source": source,
                "scores": {key: nulled(getattr(score, key)) for key in shown},
                "std": nulled(deviations),
                "table": table and [nulled(size) for size in table],
                "exceeded": list(exceeded),
            }
            for source, score, deviations, table, exceeded in zip(
                found.sources,
                found.scores,
                found.deviations,
                found.tables,
                found.exceeded,
                strict=True,
            )
        ],
        "parameters": list(found.parameters),
        "nominal": found.nominal.tolist(),
    }
    title = "predicted standard deviations (Cramer-Rao):"
    first = f"compared {len(found.sources)} trajectories"
    return [first, "", criteria, "", title, parameters], document


def table_words(table: Any) -> str:
    """How large a table a motion needs; S and the arm stay on it."""
    return (
        f"needs {sides_of(table)} m of a table, or a round one of radius "
        f"{_number(table[-1])} m"
    )


def sides_of(table: Any) -> str:
    """Width and depth, m."""
    width, depth, _ = table
    return f"{_number(width)} x {_number(depth)}"


def _turn(angle: float | None) -> str:
    """No two attitudes are more than half a turn apart: that is no limit."""
    known = angle is not None and angle < math.pi
    return f"turn {angle:.4g} rad" if known else "turn of any angle"


def _number(value: float | None) -> str:
    known = value is not None and math.isfinite(value)
    return f"{value:.4g}" if known else "-"


def _range(ends: list[float | None]) -> str:
    return f"{_number(ends[0])} .. {_number(ends[1])}"
