"""What every case must show, whatever the input was."""

import itertools
import json
import re

from case import Case
from watcher import MOST_MEMORY, Outcome

INTERNAL_ERROR = 70
INTERRUPTED = {130, 143}
"""Exit statuses after Ctrl-C or SIGTERM, which no case is sent."""
LONGEST_LINE = 1000
"""Characters: names are cut before they are quoted."""


def fault(case: Case, outcome: Outcome) -> str | None:
    """What is wrong with an outcome, in one line; None where nothing is.

    Status 0 is done, 1 must say why the result is not trusted, 2 is one line. Standard
    error holds lines of the command only. A refusal leaves nothing behind.
    """
    if outcome.stopped:
        return outcome.stopped
    if outcome.status < 0:
        return f"ended by signal {-outcome.status}"
    if outcome.status == INTERNAL_ERROR:
        return outcome.err.strip() or "an internal error without a word"
    if outcome.status in INTERRUPTED:
        return f"interrupted by nobody: status {outcome.status}"
    if outcome.status not in {0, 1, 2}:
        return f"status {outcome.status}"
    if outcome.peak > MOST_MEMORY:
        return "memory"
    return _wrong_words(outcome) or _wrong_results(case, outcome)


def signature(fault: str) -> str:
    """The same for faults that differ in numbers and names only."""
    quoted = re.sub(r"'[^']*'|\"[^\"]*\"", "'..'", fault)
    return re.sub(r"\d+", "0", quoted)[:120]


def _wrong_words(outcome: Outcome) -> str | None:
    lines = outcome.err.splitlines()
    for line in lines:
        if "internal error" in line:
            return line
        if not line.startswith("orbident: "):
            return f"a raw line: {line}"
        if len(line) > LONGEST_LINE:
            return f"a line of {len(line)} characters: {line[:80]}"
    refusals = [line for line in lines if not line.startswith("orbident: warning: ")]
    if outcome.status == 2 and len(lines) != 1:
        return f"status 2 with {len(lines)} lines"
    if outcome.status != 2 and refusals:
        return f"status {outcome.status} with a refusal: {refusals[0]}"
    if outcome.status == 1 and not lines:
        return "status 1 without a reason"
    return None


def _wrong_results(case: Case, outcome: Outcome) -> str | None:
    asked = {"-h", "--help"} & {*case.arguments}
    live = case.arguments[:1] == ("live",) and not asked
    if live and not all(map(_is_json, outcome.out.splitlines())):
        return "a line of standard output is not JSON"
    if outcome.status == 2:
        # What `live` has told before is told.
        if outcome.out and not live:
            return "status 2 with standard output"
        if outcome.left:
            return f"a refusal leaves or changes {next(iter(outcome.left))}"
    elif _json_asked_for(case.arguments) and outcome.out and not _is_json(outcome.out):
        return "standard output is not JSON"
    return None


def _json_asked_for(arguments: tuple[str, ...]) -> bool:
    """Whether standard output is to be JSON: the last `--json` holds."""
    given = itertools.pairwise(arguments)
    places = [place for option, place in given if option == "--json"]
    return places[-1:] == ["-"] and "--help" not in arguments


def _is_json(text: str) -> bool:
    def refuse(constant: str) -> None:
        raise ValueError(constant)

    try:
        json.loads(text, parse_constant=refuse)
    except ValueError:
        return False
    return True
