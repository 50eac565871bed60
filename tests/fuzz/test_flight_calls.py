"""Calls of the flight filter under libFuzzer, AddressSanitizer and UBSan.

ORBIDENT_FUZZED says how many inputs are tried; each is some ten to a hundred calls.
"""

import os
import shutil
from pathlib import Path

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
    inputs = os.environ.get("ORBIDENT_FUZZED", "20000")
    options = (f"-runs={inputs}", "-seed=1", "-max_len=512", "-len_control=0")
    told = finished(out, *options, f"-artifact_prefix={tmp_path}/", limit=36_000.0)
    assert told.returncode == 0, told.stderr[-4000:]
    print(scalar, told.stdout)
