"""`python tests/mistakes`: what every method makes of recordings with a mistake."""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from campaign_of_mistakes import all_rows
from mistakes import MISTAKES, REAL_EFFECTS
from table import Count, markdown, totals

from orbident.estimation.identify import METHODS


def main() -> int:
    """Run them; 1 where a method accepted what is wrong and could be seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--out", type=Path, help="file for the table, Markdown")
    parser.add_argument("names", nargs="*", help="mistakes; all by default")
    parser.add_argument(
        "--real-effects", action="store_true", help="what real ones do, in MuJoCo"
    )
    given = parser.parse_args()
    rows = all_rows(
        given.workers,
        given.names,
        lambda words: print(words, file=sys.stderr),
        REAL_EFFECTS if given.real_effects else MISTAKES,
    )
    if given.out:
        given.out.write_text(markdown(rows), encoding="utf-8")
        print(totals(rows))
    else:
        print(markdown(rows))
    return 1 if any(Count(rows, method).wrong for method in METHODS) else 0


if __name__ == "__main__":
    sys.exit(main())
