"""`python benchmarks/open`: fixed problems, several methods, one page of results.

Give names of problems to have only those. See docs/open-benchmark.md.
"""

import argparse
import sys
from pathlib import Path

from answers import Answer, read_answer
from entries import ENTRIES, timed
from made_problems import PROBLEMS, make
from open_scores import Score, score
from problem_folder import Problem, digest, problems
from results_page import page

HERE = Path(__file__).parent
FOLDER = HERE / "problems"


def main() -> None:
    """Make what is missing, run, score, and write the page."""
    given = arguments()
    chosen = [
        p for p in problems(FOLDER) if not given.problem or p.name in given.problem
    ]
    if given.checksum:
        print(digest(given.checksum))
        return
    if given.make:
        for name in given.problem or PROBLEMS:
            print(f"making {name}", flush=True)
            make(name, FOLDER / name)
        return
    table: dict[str, dict[str, Score]] = {}
    for problem in chosen:
        completed(problem)
        table[problem.name] = {}
        for name, answers in answered(problem, given).items():
            table[problem.name][name] = score(problem, answers)
            print(problem.name, name, *table[problem.name][name], flush=True)
    written = page(chosen, table)
    if given.out:
        given.out.write_text(written)
    else:
        print(written)


def arguments() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(prog="python benchmarks/open", description=__doc__)
    parser.add_argument("problem", nargs="*", help="names; all problems by default")
    parser.add_argument(
        "--recordings", type=int, help="only the first so many of each problem"
    )
    parser.add_argument("-o", dest="out", type=Path, help="write the page there")
    parser.add_argument(
        "--answers", type=Path, help="score these answers too: FOLDER/METHOD/PROBLEM"
    )
    parser.add_argument(
        "--checksum", type=Path, help="of a recording, for problem.json"
    )
    parser.add_argument(
        "--make", action="store_true", help="simulate anew, with truth and checksums"
    )
    return parser.parse_args()


def completed(problem: Problem) -> None:
    """Simulate the recordings if they are not there, and compare checksums.

    Raises:
        SystemExit: these are other recordings.
    """
    if problem.changed() and problem.name in PROBLEMS:
        kept = {p: p.read_bytes() for p in problem.folder.glob("*.json")}
        make(problem.name, problem.folder)
        for path, content in kept.items():
            path.write_bytes(content)
    changed = problem.changed()
    if changed and problem.name in PROBLEMS and problem.rounded_otherwise():
        print(f"{problem.name}: this machine rounds otherwise", file=sys.stderr)
    elif changed:
        raise SystemExit(
            f"{problem.name}: {', '.join(changed)}: missing, or not what the checksum "
            "is of"
        )


def answered(problem: Problem, given: argparse.Namespace) -> dict[str, list[Answer]]:
    """The answers of every method, to every recording."""
    recordings = dict(list(problem.recordings().items())[: given.recordings])
    momentum = problem.description["initial_momentum"]
    answers = {
        name: [timed(entry, problem.robot, x, momentum) for x in recordings.values()]
        for name, entry in ENTRIES.items()
    }
    for method in sorted(given.answers.iterdir()) if given.answers else ():
        files = (method / problem.name / f"{Path(x).stem}.json" for x in recordings)
        answers[method.name] = [read_answer(file) for file in files]
    return answers


if __name__ == "__main__":
    main()
