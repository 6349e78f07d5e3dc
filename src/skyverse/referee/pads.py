"""Where a UAV's tracking error does not count: on the pads at its own start and targets.

`model.pad` says what a pad is and what the UAV stands on there. All else keeps the error from the pad, or there
is no pad. So on a pad the nominal position alone is judged.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.pad import Pad, pad_at
from skyverse.referee.boxes import GrownBoxes
from skyverse.referee.ground import Ceiling, GrownGround
from skyverse.referee.prisms import GrownPrisms
from skyverse.referee.round_solids import GrownCylinders, GrownEllipsoids
from skyverse.referee.solids import GrownSolids
from skyverse.referee.sorties import Tour
from skyverse.referee.tolerances import EXEMPT_SLOPE, LET_PASS, ON_AXIS
from skyverse.referee.tracking_error import EXACT, narrower, shorter
from skyverse.referee.world import RefereeWorld


def pads_of(world: RefereeWorld, uav: int, tour: Tour) -> list[tuple[str, Pad]]:
    """Return the pads at a UAV's start and at the targets that it visits, each with what is there, in words."""
    scenario = world.scenario
    places = {"start": scenario.uavs[uav].start}
    for target in dict.fromkeys(tour.visited):
        there = scenario.targets[target]
        places["target" if len(tour.visited) == 1 else there.name] = there.position
    pads = ((noun, pad_of(world, uav, place)) for noun, place in places.items())
    return [(noun, pad) for noun, pad in pads if pad is not None]


def pads_sentence(pads: list[tuple[str, Pad]]) -> str:
    """Return what a certificate says of a UAV's pads, to be added to a sentence; empty where there are none."""
    ways = ("at its {} up to z = {:.6g} m", "at {} up to z = {:.6g} m")
    told = " and on that ".join(ways[noun not in ("start", "target")].format(noun, pad.top) for noun, pad in pads)
    return f"; only on the pad {told} that error does not count for the ground and roofs below" if told else ""


def pad_of(world: RefereeWorld, uav: int, place: tuple[float, float, float]) -> Pad | None:
    """Return the pad at a UAV's start or target, (3,) metres; ``None`` if it has none there, or needs none."""
    start, around = np.array(place), world.about_pads
    deepest = max(_depth(kind, start[None]) for kind in (world.boxes, *world.others))
    if world.error == EXACT or max(deepest, float(world.low[2] - start[2])) <= 0:
        return None
    ground = max((_depth(kind, start[None]) for kind in world.others if isinstance(kind, GrownGround)), default=-np.inf)
    pad = pad_at(world.scenario, uav, place, float(start[2]) + ground)
    if pad is None or (
        world.ground is not None and world.ground.steepest_about(start, around.error.horizontal) > EXEMPT_SLOPE
    ):
        return None
    axis = np.array([place, (*place[:2], pad.top)])
    others = without_support(around, start, place[2] - world.scenario.clearance + LET_PASS)
    inside = (axis >= others.low - LET_PASS).all() and (axis <= others.high + LET_PASS).all()
    return pad if inside and max(_depth(kind, axis) for kind in (others.boxes, *others.others)) <= 0 else None


def _depth(kind: GrownSolids, part: Floats) -> float:
    """Return how deep a vertical line (n, 3) gets inside the shapes of a kind, metres; minus infinity without any."""
    if isinstance(kind, GrownGround | Ceiling):
        return float(kind.depth(part[None], np.zeros(1, dtype=np.intp))[0])
    pairs = kind.tree.overlapping(part.min(axis=0)[None], part.max(axis=0)[None])
    which = np.concatenate([np.zeros(0, dtype=np.intp), *(found[:, 1] for found in pairs)])
    return float(kind.depth(np.repeat(part[None], len(which), axis=0), which).max(initial=-np.inf))


def without_support(world: RefereeWorld, place: Floats, highest: float) -> RefereeWorld:
    """Return what there is about the vertical line through a place, (3,) metres, but for what a UAV stands on there.

    Left out are what the error takes of the bounds' floor, the ground if it is not steep, solid shapes that end, as
    given, no higher than `highest`, metres, and all shapes that the line does not meet.
    """
    steep = world.ground is not None and world.ground.steepest_about(place, world.error.horizontal) > EXEMPT_SLOPE
    reach = np.array([LET_PASS, LET_PASS, np.inf])

    def rest(kind: GrownSolids) -> Indices:
        pairs = kind.tree.overlapping((place - reach)[None], (place + reach)[None])
        near = np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *(found[:, 1] for found in pairs)]))
        return near[~supports(world, kind, near, highest)]

    terrain = [kind for kind in world.others if isinstance(kind, Ceiling) or (steep and isinstance(kind, GrownGround))]
    shapes = [kind.of(rest(kind)) for kind in world.others if not isinstance(kind, Ceiling | GrownGround)]
    low = np.array([*world.low[:2], world.nominal.low[2]])
    others = (*(kind for kind in shapes if len(kind.obstacle)), *terrain)
    return replace(world, low=low, boxes=world.boxes.of(rest(world.boxes)), others=others)


def supports(world: RefereeWorld, kind: GrownSolids, which: Indices, highest: float) -> NDArray[np.bool_]:
    """Tell which shapes of a kind, (n,), a UAV may stand on: solid ones that end, as given, no higher than that."""
    solid = np.array([world.scenario.obstacles[number].solid for number in kind.obstacle[which]], dtype=np.bool_)
    return solid & (_tops(kind, which, world) <= highest)


def _tops(kind: GrownSolids, which: Indices, world: RefereeWorld) -> Floats:
    """Return z (n,) at which shapes end as they are given, without the error and the clearance, metres."""
    match kind:
        case GrownBoxes():
            return shorter(kind.high[which, 2], world.error)
        case GrownCylinders():
            return shorter(kind.high[which], world.error)
        case GrownPrisms():
            return shorter(kind.outlines.high[which], world.error)
        case GrownEllipsoids():  # spheres, of obstacles
            return kind.centre[which, 2] + narrower(kind.radius[which], world.error)
    raise TypeError(f"{type(kind).__name__} has no tops")


def parts_of_flight(
    world: RefereeWorld, uav: int, tour: Tour, b: Floats, error: Floats
) -> Iterator[tuple[RefereeWorld, slice]]:
    """Cut the pieces of a flight where it leaves and enters its pads, and yield in which world each part is judged.

    Parameters
    ----------
    world
        For the nominal position of the UAV.
    uav, tour
        The index of the UAV, and the targets that it visits.
    b, error
        (n, degree + 1, 3) coefficients of the pieces, metres, and (n,) bounds on their errors.
    """
    on_pad = np.zeros(len(b), dtype=np.bool_)
    for _, pad in pads_of(world, uav, tour):
        on_pad |= holds(pad, b, error)
    cuts = [0, *(np.flatnonzero(np.diff(on_pad)) + 1).tolist(), len(b)]
    for start, stop in pairwise(cuts):
        yield world.nominal if on_pad[start] else world, slice(start, stop)


def holds(pad: Pad, b: Floats, error: Floats) -> NDArray[np.bool_]:
    """Tell which pieces, (n, degree + 1, 3) coefficients and (n,) bounds on their errors, are on a pad."""
    aside = np.hypot(*np.moveaxis(b[:, :, :2] - pad.place[:2], -1, 0)).max(axis=1)
    low, high = b[:, :, 2].min(axis=1), b[:, :, 2].max(axis=1)
    held: NDArray[np.bool_] = (aside + error <= pad.spare + ON_AXIS) & (low - error >= pad.place[2] - LET_PASS)
    return held & (high + error <= pad.top + LET_PASS)
