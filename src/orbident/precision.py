"""float64, without touching the JAX configuration of a user's process."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import jax

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def in_float64(verb: Callable[Arguments, Returned]) -> Callable[Arguments, Returned]:
    """Run a public verb in float64; in float32 no parameter would be identified."""

    @functools.wraps(verb)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        with jax.enable_x64(True):
            return verb(*args, **kwargs)

    return wrapped
