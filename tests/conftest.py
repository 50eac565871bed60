"""What every test runs under: float64, and the same hypothesis examples each time."""

import jax
from hypothesis import settings

jax.config.update("jax_enable_x64", True)

# A deadline would measure compilation; random examples would depend on the clock.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")
