"""Recordings that hold the same in other ways are identified equally well."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from running import LINEAR, Orbident, check_recovered, worst_error, written

from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording

IDENTIFY = ("identify", "paper-spatial", *LINEAR)

EXACT = 1e-9
SPLINE = 1e-6
"""What a cubic spline through 20 samples a second does to motions of 0.125 Hz."""

JOINTS = ("joint1", "joint2", "joint3")
MEASURED = "measured"
DERIVED = "derived: smoothed positions"


@pytest.fixture(scope="module")
def seen(flight: Recording) -> Recording:
    """What identification needs of the flight, and nothing more."""
    return Recording(
        flight.t,
        {
            name: column
            for name, column in flight.columns.items()
            if not name.startswith("position")
        },
    )


@pytest.fixture
def check(orbident: Orbident):
    """Identifies a recording of `paper-spatial`; compares with the nominal values."""
    true = orbident("inspect", "paper-spatial", "--json", "-").done().json

    def checked(path: object, tolerance: float) -> dict[str, Any]:
        ran = orbident(*IDENTIFY, path, "--json", "-")
        assert ran.status == 0
        result = ran.json
        # Splines leave residuals that are no noise, so deviations were widened.
        others = [w for w in result["warnings"] if "own deviations" not in w]
        check_recovered({**result, "warnings": others}, true, tolerance)
        return result

    return checked


def test_csv_and_parquet_give_the_same(check, seen: Recording):
    results = [
        check(written(seen, f"r.{suffix}"), EXACT) for suffix in ("csv", "parquet")
    ]
    for result in results:
        del result["elapsed_s"], result["input"]
    assert results[0] == results[1]


def test_columns_in_another_order(check, seen: Recording):
    path = written(seen, "r.csv")
    rows = [line.split(",") for line in path.read_text().splitlines()]
    order = np.random.default_rng(0).permutation(len(rows[0]))
    lines = [",".join(row[k] for k in order) for row in rows]
    assert not lines[0].startswith("t,")
    path.write_text("\n".join(lines) + "\n")
    check(path, EXACT)


def test_unknown_columns_are_ignored(check, seen: Recording):
    extra = {
        "temperature": np.full(seen.t.size, 293.0),
        "truth.w": np.full(seen.t.size, np.nan),
        "joint.count": np.zeros(seen.t.size),
    }
    check(written(seen, "r.csv", replace=extra), EXACT)


def test_windows_line_ends_blanks_and_blank_lines(check, seen: Recording):
    path = written(seen, "r.csv")
    text = path.read_text().replace(",", " , ").replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode() + b"\r\n\r\n")
    check(path, EXACT)


def test_integer_columns(check, seen: Recording):
    """As pandas writes them when every value is whole."""
    path = written(seen, "r.csv")
    assert ",200," in path.read_text()
    check(path, EXACT)


def test_derived_joint_rates(check, seen: Recording):
    drop = [f"joint.{joint}.velocity" for joint in JOINTS]
    result = check(written(seen, "r.csv", drop=drop), SPLINE)
    assert result["origins"]["joint_rates"] == DERIVED
    assert result["origins"]["wheel_speeds"] == MEASURED


def test_one_derived_joint_rate(check, seen: Recording):
    result = check(written(seen, "r.csv", drop=["joint.joint2.velocity"]), SPLINE)
    assert result["origins"]["joint_rates"] != MEASURED


def test_derived_velocity(check, flight: Recording):
    result = check(written(flight, "r.csv", drop=["velocity"]), SPLINE)
    assert result["origins"]["velocity"] == DERIVED


def test_wheel_angles(check, seen: Recording):
    angles = {
        f"wheel.rw_{k}.position": 0.3 + seen.columns[f"wheel.rw_{k}.speed"] * seen.t
        for k in "xyz"
    }
    path = written(seen, "r.csv", drop=["wheel.rw_"])
    columns = {
        name: column
        for name, column in seen.columns.items()
        if not name.startswith("wheel")
    }
    write_recording(Recording(seen.t, columns | angles), path)
    result = check(path, EXACT)
    assert result["origins"]["wheel_speeds"] == DERIVED


def test_gaps(check, seen: Recording):
    """Samples that lack something do not count; encoders' gaps are filled."""
    random = np.random.default_rng(0)
    holes = {}
    for name in ("gyro.x", "attitude.w", "velocity.z"):
        holes[name] = seen.columns[name].copy()
        holes[name][random.random(seen.t.size) < 0.2] = np.nan
    result = check(written(seen, "r.csv", replace=holes), EXACT)
    assert result["samples"] < seen.t.size

    holes = {"joint.joint1.position": seen.columns["joint.joint1.position"].copy()}
    holes["joint.joint1.position"][200:203] = np.nan
    result = check(written(seen, "r.csv", replace=holes), 10 * SPLINE)
    assert result["samples"] == seen.t.size


