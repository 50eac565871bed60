"""What every test runs under: the same hypothesis examples and width each time.

And one thread of BLAS, as the public verbs have: where tests call what is below these,
side by side in two processes, threads that wait for one another take thrice the time.
"""

import os

from hypothesis import settings
from threadpoolctl import threadpool_limits

# Trees are as wide as the terminal that the tests are started in.
os.environ["COLUMNS"] = "110"

# For libraries that are loaded later, and processes; and for what is loaded already.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
threadpool_limits(limits=1, user_api="blas")

# A deadline would measure the machine; random examples would depend on the clock.
settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")
