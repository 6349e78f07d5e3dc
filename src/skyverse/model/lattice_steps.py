"""Steps of a lattice where none are given, and those upright that fit between ground and ceiling."""

import math
from collections.abc import Sequence

from skyverse.model.scenario import Scenario

SHORTEST = 0.1
"""Metres: where less height is left, no step is chosen for it."""
STEPS_IN_BAND = 2
"""Steps at least between the clearance from the ground and the ceiling, so that a way between them follows slopes."""


def upright_step(scenario: Scenario) -> float:
    """Return the longest round step, metres, of which `STEPS_IN_BAND` fit below the scenario's ceiling above ground.

    It is infinite where there is no ceiling, or no such step.
    """
    if scenario.max_height is None:
        return math.inf
    strays = max((uav.tracking_error.vertical for uav in scenario.uavs), default=0.0)
    room = scenario.max_height - scenario.ground_clearance - 2.0 * strays
    return max((step for step in ROUND if step >= SHORTEST and STEPS_IN_BAND * step <= room), default=math.inf)


def with_fitting_lattice(scenario: Scenario) -> Scenario:
    """Return a scenario whose lattice has no longer steps upright than fit below its ceiling above ground."""
    (x, y, z), upright = scenario.lattice.step, upright_step(scenario)
    if z <= upright:
        return scenario
    return scenario.model_copy(update={"lattice": scenario.lattice.model_copy(update={"step": (x, y, upright)})})


MAX_DEFAULT_NODES = 2e6
"""Nodes of the lattice at most where its step is not given."""
MAX_BELOW_CEILING = 5e6
"""The same where there is a ceiling above ground: most nodes are then above it, and never searched."""
ROUND = [digit * 10.0**power for power in range(-3, 13) for digit in (1, 2, 5)]


def round_steps(sizes: Sequence[float], least: float = 0.0, upright: float = math.inf) -> tuple[float, float, float]:
    """Return the shortest round step, the same along each axis, for which the lattice has few enough nodes, metres.

    Parameters
    ----------
    sizes
        The lengths of the bounds along x, y and z, metres; along a shorter one, the step is its length.
    least
        Metres: no step is shorter, but for the one along z where that must be.
    upright
        Metres that the step along z is no longer than, where there is a ceiling above ground.
    """
    most = MAX_DEFAULT_NODES if upright == math.inf else MAX_BELOW_CEILING
    asked = ((step, step, min(step, upright)) for step in ROUND if step >= least)
    tried = ([min(step, size) for step, size in zip(steps, sizes, strict=True)] for steps in asked)
    x, y, z = next(steps for steps in tried if _nodes(sizes, steps) <= most)
    return x, y, z


def _nodes(sizes: Sequence[float], steps: Sequence[float]) -> float:
    return math.prod(size / step + 1 for size, step in zip(sizes, steps, strict=True))