def test_sensors_with_their_own_rates(check, seen: Recording):
    slow = {}
    for prefix, every in (("gyro.", 2), ("velocity.", 5), ("attitude.", 1)):
        for name, column in seen.columns.items():
            if name.startswith(prefix):
                slow[name] = np.full(seen.t.size, np.nan)
                slow[name][::every] = column[::every]
    result = check(written(seen, "r.parquet", replace=slow), EXACT)
    assert result["samples"] == -(-seen.t.size // 2)


def test_slow_encoders(check, seen: Recording):
    slow = {}
    for name, column in seen.columns.items():
        if name.startswith(("joint", "wheel")):
            slow[name] = np.full(seen.t.size, np.nan)
            slow[name][::2] = column[::2]
    # Twice the spacing, 16 times the error of a cubic spline.
    result = check(written(seen, "r.csv", replace=slow), 16 * SPLINE)
    assert result["samples"] == seen.t.size


def test_encoders_that_begin_late(check, seen: Recording):
    late = {"joint.joint2.position": seen.columns["joint.joint2.position"].copy()}
    late["joint.joint2.position"][:20] = np.nan
    result = check(written(seen, "r.csv", replace=late), EXACT)
    assert result["samples"] == seen.t.size - 20


def test_time_may_start_anywhere_and_be_uneven(check, seen: Recording):
    kept = np.sort(np.random.default_rng(0).permutation(seen.t.size)[:500])
    columns = {name: column[kept] for name, column in seen.columns.items()}
    # Seconds since 1970, as ROS has them: 1e9 leaves 1e-7 s of resolution.
    path = Path("r.csv")
    write_recording(Recording(1.7e9 + seen.t[kept], columns), path)
    check(path, EXACT)


def test_quaternions_may_change_sign_and_be_rounded(check, seen: Recording):
    signs = np.where(np.arange(seen.t.size) % 7 < 3, -1.0, 1.0)
    turned = {f"attitude.{k}": signs * seen.columns[f"attitude.{k}"] for k in "xyzw"}
    check(written(seen, "r.csv", replace=turned), EXACT)


def test_quaternions_of_another_norm(check, seen: Recording):
    """Only their direction counts: a norm 0.5 % off is no other attitude."""
    longer = {f"attitude.{k}": 1.005 * seen.columns[f"attitude.{k}"] for k in "xyzw"}
    check(written(seen, "r.csv", replace=longer), EXACT)


def test_the_fewest_samples(orbident: Orbident, seen: Recording):
    """8 samples have 24 momentum equations for 22 unknowns."""
    true = orbident("inspect", "paper-spatial", "--json", "-").done().json
    path = written(seen, "r.csv", rows=slice(0, 800, 100))
    result = orbident(*IDENTIFY, path, "--json", "-").done().json
    # Hardly more equations than unknowns: the condition number costs digits.
    for name in ("pi", "phi"):
        assert worst_error(result[name], true[name]) < 1e-6


def test_batches_do_not_show(check, seen: Recording):
    """1024 samples are taken at once: more than one batch, and one of one sample."""
    t = np.concatenate([seen.t, 41.0 + seen.t[:224]])
    columns = {
        name: np.concatenate([column, column[:224]])
        for name, column in seen.columns.items()
    }
    write_recording(Recording(t, columns), Path("r.csv"))
    assert check("r.csv", EXACT)["samples"] == 1025


def test_a_recording_is_cut_as_if_its_rows_were(orbident: Orbident, seen: Recording):
    """Rows from 2 s to 30 s, both ends included, of 20 a second."""
    whole = written(seen, "whole.csv")
    part = written(seen, "part.csv", rows=slice(40, 601))
    cut = ("--from", "2", "--to", "30")
    results = [
        orbident(*IDENTIFY, *arguments, "--json", "-").done().json
        for arguments in ((part,), (whole, *cut))
    ]
    used = results[1]["input"]
    assert (used["from"], used["to"]) == (2.0, 30.0)
    for result in results:
        del result["elapsed_s"], result["input"]
    assert results[0] == results[1]
    orbident(*IDENTIFY, part, "-o", "run", "--quiet").done()
    scores = [
        orbident("validate", "run", *arguments, "--json", "-").done().json
        for arguments in ((part,), (whole, *cut))
    ]
    assert scores[0] == scores[1]


def test_ends_of_a_cut_are_checked(orbident: Orbident, seen: Recording):
    path = written(seen, "r.csv")
    orbident(*IDENTIFY, path, "--from", "8", "--to", "8").refused("--from 8", "--to 8")
    orbident(*IDENTIFY, path, "--from", "900").refused("has 0 rows from 900 s on;")
