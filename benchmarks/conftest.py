"""How every benchmark is timed and judged."""

import pytest


@pytest.fixture(scope="module")
def medians() -> dict[str, float]:
    """Median seconds of what this file has timed so far, for the ratios."""
    return {}


@pytest.fixture(scope="module")
def once(pytestconfig) -> bool:
    """Whether all only runs, and is neither timed nor judged: `--benchmark-disable`."""
    return pytestconfig.getoption("--benchmark-disable")


@pytest.fixture
def meets(once):
    """Fail where a bar is missed."""

    def judge(met: bool) -> None:
        assert once or met

    return judge


@pytest.fixture
def record(benchmark, medians, once):
    """Keep a timing for the ratios of this file, and say how good the solution is."""

    def keep(name: str, **quality: object) -> float:
        medians[name] = float("nan") if once else benchmark.stats.stats.median
        benchmark.extra_info.update(quality)
        return medians[name]

    return keep
