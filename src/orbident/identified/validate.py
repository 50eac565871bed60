"""How well a result predicts a recording that was not used (Section 5.6)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.estimation.quantities import nulled
from orbident.estimation.result import Result
from orbident.identified.intervals import deviations
from orbident.identified.prediction import predict
from orbident.model.minimal_sets import conserved_axes
from orbident.recordings.recording import Recording

WITHIN = 1.96
"""Deviations: 95 % of what is normally distributed."""


@dataclass(frozen=True)
class Validation:
    """Prediction errors; NaN where there was nothing to compare with."""

    nrmse: dict[str, float]
    """RMS of the error over the RMS of the measured signal about its mean."""
    rms: dict[str, float]
    """RMS of the error: gyro in rad/s, velocity in m/s."""
    samples: int
    std: dict[str, float]
    """RMS of the predicted signals' deviations, as the parameters have theirs."""
    inside: dict[str, float]
    """Fraction of samples within 1.96 of these: 0.95 where the parameters alone are
    off, and less with noisy sensors, whose noise is not in it."""

    def to_json(self) -> dict[str, Any]:
        """As `validate --json` gives it."""
        return {
            "nrmse": {name: nulled(value) for name, value in self.nrmse.items()},
            "rms": {name: nulled(value) for name, value in self.rms.items()},
            "samples": self.samples,
            "predicted_std": {name: nulled(value) for name, value in self.std.items()},
            "inside_95": {name: nulled(value) for name, value in self.inside.items()},
        }


def validate(result: Result, recording: Recording) -> Validation:
    """Predict a recording's base rates and velocities and score them.

    Raises:
        InputError: the result has undetermined parameters, or the recording lacks what
            prediction needs.
    """
    prediction = predict(result, recording)
    turning, moving = conserved_axes(result.robot)
    seen = prediction.measured.moving
    may_be_off = deviations(result, prediction)
    stds = {
        "gyro": may_be_off.w[:, turning],
        "velocity": may_be_off.v_S[seen][:, moving],
    }
    pairs = {
        "gyro": (prediction.w[:, turning], prediction.measured.w[:, turning]),
        "velocity": (
            prediction.v_S[seen][:, moving],
            prediction.measured.v_S[seen][:, moving],
        ),
    }
    rms = {name: _rms(predicted - true) for name, (predicted, true) in pairs.items()}
    size = {name: _rms(true - true.mean(axis=0)) for name, (_, true) in pairs.items()}
    return Validation(
        nrmse={name: rms[name] / size[name] if size[name] else np.nan for name in rms},
        rms=rms,
        samples=prediction.t.size,
        std={name: _rms(std) for name, std in stds.items()},
        inside={
            name: _inside(predicted - true, stds[name])
            for name, (predicted, true) in pairs.items()
        },
    )


def _inside(
    errors: Float[np.ndarray, "n axes"], std: Float[np.ndarray, "n axes"]
) -> float:
    if not (len(errors) and np.isfinite(std).all()):
        return np.nan
    return float(np.mean(np.abs(errors) <= WITHIN * std))


def _rms(errors: Float[np.ndarray, "n axes"]) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1)))) if len(errors) else np.nan
