"""How large a number may be that comes from a file, so that all that follows is finite.

What is beyond is a unit that was mistaken, or a damaged file, and would only come to
light as an overflow far inside.
"""

LARGEST = 1e12
"""SI. No spacecraft needs more: 1e12 m is beyond Saturn, 1e12 s are 30,000 years. A
product of twenty such numbers is still a float64."""

SMALLEST = 1e-15
"""SI, of what must be above zero: a proton's radius in m, far below any noise. The
inverse fourth power is still a float64."""

FAINTEST = 1e-50
"""SI, of the largest number of a column that is not all zero: rounding leaves more,
and its inverse fourth power is still a float64."""

SHORTEST = 1e-9
"""s, between two samples. Loggers count nanoseconds at best."""

TOGETHER = 1e-6
"""s: samples this close are of one time, as clocks and their latencies are rounded; in
the mean no sensor's follow each other so fast."""

MOST_RECORDINGS = 100
"""Short motions that are designed together: a day in a laboratory."""
