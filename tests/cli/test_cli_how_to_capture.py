"""The how-to page on captures, from end to end: noise, 50 kg, maximum likelihood."""

import numpy as np
from readers_files import TARGET, capture
from running import Orbident


def test_what_was_captured_is_found(orbident: Orbident):
    capture()
    assert (
        orbident("identify", "servicer.yaml", "before.parquet", "-o", "before").status
        == 0
    )
    assert (
        orbident("identify", "holding.yaml", "after.parquet", "-o", "after").status == 0
    )
    added = orbident("compare", "before", "after", "--json", "-").done().json["added"]
    mass = added["mass"]
    assert abs(mass["value"] - 50.0) < 3 * mass["std"]
    # Some grams: moments show it, better than the total mass does.
    assert mass["std"] < 0.05
    C, theta = (
        np.array(added["theta"]["covariance"]),
        np.array(added["theta"]["values"]),
    )
    error = theta - TARGET
    # Chi-square with 10 degrees of freedom: more than this once in 10000.
    assert error @ np.linalg.solve(C, error) < 35.6
