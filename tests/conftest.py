"""What every test runs under: the same hypothesis examples each time."""

from hypothesis import settings

# A deadline would measure the machine; random examples would depend on the clock.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")
