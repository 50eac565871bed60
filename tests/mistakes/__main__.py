"""`python tests/mistakes`: what every method makes of recordings with a mistake."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from campaign_of_mistakes import all_rows, arguments
from table import Count, markdown, totals

from orbident.estimation.identify import METHODS


def main() -> int:
    """Run them; 1 where a method accepted what is wrong and could be seen."""
    given = arguments(__doc__)
    rows = all_rows(
        given.workers,
        given.names,
        lambda words: print(words, file=sys.stderr),
        given.of,
        given.usual_tolerances,
    )
    if given.out:
        given.out.write_text(markdown(rows), encoding="utf-8")
        print(totals(rows))
    else:
        print(markdown(rows))
    return 1 if any(Count(rows, method).wrong for method in METHODS) else 0


if __name__ == "__main__":
    sys.exit(main())
