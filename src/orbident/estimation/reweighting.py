"""Whether a fit's weights, from the residuals of the fit before, have settled."""

from orbident.estimation.check import Check
from orbident.estimation.estimate import Estimate


def unsettled_weights(estimate: Estimate) -> list[Check]:
    """What it means that noise and outliers still differ from round to round."""
    if estimate.settled:
        return []
    return [
        Check(
            "weights",
            "with care",
            "the noise of the sensors, or which samples are outliers, still changed in "
            "the last round of the fit, so the estimates may change by a part of "
            "their deviations",
            "declare the noise of the sensors in the robot file, and look for outliers "
            "and drifts in the residuals",
        )
    ]
