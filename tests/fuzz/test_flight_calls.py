"""Calls of the flight filter under libFuzzer, AddressSanitizer and UBSan.

ORBIDENT_FUZZED says how many inputs are tried; each takes a hundred samples, about.
"""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from flight_builds import exported, one_joint, ran
from processes import finished

CALLS = Path(__file__).with_name("flight_calls.cpp")
SANITIZERS = ("-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=undefined")


@pytest.mark.long
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.skipif(shutil.which("clang++") is None, reason="clang++ has libFuzzer")
def test_any_calls_give_no_nan_without_a_code(tmp_path: Path, scalar: str):
    folder = exported(tmp_path / "f", one_joint(tmp_path), 16.0, 10.0)
    out, paths = tmp_path / "calls", [f"-I{folder}", f"-I{folder / 'include'}"]
    flags = (
        "-std=c++17",
        "-O1",
        "-g",
        "-ffp-contract=off",
        f"-DORBIDENT_REAL={scalar}",
    )
    eigen = ("-isystem", folder / "eigen")
    ran("clang++", *flags, *SANITIZERS, *paths, *eigen, CALLS, "-o", out)
    seeds, random = tmp_path / "seeds", np.random.default_rng(1)
    seeds.mkdir()
    for k in range(64):
        (seeds / str(k)).write_bytes(random.bytes(512))
    inputs = os.environ.get("ORBIDENT_FUZZED", "10000")
    options = (f"-runs={inputs}", "-seed=1", "-max_len=512", "-len_control=0")
    place = f"-artifact_prefix={tmp_path}/"
    told = finished(out, seeds, *options, place, limit=36_000.0)
    assert told.returncode == 0, told.stderr[-4000:]
    print(scalar, told.stdout)
