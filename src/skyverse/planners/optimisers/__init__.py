"""Optimisers of functions of vectors in [0, 1]^d; none of them knows what the vectors stand for.

Each is a generator function ``(evaluate, first, rng)``. It evaluates the first population, ``(m, d)``, and yields; from
then on it does one iteration each time that it is sent the share of the budget that is spent when the iteration ends,
0 to 1, which drives its schedules. It never returns.
"""

from collections.abc import Callable, Generator

from skyverse._typing import Floats

Evaluate = Callable[[Floats], Floats]
"""Takes (m, d) vectors and returns their (m,) fitness, which is to be minimised."""

Iterations = Generator[None, float, None]
"""One iteration for each share of the budget that is sent."""
