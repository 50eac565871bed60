"""What every test runs under: float64, the same hypothesis examples each time, and
compiled functions that are kept between workers and runs."""

import os

import jax
import pytest
from hypothesis import settings

jax.config.update("jax_enable_x64", True)

# A deadline would measure compilation; random examples would depend on the clock.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")


def pytest_configure(config: pytest.Config) -> None:
    assert config.cache is not None
    # As the command keeps them: see prepare_jax.
    cache = config.cache.mkdir("compiled")
    jax.config.update("jax_compilation_cache_dir", str(cache))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.5)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    os.environ["NUMBA_CACHE_DIR"] = str(config.cache.mkdir("loops"))
