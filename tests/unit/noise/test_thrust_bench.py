"""Thrust on a load cell: pulses of first order, whose rise has a closed form."""

from pathlib import Path

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.noise.thrust_bench import thrust_on_bench, thruster_section

GRAM = 9.80665e-3
"""N."""

T = np.arange(2000) * 0.02
ON = (T % 8.0 >= 2.0) & (T % 8.0 < 5.0)
LATE, TAU = 0.06, 0.2


def shown(scatter: float = 0.0) -> np.ndarray:
    """`u' = (F - u) / tau` behind a delay, N; five pulses, on a tare that is off."""
    random = np.random.default_rng(1)
    start = 2.0 + 8.0 * np.floor(T / 8.0)
    F = 0.45 * (1 + scatter * random.standard_normal(5))[np.floor(T / 8.0).astype(int)]
    up = 1 - np.exp(-np.clip(T - start - LATE, 0, None) / TAU)
    down = np.exp(-np.clip(T - start - 3.0 - LATE, 0, None) / TAU)
    return 0.03 + F * up * down


def table(path: Path, head: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack(columns), "%.9g", ",", header=head, comments="")
    return path


@pytest.mark.parametrize(
    ("head", "unit"), [("t_s,weight_g,bitmask", GRAM), ("t,force [N],command", 1.0)]
)
def test_pulses_of_first_order(tmp_path, head, unit):
    file = table(tmp_path / "t1.csv", head, T, shown() / unit, 4.0 * ON)
    found = thrust_on_bench(file)
    assert (found.name, found.pulses) == ("t1", 5)
    assert found.thrust == pytest.approx(0.45, rel=1e-3)
    assert found.scatter < 1e-6
    # Within a sample, as every time is that of one.
    assert found.late == pytest.approx(LATE + TAU * np.log(10 / 9), abs=0.02)
    assert found.rise == pytest.approx(TAU * np.log(9), abs=0.02)
    assert found.decay == pytest.approx(TAU * np.log(9), abs=0.02)
    assert thruster_section([found])[0]["thrust"] == pytest.approx(0.45, rel=1e-3)


def test_pulses_scatter(tmp_path):
    file = table(tmp_path / "t.csv", "t,force_N,duty", T, shown(0.02), ON)
    random = np.random.default_rng(1).standard_normal(5)
    assert thrust_on_bench(file).scatter == pytest.approx(
        0.02 * random.std(ddof=1), rel=0.1
    )


@pytest.mark.parametrize(
    ("head", "command", "words"),
    [
        ("t,force_N,phase", ON, "no column is the command"),
        ("t,force,command", ON, "does not say its unit"),
        ("t,force_N,command", ON * (1 + (T > 8)), "as if several thrusters fired"),
        ("t,force_N,command", ON & (T < 16), "has 2 whole pulses"),
        ("t,force_N,command", (T % 0.8) > 0.4, "no settled thrust|no push"),
        ("force_N,t,command", ON, "'t' does not grow"),
    ],
)
def test_refused_in_one_line(tmp_path, head, command, words):
    file = table(tmp_path / "t.csv", head, T, shown(), command)
    with pytest.raises(InputError, match=words) as refused:
        thrust_on_bench(file)
    assert "\n" not in str(refused.value)


def test_files_that_are_no_tables(tmp_path):
    for name in ("t.csv", "t.csv.gz", "t.png"):
        with pytest.raises(InputError, match=r"does not exist|is packed"):
            thrust_on_bench(tmp_path / name)
