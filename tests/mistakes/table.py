"""The campaign's rows as Markdown: a table, totals by method, and the first reasons."""

from collections.abc import Iterable, Iterator, Sequence

from scoring import Row, Score

from orbident.estimation.identify import METHODS, Method


def markdown(rows: Sequence[Row]) -> str:
    """All of it."""
    return "\n\n".join([totals(rows), table(rows), reasons(rows)]) + "\n"


def lines(header: Sequence[str], body: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    return "\n".join(
        "| " + " | ".join(cells) + " |"
        for cells in (header, ["---"] * len(header), *body)
    )


class Count:
    """How often each outcome occurs in one method's scores."""

    def __init__(self, rows: Sequence[Row], method: Method):
        scores = [(row, row.scores[method]) for row in rows]
        self.runs = len(scores)
        self.wrong = [
            row for row, s in scores if s.outcome == "wrong" and not row.unobservable
        ]
        self.excused = sum(row.excused(method) for row in rows)
        self.silent = sum(s.outcome == "wrong" and not s.reasons for _, s in scores)
        self.right = sum(s.outcome == "right" for _, s in scores)
        refused = [row for row, s in scores if s.outcome == "refused"]
        self.refused = len(refused)
        self.named = sum(row.named(method) for row in refused)
        self.crashed = [row for row, s in scores if s.outcome == "crashed"]
        self.seconds = sum(s.seconds for _, s in scores)


def totals(rows: Sequence[Row]) -> str:
    """The totals by method, as a table."""
    body = []
    for method in METHODS:
        n = Count(rows, method)
        part = f" ({n.named / n.refused:.0%})" if n.refused else ""
        numbers = (
            n.runs, len(n.wrong), n.excused, n.silent, n.right, n.refused,
        )  # fmt: skip
        body.append(
            [method, *map(str, numbers), f"{n.named}{part}", str(len(n.crashed)),
             f"{n.seconds:.0f}"]
        )  # fmt: skip
    header = (
        "method", "runs", "accepted wrong", "accepted wrong, unobservable",
        "both without a warning", "accepted right", "refused",
        "refused and named", "crashed", "seconds",
    )  # fmt: skip
    return lines(header, body)


def table(rows: Sequence[Row]) -> str:
    """The outcomes by mistake and robot, with how many deviations the worst base
    parameter is off."""
    body = (
        [
            row.mistake.group,
            row.mistake.name,
            row.robot,
            "no" if row.unobservable else "",
            *(cell(row, method) for method in METHODS),
        ]
        for row in rows
    )
    return lines(("group", "mistake", "robot", "observable", *METHODS), body)


def cell(row: Row, method: Method) -> str:
    score = row.scores[method]
    if score.outcome == "refused":
        return "refused, named" if row.named(method) else "refused"
    if score.outcome == "crashed":
        return "**crashed**"
    warned = ", warned" if score.reasons else ""
    size = f"{score.misses.base:.3g}"
    if score.outcome == "right":
        return f"right {size}{warned}"
    return f"wrong {size}{warned}" if row.unobservable else f"**wrong {size}**{warned}"


def reasons(rows: Sequence[Row]) -> str:
    """What is said first where the true cause is not."""
    return "First reasons that are not the cause:\n\n" + lines(
        ("mistake", "robot", "method", "words of the cause", "first reason"),
        _unnamed(rows),
    )


def _unnamed(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    for row in rows:
        for method, score in row.scores.items():
            if score.outcome in {"refused", "crashed"} and not row.named(method):
                cause = row.mistake.cause.replace("|", "/")
                yield row.mistake.name, row.robot, method, cause, _short(score)


def _short(score: Score) -> str:
    return score.reason.replace("|", "/")[:160]
