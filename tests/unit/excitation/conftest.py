"""Motions and robots that several tests of excitation share."""

import numpy as np
import pytest

from orbident.robot.robot_file import load_robot
from orbident.studies.paper_tables import spatial_trajectory


@pytest.fixture(scope="session")
def servicer():
    return load_robot("paper-spatial")


@pytest.fixture(scope="session")
def table_2(servicer):
    return spatial_trajectory(servicer)


@pytest.fixture(scope="session")
def emulator():
    return load_robot("cepheus-like")


@pytest.fixture(scope="session")
def still():
    """Two joints at rest at zero."""
    return np.zeros((2, 3))
