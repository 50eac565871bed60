"""Equations of a recording in wrong units may overflow, and nothing can be fitted."""

import numpy as np

from orbident.errors import InputError


def check_finite(*numbers: np.ndarray | float) -> None:
    """Refuse equations that are not finite.

    Raises:
        InputError: a number is infinite or none.
    """
    if not all(np.isfinite(each).all() for each in numbers):
        raise InputError(
            "what the sensors should show overflows, so nothing can be fitted to it; "
            "check the units of the recording (s, rad, rad/s, m) and of the robot's "
            "masses and inertias (kg, kg m^2)"
        )
