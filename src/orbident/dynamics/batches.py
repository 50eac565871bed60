"""One compiled size for any number of samples."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

BATCH = 1024
"""Samples evaluated at once: enough to be fast, little memory."""


def in_batches(function: Callable[..., Any], *columns: Any, size: int = BATCH) -> Any:
    """`function(*columns)`, batch by batch on all processors, joined again.

    The last batch is padded by repeating its last row, so that `function` is compiled
    once whatever the number of rows, and memory does not grow with it.

    Args:
        function: jitted; takes and returns arrays with `size` rows.
        columns: arrays, or trees of them, with the same number of rows.
        size: rows of a batch.
    """
    rows = len(jax.tree.leaves(columns)[0])
    x64 = jnp.result_type(float) == jnp.float64

    def batch(start: int) -> Any:
        chosen = np.minimum(np.arange(start, start + size), rows - 1)
        # Threads have not the precision of the one that started them.
        with jax.enable_x64(x64):
            part = function(*jax.tree.map(lambda column: column[chosen], columns))
        return jax.tree.map(lambda x: np.asarray(x)[: rows - start], part)

    # The first one compiles.
    parts = [batch(0)]
    if rows > size:
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            parts.extend(threads.map(batch, range(size, rows, size)))
    return jax.tree.map(lambda *pieces: np.concatenate(pieces), *parts)
