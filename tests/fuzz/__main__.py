"""`python tests/fuzz`: give the command what nobody should, and see what it does."""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from campaign import Campaign
from case import stored
from groups import GROUPS
from oracle import fault
from watcher import Watcher

BY_NAME = {group.__name__: group for group in GROUPS}


def main() -> int:
    """Run what the arguments say; 1 where any case failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=1000, help="how many")
    parser.add_argument(
        "--identify", type=int, default=100, help="of them through all methods"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the cases")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument(
        "--group", choices=list(BY_NAME), help="cases of one group alone"
    )
    parser.add_argument(
        "--absurd", action="store_true", help="also inputs of absurd size"
    )
    parser.add_argument(
        "--failures", type=Path, default=Path("build/fuzz"), help="folder for them"
    )
    parser.add_argument("--again", type=Path, help="run one of them again")
    given = parser.parse_args()
    if given.again:
        return _again(given.again)
    campaign = Campaign(given.failures, given.workers)
    identified, weights = given.identify, GROUPS
    if given.group:
        identified, weights = 0, {BY_NAME[given.group]: 1}
    try:
        campaign.run(given.cases, identified, given.seed, given.absurd, weights)
    finally:
        # After Ctrl-C too: what has been run until then.
        print(campaign.summary.table())
    return 1 if campaign.summary.faults else 0


def _again(folder: Path) -> int:
    case = stored(folder)
    with Watcher({"ORBIDENT_TRACEBACK": "1"}) as watcher:
        outcome = watcher.run(case)
    print(*case.arguments)
    print(outcome.out, outcome.err, sep="\n")
    wrong = fault(case, outcome)
    print(wrong or f"status {outcome.status}: nothing is wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
