"""The control study: CAD models that are off, and tracking with the identified one."""

import numpy as np
import pytest

from orbident.campaigns.seeds import SeedRuns
from orbident.robot.parameters import inertia_about_com
from orbident.studies.control import FACTOR, off_by, run_control, tracked
from orbident.studies.paper_tables import spatial_robot


def test_every_cad_value_is_off():
    robot = spatial_robot()
    cad = off_by(robot, 0.2, seed=3)
    for true, found in zip(robot.theta, cad.theta, strict=True):
        assert abs(found[0] / true[0] - 1) == pytest.approx(0.2)
        size = np.linalg.norm(found[1:4]) / np.linalg.norm(true[1:4])
        assert abs(size - 1) == pytest.approx(0.2)
        I, I_cad = inertia_about_com(true), inertia_about_com(found)
        assert abs(np.trace(I_cad) / np.trace(I) - 1) == pytest.approx(0.2)
        # It stays the inertia of a body.
        a, b, c = np.linalg.eigvalsh(I_cad)
        assert 0 < a <= c <= a + b
    assert not np.array_equal(cad.theta, off_by(robot, 0.2, seed=4).theta)


def test_tracking_is_better_with_the_identified_model():
    """It is far better than asked for: noise-free, the torques are the true ones."""
    done = run_control("none", SeedRuns(first=1))
    assert done.trusted
    assert done.factor > 1e3 * FACTOR
    assert done.errors["CAD"].joints > 1e-3
    assert done.errors["CAD"].base > 1e-4
    exact = tracked(spatial_robot(), spatial_robot())
    # What the integration is accurate to.
    assert max(exact) < 1e-8
    assert max(done.errors["identified"]) < 1e-8
    assert done.to_json()["rms_error"]["CAD"]["base"] == done.errors["CAD"].base
