"""Threads of the core where the system gives no more of them."""

import sys

import pytest
from processes import finished

LIMITED = """
import resource
import numpy as np
from orbident import _core
one = np.ones((1, 3))
tree = _core.Tree(np.zeros(1), np.ones(1), one, np.eye(3)[None], one)
q = np.linspace(0.0, 1.0, 64 * 128)[:, None]
alone = _core.poses(tree, q, 1)
with open("/proc/self/statm") as file:
    pages = int(file.read().split()[0])
# Room for a few stacks of 8 MB.
limit = pages * resource.getpagesize() + 2**26
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
for x, y in zip(_core.poses(tree, q, 64), alone, strict=True):
    assert (x == y).all()
print("the same")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="/proc and RLIMIT_AS are Linux's")
def test_without_threads_the_work_is_done_all_the_same():
    run = finished(sys.executable, "-c", LIMITED)
    assert (run.returncode, run.stdout, run.stderr) == (0, "the same\n", "")
