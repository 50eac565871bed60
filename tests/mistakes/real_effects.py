"""What real instruments, gears and spacecraft do, from just visible to gross.

Sizes are those of data sheets and of laboratories; where two are given, the smaller one
is what a good instrument has. MuJoCo flies the robots.
"""

from effects_of_gears import GEARS
from effects_of_gyros import OF_GYROS
from effects_of_trackers import OF_TRACKERS
from effects_on_robots import ON_ROBOTS
from effects_on_times import ON_TIMES

EFFECTS = {**GEARS, **OF_GYROS, **OF_TRACKERS, **ON_TIMES, **ON_ROBOTS}
