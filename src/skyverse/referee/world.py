"""A scenario as the referee's arrays: made once, at the start of a judgement, and handed to everything that judges."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import require_kind
from skyverse.model.pad import error_about_pads
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.referee.boxes import GrownBoxes, grown_boxes
from skyverse.referee.ground import GrownGround, ceiling_above_ground, grown_ground
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.round_solids import grown_cylinders, grown_ellipsoids, grown_spheres
from skyverse.referee.solid_shapes import SolidShapes, solid_shapes
from skyverse.referee.solids import GrownSolids
from skyverse.referee.tracking_error import EXACT


@dataclass(frozen=True, eq=False)
class RefereeWorld:
    """What a UAV must stay in and keep clear of.

    Attributes
    ----------
    scenario
        What was given.
    shapes
        All shapes that must not be entered.
    low, high
        (3,) corners of the bounds, less the tracking error, metres.
    first_node
        (3,) metres: the node where the lattice begins, at the corner of the scenario's bounds.
    step
        (3,) metres between neighbouring lattice nodes.
    boxes
        The grown boxes, those of voxels among them.
    others
        All other grown shapes, one entry for each kind that the scenario has, with the ground and the ceiling last.
    ground
        The ground as it is, without an error; ``None`` where the scenario has no terrain.
    error
        How far the flown position may be from the one that is judged.
    without_error
        The world without the error, ``None`` where there is no error.
    """

    scenario: Scenario
    shapes: SolidShapes
    low: Floats
    high: Floats
    step: Floats
    boxes: GrownBoxes
    others: tuple[GrownSolids, ...]
    ground: GrownGround | None
    first_node: Floats
    error: TrackingError
    without_error: "RefereeWorld | None" = None

    @property
    def nominal(self) -> "RefereeWorld":
        """The world without the error."""
        return self if self.without_error is None else self.without_error

    @property
    def floor(self) -> GrownGround | None:
        """The ground, raised by the error; ``None`` where the scenario has no terrain."""
        return next((kind for kind in self.others if isinstance(kind, GrownGround)), None)

    @cached_property
    def about_pads(self) -> "RefereeWorld":
        """The world of the axes of pads: what keeps clear in it keeps the error from the pads."""
        error = error_about_pads(self.scenario, self.error)
        return self if error == self.error else referee_world(self.scenario, error, self.nominal)

    def beyond_bounds(self, positions: Floats) -> Floats:
        """Return how far (n, 3) positions are out of bounds along the worst axis of each, (n,) metres; 0 inside."""
        return np.maximum(np.maximum(self.low - positions, positions - self.high).max(axis=1), 0.0)

    def off_lattice(self, positions: Floats) -> Floats:
        """Return how far (n, 3) positions are from a lattice node along the worst axis of each, (n,) metres."""
        nodes = self.first_node + np.rint((positions - self.first_node) / self.step) * self.step
        return np.abs(positions - nodes).max(axis=1)


def grown_kinds(shapes: SolidShapes, error: TrackingError) -> tuple[GrownBoxes, list[GrownSolids]]:
    """Return shapes grown for a UAV with a tracking error: the boxes, and each other kind that there is."""
    others = [make(shapes, error) for make in (grown_cylinders, grown_spheres, grown_prisms, grown_ellipsoids)]
    return grown_boxes(shapes, error), [kind for kind in others if len(kind.obstacle)]


def referee_world(
    scenario: Scenario,
    error: TrackingError = EXACT,
    nominal: RefereeWorld | None = None,
    like: RefereeWorld | None = None,
) -> RefereeWorld:
    """Turn a scenario into the referee's arrays, for the nominal position of a UAV with a tracking error.

    Where the nominal position is clear and in bounds, every position within the error of it is. `nominal` is the world
    without the error, and `like` that of a scenario with other clearances alone, if they are made already.
    """
    without_error = None if error == EXACT else nominal or referee_world(scenario, like=like)
    if without_error is None:
        ground = floor = grown_ground(scenario, like=None if like is None else like.ground)
    else:
        ground = without_error.ground
        floor = grown_ground(scenario, error, like.floor if like is not None and like.error == error else None)
    known = without_error or like
    shapes = solid_shapes(scenario) if known is None else replace(known.shapes, clearance=scenario.clearance)
    boxes, others = grown_kinds(shapes, error)
    others += [] if floor is None else [floor]
    others += [] if (ceiling := ceiling_above_ground(scenario, error)) is None else [ceiling]
    corner, high, step = (np.array(row) for row in (scenario.bounds.min, scenario.bounds.max, scenario.lattice.step))
    reach = np.array([error.horizontal, error.horizontal, error.vertical])
    low, high = corner + reach, high - reach
    return RefereeWorld(scenario, shapes, low, high, step, boxes, tuple(others), ground, corner, error, without_error)


def require_sound(scenario: Scenario) -> None:
    """Raise `InputError` for what no file of a scenario could hold, whoever made it, and however.

    Models are validated when they are made, but pydantic has ways around that, such as ``model_construct``.
    """
    require_kind(scenario, Scenario, "scenario")
    Scenario(**scenario.model_dump(warnings=False))


class RefereeWorlds:
    """The worlds of a scenario: one for each distinct tracking error of its UAVs, and the nominal one without any.

    Parameters
    ----------
    scenario
        What is given.

    Raises
    ------
    InputError
        If the scenario is not sound; see `require_sound`.
    """

    def __init__(self, scenario: Scenario) -> None:
        require_sound(scenario)
        self.scenario = scenario
        self.nominal = referee_world(scenario)
        self._known = {EXACT: self.nominal}

    def of(self, uav: int) -> RefereeWorld:
        """Return the world for the nominal position of a UAV."""
        error = self.scenario.uavs[uav].tracking_error
        if error not in self._known:
            self._known[error] = referee_world(self.scenario, error, self.nominal)
        return self._known[error]
