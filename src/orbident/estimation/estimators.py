"""The methods of identification, by name: a new one is a file, and a word here."""

from typing import Literal, get_args

from orbident.errors import InputError
from orbident.estimation.estimate import Estimator
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.recursive.recursive_estimator import Recursive
from orbident.estimation.structured import Structured

Method = Literal["maximum-likelihood", "structured", "least-squares", "recursive"]
METHODS: tuple[Method, ...] = get_args(Method)

ESTIMATORS: dict[str, type[Estimator]] = {
    "maximum-likelihood": OutputError,
    "structured": Structured,
    "least-squares": LeastSquares,
    "recursive": Recursive,
}

IN_STRETCHES = (LeastSquares, Structured)
"""Those that take a long recording in stretches."""


def estimator_of(method: str | Estimator) -> Estimator:
    """An estimator by its name, or as it is.

    Raises:
        InputError: there is none of that name.
    """
    if not isinstance(method, str):
        return method
    if method not in ESTIMATORS:
        raise InputError(f"method '{method}' is unknown; use {' or '.join(METHODS)}")
    return ESTIMATORS[method]()
