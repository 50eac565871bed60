"""A run of many cases, and the table of what came of them."""

import itertools
import queue
import sys
import tempfile
import threading
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from case import Case
from extremes import extremes
from groups import GROUPS, Group, identify
from oracle import fault, signature
from seeds import Seeds, made
from shrinking import shrunk
from watcher import Outcome, Watcher

KEPT = 3
"""Cases that are kept of faults with one signature; the first of them is shrunk."""
REPORTED = 1000
"""Cases from one word about the progress to the next."""
MEGABYTE = 1024**2


@dataclass
class Tally:
    """What came of the cases of a group."""

    statuses: Counter[int] = field(default_factory=Counter)
    faults: int = 0
    seconds: float = 0.0
    peak: int = 0

    def add(self, outcome: Outcome, wrong: bool) -> None:
        """One case more."""
        self.statuses[outcome.status] += 1
        self.faults += wrong
        self.seconds = max(self.seconds, outcome.seconds)
        self.peak = max(self.peak, outcome.peak)


@dataclass
class Summary:
    """What came of all cases."""

    groups: dict[str, Tally] = field(default_factory=lambda: defaultdict(Tally))
    faults: Counter[str] = field(default_factory=Counter)
    """How often, by signature."""

    @property
    def cases(self) -> int:
        """So many have been run."""
        return sum(tally.statuses.total() for tally in self.groups.values())

    def table(self) -> str:
        """A table for people: a line for each group, and one for each kind of fault."""
        lines = [
            f"{'group':<14}{'cases':>7}{'status 0':>10}{'1':>7}{'2':>7}{'other':>7}"
            f"{'faults':>8}{'worst s':>9}{'worst MB':>10}"
        ]
        for name, tally in sorted(self.groups.items()):
            counts = [tally.statuses[status] for status in (0, 1, 2)]
            other = tally.statuses.total() - sum(counts)
            lines.append(
                f"{name:<14}{tally.statuses.total():>7}{counts[0]:>10}{counts[1]:>7}"
                f"{counts[2]:>7}{other:>7}{tally.faults:>8}{tally.seconds:>9.1f}"
                f"{tally.peak / MEGABYTE:>10.0f}"
            )
        lines += [f"{count:>7} {name}" for name, count in self.faults.most_common()]
        return "\n".join(lines)


class Campaign:
    """Runs cases by some workers, and keeps those that fail."""

    def __init__(self, folder: Path, workers: int = 2):
        """Nothing is run yet.

        Args:
            folder: for the cases that fail.
            workers: processes at a time.
        """
        self._folder, self._workers = folder, workers
        self._lock = threading.Lock()
        self.summary = Summary()

    def run(
        self,
        count: int,
        identified: int,
        seed: int,
        absurd: bool,
        weights: Mapping[Group, int] = GROUPS,
    ) -> Summary:
        """Cases from a seed: the same ones each time.

        Args:
            count: of all cases but the absurd ones.
            identified: how many of them go through `identify` with all methods.
            seed: of the cases.
            absurd: whether those of absurd size are run too.
            weights: how often each group is run.
        """
        with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
            watchers = [Watcher() for _ in range(self._workers)]
            free: queue.Queue[Watcher] = queue.Queue()
            for watcher in watchers:
                free.put(watcher)
            seeds = made(watchers[0], Path(place))
            cases = _cases(seeds, count, identified, seed, weights)
            if absurd:
                cases = itertools.chain(extremes(seeds), cases)

            def run(case: Case) -> None:
                watcher = free.get()
                try:
                    self._run(watcher, case)
                finally:
                    free.put(watcher)

            try:
                with ThreadPoolExecutor(self._workers) as pool:
                    for _ in _a_few_at_a_time(pool, run, cases, 4 * self._workers):
                        pass
            finally:
                for watcher in watchers:
                    watcher.close()
        return self.summary

    def _run(self, watcher: Watcher, case: Case) -> None:
        outcome = watcher.run(case)
        wrong = fault(case, outcome)
        if wrong:
            # What only shows after other cases is told apart.
            outcome = watcher.run(case, fresh=True)
            wrong = fault(case, outcome) or f"only after other cases: {wrong}"
        with self._lock:
            self.summary.groups[case.group].add(outcome, wrong is not None)
            if self.summary.cases % REPORTED == 0:
                print(f"{self.summary.cases} cases", file=sys.stderr)
            if wrong is None:
                return
            kind = signature(wrong)
            self.summary.faults[kind] += 1
            number, kinds = self.summary.faults[kind], len(self.summary.faults)
            place = self._folder / f"{kinds:03}-{number}-{_slug(kind)}"
        if number > KEPT:
            return
        if number == 1 and not wrong.startswith("only after"):
            case = shrunk(case, lambda each: self._fails(watcher, each, kind))
        case.store(place)
        (place / "fault.txt").write_text(f"{wrong}\n", errors="backslashreplace")
        print(f"{place}: {wrong[:200]}", file=sys.stderr)

    def _fails(self, watcher: Watcher, case: Case, kind: str) -> bool:
        wrong = fault(case, watcher.run(case))
        return wrong is not None and signature(wrong) == kind


def _slug(text: str) -> str:
    kept = "".join(letter if letter.isalnum() else "-" for letter in text)
    return "-".join(part for part in kept.split("-") if part)[:60]


def _cases(
    seeds: Seeds,
    count: int,
    identified: int,
    seed: int,
    weights: Mapping[Group, int],
) -> Iterator[Case]:
    random = Random(seed)
    groups: list[Group] = [identify] * identified
    groups += random.choices(
        list(weights), list(weights.values()), k=count - identified
    )
    random.shuffle(groups)
    for number, group in enumerate(groups):
        # A case does not depend on those before it.
        yield group(Random(f"{seed}-{number}"), seeds)


def _a_few_at_a_time(pool, run, cases: Iterator[Case], most: int) -> Iterator[None]:
    """Results in order; cases are made when they are soon to be run."""
    waiting = [pool.submit(run, case) for case in itertools.islice(cases, most)]
    while waiting:
        yield waiting.pop(0).result()
        waiting += [pool.submit(run, case) for case in itertools.islice(cases, 1)]
