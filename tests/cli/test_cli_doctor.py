"""`orbident doctor`: what is installed, and whether it works."""

import dataclasses
from importlib.metadata import version

import numpy as np
import pytest
from running import Orbident

from orbident.studies import spatial


def test_all_is_well(orbident: Orbident):
    ran = orbident("doctor", "--json", "-").done().json
    assert ran["orbident"] == version("orbident")
    assert ran["libraries"]["numpy"] == np.__version__
    assert set(ran["extras"]) >= {"export", "hdf5", "report", "ros", "ulog", "view"}
    assert all(ran["extras"].values())
    assert ran["self_test"]["error"] < 1e-9
    assert ran["problems"] == []


def test_what_is_said(orbident: Orbident, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "orbident.cli.doctor._installed",
        lambda name: None if name in {"h5py", "rosbags"} else "1.0",
    )
    out = orbident("doctor").done().out
    assert "compiler: not needed" in out
    assert 'extra hdf5: not installed: pip install "orbident[hdf5]"' in out
    assert "extra ulog: pyulog 1.0" in out
    assert "parameters of 'paper-spatial' in" in out


def test_a_wrong_result(orbident: Orbident, monkeypatch: pytest.MonkeyPatch):
    found = spatial.SelfTest("paper-spatial", 15, 0.02, 2.0)
    monkeypatch.setattr(spatial, "self_test", lambda: found)
    ran = orbident("doctor")
    assert ran.status == 1
    assert "largest error 0.02, but at most 1e-06 is right; install again" in ran.err
    assert ran.err.count("\n") == 1
    nothing = dataclasses.replace(found, error=float("nan"))
    assert not nothing.passed


def test_a_broken_library(orbident: Orbident, monkeypatch: pytest.MonkeyPatch):
    def broken() -> None:
        raise OSError("libstdc++.so.6: no such\nfile")

    monkeypatch.setattr(spatial, "self_test", broken)
    monkeypatch.setattr(
        "orbident.cli.doctor._installed",
        lambda name: None if name == "pyarrow" else "1.0",
    )
    ran = orbident("doctor", "--json", "-")
    assert ran.status == 1
    assert ran.err.splitlines() == [
        "orbident: warning: the self-test ended with OSError: libstdc++.so.6: no such "
        "file",
        'orbident: warning: pyarrow is not installed: pip install "pyarrow"',
    ]
    assert ran.json["self_test"] is None
