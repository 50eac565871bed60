"""`python tests/mistakes/clean.py`: recordings without a mistake, by every method.

With `--acting` all that may act in the robot's world does; with `--instruments` these
are off, as usual. How many are refused, and how often the 95 % intervals hold what is
true. The seconds of the first method include the fit of the sensors by which the others
are judged too.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
from random_flights import SEEDS, Known, flight, flights, flyers, recorded
from recordings import Clean
from remembered_fits import fits_remembered
from table import lines

import orbident as oi
from orbident.estimation.identify import METHODS, Method

INTERVAL = 1.959964
"""Deviations to either side: 95 % of a normal distribution."""


@dataclass
class Runs:
    """What came of the runs of one method, on one robot or on several."""

    z: list[float] = field(default_factory=list)
    """Errors of the base parameters over their deviations, all runs in a row."""
    z_mass: list[float] = field(default_factory=list)
    unknown: int = 0
    """Base parameters that are not determined."""
    accepted: int = 0
    cautioned: int = 0
    """Accepted with a warning."""
    reasons: Counter[str] = field(default_factory=Counter)
    """Why others are refused: the first words of the first reason."""
    seconds: float = 0.0

    @property
    def refused(self) -> int:
        return self.reasons.total()

    @property
    def runs(self) -> int:
        return self.accepted + self.refused

    def add(self, other: "Runs") -> None:
        """Pool."""
        self.z += other.z
        self.z_mass += other.z_mass
        self.unknown += other.unknown
        self.accepted += other.accepted
        self.cautioned += other.cautioned
        self.reasons += other.reasons
        self.seconds += other.seconds

    def take(self, clean: Clean, known: Known, method: Method) -> None:
        """Identify one recording."""
        started = time.perf_counter()
        robot, recording = known
        reason = ""
        try:
            result = oi.identify(
                robot, recording, method, initial_momentum=clean.initial_momentum
            )
        except oi.InputError as error:
            result, reason = None, str(error)
        self.seconds += time.perf_counter() - started
        if result is None or result.status == "rejected":
            reason = reason or next(iter(result.warnings if result else ()), "none")
            self.reasons[" ".join(reason.split()[:12])] += 1
            return
        self.accepted += 1
        self.cautioned += bool(result.warnings)
        beta = oi.minimal_sets(robot).beta(clean.robot.theta)
        z = (result.base.values - beta) / result.base.std
        determined = np.isfinite(result.base.values)
        self.unknown += int(np.count_nonzero(~determined))
        self.z += z[determined].tolist()
        self.z_mass.append((result.mass.value - beta[0]) / result.mass.std)


def coverage(z: Sequence[float]) -> float:
    """The part within the interval; NaN where there is none."""
    return float(np.mean(np.abs(z) <= INTERVAL)) if z else float("nan")


ByMethod = dict[Method, Runs]


def of_robot(
    name: str, seeds: int = SEEDS, acting: bool = False, instruments: bool = False
) -> ByMethod:
    """All recordings of one robot."""
    done: ByMethod = {method: Runs() for method in METHODS}
    for seed in range(seeds):
        known = recorded(flight(name), seed, acting=acting, instruments=instruments)
        with fits_remembered():
            for method in METHODS:
                done[method].take(flight(name), known, method)
    return done


def of_robots(
    names: Sequence[str],
    workers: int,
    seeds: int = SEEDS,
    acting: bool = False,
    instruments: bool = False,
    progress: Callable[[str], object] = str,
) -> dict[str, ByMethod]:
    """The runs of every method, grouped by robot."""
    found: dict[str, ByMethod] = {}
    # A fresh interpreter: threads of the core do not survive a fork.
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        options = (repeat(each) for each in (seeds, acting, instruments))
        for name, runs in zip(names, pool.map(of_robot, names, *options), strict=True):
            found[name] = runs
            progress(f"{len(found)}/{len(names)} {name}")
    return found


def pooled(found: dict[str, ByMethod], method: Method) -> Runs:
    """The runs of one method on all robots together."""
    total = Runs()
    for by_method in found.values():
        total.add(by_method[method])
    return total


def markdown(found: dict[str, ByMethod]) -> str:
    """Totals, each robot, and why good recordings are refused."""
    header = ("method", "runs", "refused", "accepted with a warning", "95 %, base",
              "95 %, M", "worst", "not determined", "seconds")  # fmt: skip
    body = [_totals(method, pooled(found, method)) for method in METHODS]
    robots = [
        [name, *(_cell(by_method[method]) for method in METHODS)]
        for name, by_method in found.items()
    ]
    reasons = [
        [method, name, str(count), words.replace("|", "/")]
        for name, by_method in found.items()
        for method, runs in by_method.items()
        for words, count in runs.reasons.most_common()
    ]
    return "\n\n".join(
        [
            lines(header, body),
            "Refused of all, and the part of the base parameters within 95 %:",
            lines(("robot", *METHODS), robots),
            lines(("method", "robot", "refused", "first reason"), reasons),
        ]
    )


def _totals(method: Method, runs: Runs) -> list[str]:
    worst = np.abs(runs.z).max(initial=0.0)
    refused = f"{runs.refused} ({runs.refused / max(runs.runs, 1):.1%})"
    return [method, str(runs.runs), refused, str(runs.cautioned),
            f"{coverage(runs.z):.1%}", f"{coverage(runs.z_mass):.1%}", f"{worst:.1f}",
            str(runs.unknown), f"{runs.seconds:.0f}"]  # fmt: skip


def _cell(runs: Runs) -> str:
    return f"{runs.refused}/{runs.runs}, {coverage(runs.z):.1%}"


def main() -> int:
    """Run them and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="of each robot")
    parser.add_argument("--acting", action="store_true", help="what may act does")
    parser.add_argument("--instruments", action="store_true", help="they are off")
    parser.add_argument("--out", type=Path, help="file for the tables, Markdown")
    given = parser.parse_args()
    parts = []
    for title, names in (("Random robots", flights()), ("Free-flyer", flyers())):
        found = of_robots(
            [*names],
            given.workers,
            given.seeds,
            given.acting,
            given.instruments,
            lambda words: print(words, file=sys.stderr),
        )
        parts.append(f"{title}\n\n{markdown(found)}\n")
    text = "\n".join(parts)
    if given.out:
        given.out.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
