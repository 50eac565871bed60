"""A recording in stretches gives what it gives in memory.

Both take what the whole decides from the same digest; the rest is local, up to what
smoothers forget (`preprocessing/smoothing.py`) and rounding: 1e-9 of a deviation.
Recordings are long here from 5,120 rows on, which takes less time.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbident.estimation.identify import identify
from orbident.estimation.least_squares import LeastSquares, Structured
from orbident.estimation.linear_fits import Fits, fit
from orbident.estimation.momentum_problem import MomentumProblem, digest_of, whole
from orbident.estimation.solve import solve
from orbident.preprocessing.delays import Delay
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.screening import screened
from orbident.preprocessing.smoothing import LONGEST, Settings
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording
from orbident.robot.description import Robot
from orbident.simulation.simulate import simulate
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

SPAN = 2**10
ROWS = 5 * SPAN + 3000
STD = {"joint": 1e-4, "wheel": 0.01, "gyro": 1e-4, "velocity": 1e-3, "attitude": 2e-4}
SAME = 1e-9
"""Deviations."""


@pytest.fixture(scope="module", autouse=True)
def _small() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("orbident.recordings.long_recording.SPAN", SPAN)
        for user in ("orbident.recordings.tables", "orbident.estimation.identify"):
            patch.setattr(f"{user}.LARGE", 5 * SPAN)
        yield


@pytest.fixture(scope="module")
def robot() -> Robot:
    return spatial_robot()


@pytest.fixture(scope="module")
def recording(robot: Robot) -> Recording:
    """A recording with noise, gaps, and a spike."""
    clean = noisy(again(robot), 1.0)
    columns = {name: x.copy() for name, x in clean.columns.items()}
    columns["joint.joint1.position"][5::7] = np.nan
    columns["wheel.rw_x.speed"][::2] = np.nan
    columns["joint.joint2.position"][4000] += 1.0
    return Recording(clean.t, columns, "long")


def noisy(clean: Recording, factor: float) -> Recording:
    """The recording with white noise on all sensors but those left out here."""
    random, columns = np.random.default_rng(0), {}
    for name, x in clean.columns.items():
        if name.endswith(".velocity") or name.startswith("position"):
            continue
        noise = STD[name.split(".")[0]] * random.standard_normal(ROWS)
        columns[name] = x + factor * noise
    return replace(clean, columns=columns)


def again(robot: Robot) -> Recording:
    """A flight without noise, again and again, with pauses."""
    flight = simulate(robot, spatial_trajectory(robot), rate=50.0)
    rows = np.arange(ROWS)
    t = flight.t[rows % flight.t.size] + 81.0 * (rows // flight.t.size)
    columns = {name: np.resize(x, ROWS) for name, x in flight.columns.items()}
    return Recording(t, columns, "long")


def in_stretches(robot: Robot, recording: Recording, size: int) -> MomentumProblem:
    long = LongRecording.of(recording)
    found = digest_of(robot, long, "unknown")
    assert found is not None
    return whole(found, long, True, lambda _: None, size)


@pytest.fixture(scope="module")
def problem(robot: Robot, recording: Recording) -> MomentumProblem:
    return in_stretches(robot, recording, 2**11)


def assert_same(found: Fits, wanted: Fits) -> None:
    assert found.samples == wanted.samples
    for one, other in ((found.pi, wanted.pi), (found.phi, wanted.phi)):
        std = np.sqrt(np.diag(other.covariance))
        assert np.max(np.abs(one.values - other.values) / std) < SAME
        np.testing.assert_allclose(np.sqrt(np.diag(one.covariance)), std, rtol=SAME)


def test_it_is_what_it_is_in_memory(
    robot: Robot, recording: Recording, problem: MomentumProblem
):
    clean, settings = screened(robot, recording), Settings(LONGEST)
    # What the digest decides.
    samples_of(robot, problem.recording, problem.late, settings)
    samples = samples_of(robot, clean.recording, problem.late, settings)
    wanted = fit(robot, problem.sets, samples, "unknown", lambda _: None)
    assert_same(problem.fits, wanted)
    assert problem.rejected == clean.rejected
    assert problem.rejected["joint.joint2.position"] == {"spike": 1}
    extent = problem.extent
    assert extent is not None
    assert (extent.rows, extent.end) == (ROWS, recording.t[-1])
    for k, q in enumerate(samples.q):
        assert extent.ranges["q"].ends(k) == pytest.approx([q.min(), q.max()])


def test_what_is_put_right_is_so_in_every_stretch(
    robot: Robot, recording: Recording, problem: MomentumProblem
):
    q = recording.columns["joint.joint3.position"]
    low = np.nanmedian(q)
    wrong = {
        "joint.joint3.position": (q - low) % (2 * np.pi) + low,
        "joint.joint1.velocity": np.zeros(ROWS),
    }
    found = in_stretches(robot, recording.with_columns(wrong), 2**11)
    assert_same(found.fits, problem.fits)
    assert found.rejected == problem.rejected
    turned, unused = found.notes
    assert turned.startswith("column 'joint.joint3.position' leaps by a turn")
    assert unused.startswith("column 'joint.joint1.velocity' is not the rate")


@pytest.mark.parametrize("parts", [2, 4])
def test_parts_change_nothing(
    robot: Robot, recording: Recording, problem: MomentumProblem, parts: int
):
    other = in_stretches(robot, recording, -(-ROWS // parts))
    assert_same(other.fits, problem.fits)


def test_structured_equations_go_on_from_stretch_to_stretch(
    robot: Robot, recording: Recording, problem: MomentumProblem
):
    at_once = in_stretches(robot, recording, ROWS)
    one, other = (
        Structured().estimate(each, lambda _: None).parameters.base
        for each in (problem, at_once)
    )
    std = np.sqrt(np.diag(other.covariance))
    assert np.max(np.abs(one.values - other.values) / std) < SAME
    np.testing.assert_allclose(np.sqrt(np.diag(one.covariance)), std, rtol=SAME)


def test_a_joint_that_never_moves_is_held(robot: Robot, recording: Recording):
    random = np.random.default_rng(1)
    still = 0.3 + 1e-5 * random.standard_normal(ROWS)
    columns = {**recording.columns, "joint.joint3.position": still}
    found = in_stretches(robot, replace(recording, columns=columns), 2**11)
    assert found.samples.locked == ("joint3",)
    (q,) = {*found.samples.q[2]}
    assert q == pytest.approx(0.3, abs=1e-6)


def test_a_file_is_identified_as_its_recording(robot: Robot, tmp_path: Path):
    path, recording = tmp_path / "long.parquet", again(robot)
    write_recording(recording, path)
    found = identify(robot, path, "least-squares")
    wanted = identify(robot, recording, "least-squares")
    assert found.samples == wanted.samples
    assert found.mass == wanted.mass
    np.testing.assert_array_equal(found.base.values, wanted.base.values)
    assert found.motion == wanted.motion
    assert found.motion is not None
    assert found.motion["duration"] == pytest.approx(np.ptp(recording.t))
    assert found.status == "ok"
    assert found.mass.value == pytest.approx(robot.mass, rel=1e-9)
    # Of a recording that is looked at in part, too.
    assert found.signals()


def test_what_must_be_integrated_is_read_whole(robot: Robot, recording: Recording):
    columns = {n: x for n, x in recording.columns.items() if "attitude" not in n}
    long = LongRecording.of(replace(recording, columns=columns))
    assert digest_of(robot, long, "unknown") is None


@pytest.mark.slow
def test_a_late_clock_is_corrected(robot: Robot, monkeypatch: pytest.MonkeyPatch):
    """Joints and wheels show what was 20 ms ago."""
    monkeypatch.setattr("orbident.estimation.clock_search.MOST", 1000)
    fine = noisy(again(robot), 0.1)
    flight = int(np.flatnonzero(np.diff(fine.t) > 0.5)[0]) + 1
    columns = dict(fine.columns)
    for name in (n for n in columns if n.startswith(("joint", "wheel"))):
        columns[name] = np.roll(columns[name], 1)
        columns[name][::flight] = np.nan
    late = replace(fine, columns=columns)

    def clock(recording: Recording) -> Delay:
        long = LongRecording.of(recording)
        found = solve(robot, long, "unknown", LeastSquares(), lambda _: None)
        return found.problem.clocks["joints"]

    found = clock(late)
    assert found.believed
    assert found.late == pytest.approx(0.02, abs=3 * found.std)
    assert not clock(fine).believed
