from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from scipy import stats

from orbident.campaigns.statistics import method_statistics

N = 200


def table(seed: int = 0) -> pa.Table:
    """Errors of M that are normal, of sigma_1 that grow with what was drawn."""
    random = np.random.default_rng(seed)
    drawn, other = random.standard_normal((2, N))
    M, sigma = random.standard_normal((2, N))
    sigma += 3 * drawn
    level = np.where(np.arange(N) % 10 == 0, "do not trust", "trust")
    refused = level == "do not trust"
    columns = {
        "run": np.arange(N),
        "robot": np.full(N, "a"),
        "method": np.full(N, "structured"),
        "level": level,
        "refused_by": ["kinetic energy" if each else None for each in refused],
        "draw.x": drawn,
        "draw.y": other,
    }
    for name, z, std in (("M", M, 2.0), ("sigma_1", sigma, 0.5)):
        columns[f"{name}.value"] = np.where(refused, np.nan, 7.0 + std * z)
        columns[f"{name}.std"] = np.full(N, std)
        columns[f"{name}.true"] = np.full(N, 7.0)
    columns["iota_1.value"] = columns["iota_1.std"] = np.full(N, np.nan)
    columns["iota_1.true"] = np.ones(N)
    return pa.table({k: pa.array(x, from_pandas=True) for k, x in columns.items()})


def test_errors_and_coverage():
    (group,) = method_statistics(table())
    assert group.accepted.num_rows == N - N // 10
    M, sigma = group.parameters
    assert (M.name, sigma.name) == ("M", "sigma_1")
    np.testing.assert_allclose(M.error, 2 * M.z)
    mean, std = M.bias
    assert abs(mean) < 4 * std
    np.testing.assert_allclose(std, M.error.std(ddof=1) / np.sqrt(M.z.size))
    np.testing.assert_allclose(M.rms**2, np.mean(M.error**2))
    # Clopper and Pearson's interval by the beta distribution.
    low, high = M.coverage()
    k, n = M.covered, M.z.size
    np.testing.assert_allclose(low, stats.beta.ppf(0.025, k, n - k + 1))
    np.testing.assert_allclose(high, stats.beta.ppf(0.975, k + 1, n - k))
    assert low < 0.95 < high
    assert sigma.coverage()[1] < 0.95


def test_the_worst_and_what_errors_depend_on():
    (group,) = method_statistics(table())
    worst = group.worst(5)
    assert [abs(z) for *_, z in worst] == sorted((abs(z) for *_, z in worst))[::-1]
    assert worst[0][1] == "sigma_1"
    assert all(run % 10 for run, *_ in worst)

    first, *others = group.dependences(8)
    assert (first.draw, first.parameter, first.of_size) == ("x", "sigma_1", False)
    reference: Any = stats.spearmanr(first.x, first.y)
    np.testing.assert_allclose(first.rho, reference.statistic)
    # Eight pairs: two draws, two parameters, errors and their sizes.
    np.testing.assert_allclose(first.chance, 8 * reference.pvalue, rtol=1e-9)
    assert all(each.chance > 1e-3 for each in others)


def test_nothing_accepted():
    refused = table().filter(pc.field("level") == "do not trust")
    (group,) = method_statistics(refused)
    assert group.parameters == ()
    assert group.worst(3) == group.dependences(3) == []
