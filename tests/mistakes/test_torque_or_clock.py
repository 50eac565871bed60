"""A steady torque looks like a late clock to Eq. 24: the sensors tell them apart."""

import numpy as np
import pytest
from recordings import TABLE, clean
from spoiled import Spoiled, spoiled
from wrong_motions import torque

from orbident.estimation.identify import Method, estimator_of
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problems
from orbident.estimation.solve import evidence
from orbident.recordings.recording import Recording


def late(rows: int) -> Spoiled:
    """Joints and wheels as they were so many rows ago; a row is 20 ms."""
    exact = clean(TABLE)
    recording = exact.recorded()
    columns = {
        name: x[:-rows] if name.startswith(("joint", "wheel")) else x[rows:]
        for name, x in recording.columns.items()
    }
    return spoiled(exact, recording=Recording(recording.t[rows:], columns))


def believed(
    mistake: Spoiled, method: Method
) -> tuple[MomentumProblem, MomentumProblem, MomentumProblem]:
    """The one that the sensors fit; as recorded; and with the clock corrected."""
    recorded, corrected = momentum_problems(
        mistake.robot, mistake.recording, mistake.initial_momentum, lambda _: None
    )
    assert not recorded.clocks["joints"].believed
    assert corrected.clocks["joints"].believed
    chosen = evidence([recorded, corrected], estimator_of(method), lambda _: None)
    return chosen.problem, recorded, corrected


@pytest.mark.parametrize("method", ["maximum-likelihood", "least-squares"])
@pytest.mark.parametrize("size", [1e-4, 1e-3])
def test_a_torque_that_looks_like_a_late_clock(method: Method, size: float):
    """Joints seem to be 0.1 s or 0.7 s early; they are on time."""
    chosen, recorded, _ = believed(torque(size)(clean(TABLE)), method)
    assert np.abs(recorded.clocks["joints"].late) > 0.05
    assert chosen is recorded


@pytest.mark.parametrize("method", ["maximum-likelihood", "least-squares"])
@pytest.mark.parametrize("rows", [1, 2])
def test_a_clock_that_is_late(method: Method, rows: int):
    chosen, _, corrected = believed(late(rows), method)
    assert chosen is corrected
