"""Optimisers of functions of vectors in [0, 1]^d; none of them knows what the vectors stand for.

Each is a generator function ``(evaluate, first, rng)``. It evaluates the first population, ``(m, d)``, and yields. Then
it does one iteration for each number that it is sent: the share of the budget, 0 to 1, that is spent when the iteration
ends, which drives its schedules. It never returns.
"""

from collections.abc import Callable, Generator

import numpy as np

from skyverse._typing import Floats

Evaluate = Callable[[Floats], Floats]
"""Returns the (m,) fitness of (m, d) vectors, which is to be minimised."""

Iterations = Generator[None, float, None]
"""One iteration for each share of the budget that is sent."""

Optimiser = Callable[[Evaluate, Floats, np.random.Generator], Iterations]
"""Minimises `evaluate` from a first population (m, d) on, with random numbers from a generator."""
