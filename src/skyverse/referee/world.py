"""A scenario as the referee's arrays: made once, at the start of a judgement, and handed to everything that judges."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.referee.boxes import GrownBoxes, grown_boxes
from skyverse.referee.ground import GrownGround, ceiling_above_ground, grown_ground
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.round_solids import grown_cylinders, grown_spheres
from skyverse.referee.solids import GrownSolids


@dataclass(frozen=True, eq=False)
class RefereeWorld:
    """What a UAV must stay in and keep clear of.

    Attributes
    ----------
    scenario
        What was given.
    low, high
        (3,) corners of the bounds, metres.
    step
        (3,) metres between neighbouring lattice nodes.
    boxes
        The grown boxes, those of voxels among them.
    others
        All other grown shapes, one entry for each kind that the scenario has, with the ground and the ceiling last.
    ground
        The ground, ``None`` where the scenario has no terrain.
    """

    scenario: Scenario
    low: Floats
    high: Floats
    step: Floats
    boxes: GrownBoxes
    others: tuple[GrownSolids, ...]
    ground: GrownGround | None

    def beyond_bounds(self, positions: Floats) -> Floats:
        """Return how far (n, 3) positions are out of bounds along the worst axis of each, (n,) metres; 0 inside."""
        return np.maximum(np.maximum(self.low - positions, positions - self.high).max(axis=1), 0.0)

    def off_lattice(self, positions: Floats) -> Floats:
        """Return how far (n, 3) positions are from a lattice node along the worst axis of each, (n,) metres."""
        nodes = self.low + np.rint((positions - self.low) / self.step) * self.step
        return np.abs(positions - nodes).max(axis=1)


def referee_world(scenario: Scenario) -> RefereeWorld:
    """Turn a scenario into the referee's arrays."""
    ground = grown_ground(scenario)
    kinds: list[GrownSolids] = [grown_cylinders(scenario), grown_spheres(scenario), grown_prisms(scenario)]
    others = [kind for kind in kinds if len(kind.obstacle)]
    others += [] if ground is None else [ground]
    others += [] if (ceiling := ceiling_above_ground(scenario)) is None else [ceiling]
    low, high, step = (np.array(row) for row in (scenario.bounds.min, scenario.bounds.max, scenario.lattice.step))
    return RefereeWorld(scenario, low, high, step, grown_boxes(scenario), tuple(others), ground)
