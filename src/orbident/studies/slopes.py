"""The mass as the paper has it: Eq. 40 from the slopes of one axis of a position."""

import numpy as np

from orbident.recordings.recording import Recording
from orbident.studies import paper_tables

STRETCH = 1.0
"""s before and after the burn over which a slope is taken."""


def mass_by_slopes(burn: Recording) -> float:
    """`M = F dt / (v_2 - v_1)` along y (Eq. 40), kg.

    Args:
        burn: Section 5.5's, attitude held; position of S, m.
    """
    t, y = burn.t, burn.column("position.y")
    on, off = paper_tables.BURN_START, paper_tables.BURN_START + paper_tables.BURN_LASTS
    before = (t >= on - STRETCH) & (t <= on)
    after = (t >= off) & (t <= off + STRETCH)
    v_1, v_2 = (float(np.polyfit(t[part], y[part], 1)[0]) for part in (before, after))
    return paper_tables.BURN_FORCE[1] * paper_tables.BURN_LASTS / (v_2 - v_1)
