"""One compiled size for any number of samples."""

from collections.abc import Callable
from typing import Any

import jax
import numpy as np

BATCH = 1024
"""Samples evaluated at once: enough to be fast, little memory."""


def in_batches(function: Callable[..., Any], *columns: Any, size: int = BATCH) -> Any:
    """`function(*columns)`, batch by batch, joined again.

    The last batch is padded by repeating its last row, so that `function` is compiled
    once whatever the number of rows, and memory does not grow with it.

    Args:
        function: jitted; takes and returns arrays with `size` rows.
        columns: arrays, or trees of them, with the same number of rows.
        size: rows of a batch.
    """
    rows = len(jax.tree.leaves(columns)[0])
    parts = []
    for start in range(0, rows, size):
        chosen = np.minimum(np.arange(start, start + size), rows - 1)
        part = function(
            *jax.tree.map(lambda column, rows=chosen: column[rows], columns)
        )
        count = rows - start
        parts.append(jax.tree.map(lambda x, n=count: np.asarray(x)[:n], part))
    return jax.tree.map(lambda *pieces: np.concatenate(pieces), *parts)
