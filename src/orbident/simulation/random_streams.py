"""Random numbers: one seed, and a stream of its own for whatever has a name."""

import numpy as np

from orbident.errors import InputError


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one sensor.

    A child of `SeedSequence(seed)` whose spawn key is the name, so that a sensor that
    is added, removed or changed leaves every other one's numbers as they were.

    Args:
        seed: of the whole recording, zero or more.
        name: of the sensor.

    Raises:
        InputError: the seed is not a whole number of zero or more.
    """
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"seed {seed!r}: give a whole number of zero or more")
    children = np.random.SeedSequence(int(seed), spawn_key=tuple(name.encode()))
    return np.random.default_rng(children)
