"""The planners that are compared: the name of each, how it is run, and how often."""

import importlib.util
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

import skyverse as sky

Better = Callable[..., None]
"""Called with every better path: seconds since the start, metres, calls of the point and of the segment test."""

MANY = 1000
"""Seeds that a planner takes at most, if it draws random numbers."""

Run = Callable[[sky.Scenario, int, float, Better], tuple[np.ndarray | None, Mapping[str, Any]]]
"""Takes scenario, seed, seconds and callback; returns the path, (n, 3), and facts such as the time to set up."""


class Contender(NamedTuple):
    """A planner under test.

    Attributes
    ----------
    kind
        ``ours``, ``sampling``, ``optimiser`` or ``grid``.
    maps, cities
        How many seeds; 0 where it does not take part.
    needs
        The package without which it is left out.
    prepare
        What has to come first in the process, with the seed.
    """

    kind: str
    run: Run
    maps: int = 1
    cities: int = 1
    needs: str = "skyverse"
    prepare: Callable[[int], None] = lambda seed: None

    @property
    def installed(self) -> bool:
        """Whether what it needs is there."""
        return importlib.util.find_spec(self.needs) is not None

    def seeds(self, problem: str) -> int:
        """Return how many runs a problem gets."""
        return self.cities if problem.startswith("city") else self.maps


def _all() -> dict[str, Contender]:
    import grids
    import optimisers
    import ours
    import sampling

    found: dict[str, Contender] = {}
    for module in (ours, sampling, optimisers, grids):
        found |= {name: Contender(**facts) for name, facts in module.CONTENDERS.items()}
    return found


ALL = _all()
