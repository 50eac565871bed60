"""float64, without touching the JAX configuration of a user's process."""

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import jax
import jax.numpy as jnp

from orbident.errors import InputError

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def in_float64(verb: Callable[Arguments, Returned]) -> Callable[Arguments, Returned]:
    """Run a public verb in float64; in float32 no parameter would be identified."""

    @functools.wraps(verb)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Returned:
        with jax.enable_x64(True):
            return verb(*args, **kwargs)

    return wrapped


def require_float64(function: str, **arrays: Any) -> None:
    """Refuse numbers that have lost half their digits.

    Raises:
        InputError: an array is not float64, or would not be in this process.
    """
    for name, values in arrays.items():
        dtype = jnp.asarray(values).dtype
        if dtype != jnp.float64:
            raise InputError(
                f"{function}: {name} is {dtype}; give float64, and enable it with "
                "jax.config.update('jax_enable_x64', True)"
            )
