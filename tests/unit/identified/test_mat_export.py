"""A MATLAB file has what the result has, as SciPy reads it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import report_runs
from scipy.io import loadmat

from orbident.errors import InputError
from orbident.identified.parameter_files import field_names, write_mat


def test_round_trip(tmp_path: Path):
    result = report_runs.result()
    write_mat(result, tmp_path / "run.mat")
    read = loadmat(tmp_path / "run.mat", simplify_cells=True)
    # One name: a variable `pi` would hide MATLAB's own.
    assert [name for name in read if not name.startswith("__")] == ["identified"]
    found = read["identified"]
    assert found["robot"] == "paper-spatial"
    assert found["method"] == "least-squares"
    assert found["level"] == result.level
    assert (found["mass"]["value"], found["mass"]["std"]) == (
        result.mass.value,
        result.mass.std,
    )
    for name in ("base", "phi", "pi"):
        own = getattr(result, name)
        for key in ("values", "std", "nominal"):
            np.testing.assert_array_equal(found[name][key], getattr(own, key))
        for key in ("names", "formulas", "units"):
            assert tuple(found[name][key]) == tuple(getattr(own, key))
    np.testing.assert_array_equal(found["base"]["covariance"], result.base_covariance)
    np.testing.assert_array_equal(found["covariance_of_pi_and_phi"], result.covariance)
    assert list(found["signals"]) == [signal.name for signal in result.signals()]
    for signal in result.signals():
        read = found["signals"][signal.name]
        for key in ("t", "measured", "predicted", "std"):
            np.testing.assert_array_equal(read[key], getattr(signal, key))
        assert tuple(read["axes"]) == signal.axes


def test_what_is_not_determined_is_nan(tmp_path: Path):
    result = report_runs.result()
    values = result.pi.values.copy()
    values[1] = np.nan
    lost = replace(result, pi=replace(result.pi, values=values))
    write_mat(lost, tmp_path / "run.mat")
    found = loadmat(tmp_path / "run.mat", simplify_cells=True)["identified"]
    np.testing.assert_array_equal(found["pi"]["values"], values)


def test_a_rejected_result_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="is refused"):
        write_mat(report_runs.rejected(), tmp_path / "run.mat")
    assert not list(tmp_path.iterdir())


def test_names_of_fields():
    names = ["second flight: gyro", "gyro", "gyro", "2nd", "a" * 70, "a" * 80, "°"]
    found = field_names(names)
    assert found[:4] == ["second_flight_gyro", "gyro", "gyro_3", "signal_2nd"]
    assert found[4] == "a" * 63
    assert len(set(found)) == len(found)
    assert all(len(name) <= 63 for name in found)
