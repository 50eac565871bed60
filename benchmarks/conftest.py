"""What every benchmark runs under: the models of the oracle tests."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "tests" / "oracles"))


@pytest.fixture(scope="module")
def medians() -> dict[str, float]:
    """Median seconds of what this file has timed so far, for the ratios."""
    return {}


@pytest.fixture
def record(benchmark, medians):
    """Keep a timing for the ratios of this file, and say how good the solution is."""

    def keep(name: str, **quality: object) -> float:
        medians[name] = benchmark.stats.stats.median
        benchmark.extra_info.update(quality)
        return medians[name]

    return keep
