"""Lattices whose steps upright fit between the clearance from the ground and a ceiling above ground."""

import math

from skyverse.model.round_steps import ROUND
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
