"""How a result predicted a recording that was not used, if `validate` was run."""

import json
from pathlib import Path

from orbident.data_table import Numeric, table_of
from orbident.errors import InputError
from orbident.report.numbers import short
from orbident.report.page import Section

UNITS = {"gyro": "rad/s", "velocity": "m/s"}


def read_validation(path: Path) -> Section | None:
    """The scores that `validate` has left; None where there are none.

    Raises:
        InputError: the file is not what `validate` writes.
    """
    if not path.is_file():
        return None
    try:
        return validation(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{path}: was altered or cut off; run 'orbident validate' again, or remove "
            "it"
        ) from None


def validation(scores: dict) -> Section:
    """The verdict, and the errors beside what was expected of them."""
    rows = (
        (
            f"{name}, {unit}",
            Numeric(scores["rms"].get(name)),
            Numeric(_percent(scores["nrmse"].get(name))),
            Numeric(scores["predicted_std"].get(name)),
            Numeric(scores["noise"].get(name)),
        )
        for name, unit in UNITS.items()
    )
    origin = "which was not used to identify"
    if scores.get("used"):
        origin = "from which the parameters were identified, so that it says little"
    words = [
        f"Base rates and velocities of {scores['file']}, {origin}, were predicted from "
        "the motion of joints and wheels: "
        f"{scores['verdict']}. {scores['reason'].capitalize()}.",
    ]
    if scores["degrees_of_freedom"]:
        words.append(
            f"Chi-square {short(scores['chi2'])} with {scores['degrees_of_freedom']} "
            f"degrees of freedom, p = {short(scores['p_value'], 2)}."
        )
    head = ("signal", "error, RMS", "% of signal", "by parameters", "by sensors")
    return Section(
        name="validation",
        title="Validation",
        words=tuple(words),
        tables=(table_of("Errors, and what is expected of them", head, rows),),
    )


def _percent(value: float | None) -> float | None:
    return None if value is None else 100 * value
