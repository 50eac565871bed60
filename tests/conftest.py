"""What every test runs under: the same hypothesis examples and width each time."""

import os

from hypothesis import settings

# Trees are as wide as the terminal that the tests are started in.
os.environ["COLUMNS"] = "110"

# A deadline would measure the machine; random examples would depend on the clock.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")
