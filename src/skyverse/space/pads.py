"""From where a UAV may stray that takes off or lands on a pad, which UAVs have pads, and why one has none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mission import Mission
from skyverse.model.pad import Pad, pad_at
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import PAD_LIFT, SURFACE_DEPTH
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import World

MAX_EXITS = 1000
"""Obstacles one above another out of which a UAV is led at most."""
PLACES = 40
"""Places on a pad's axis of which the one nearest to what is too near is told."""
HALVINGS = 40
"""Halvings of the metres by which something is too near."""
MAX_NAMED = 3
"""UAVs whose pads are named; of more it is told how many there are."""


class FleetPad(NamedTuple):
    """The pad of a UAV's start or of a target.

    Attributes
    ----------
    uav
        The index of its UAV.
    end
        What is there: ``"its start"``, ``"its target"`` or, of a tour, the name of a target.
    pad
        Where it is.
    """

    uav: int
    end: str
    pad: Pad


def lifted(nominal: World, world: World, uav: int, place: tuple[float, float, float]) -> Floats:
    """Return the lowest place straight above a start or target from which a UAV may stray, (3,) metres.

    Parameters
    ----------
    nominal, world
        The worlds without the UAV's tracking error and with it.
    uav
        The index of the UAV.
    place
        (3,) metres: the start or target.

    Returns
    -------
    Floats
        The place itself where a UAV may stray from it, and also where it has no pad.
    """
    start, pad = np.array(place), _pad(world, uav, place)
    if pad is None or world.free(start)[0] or _too_near(world, pad) is not None:
        return start
    top = _way_out(world, pad)
    return start if top is None or not nominal.segments_free(start, top)[0] else top


def why_no_pad(nominal: World, world: World, uav: int, place: tuple[float, float, float]) -> str | None:
    """Return the end of a sentence that says why a UAV cannot take off from a safe place, or ``None`` if it can."""
    pad = _pad(world, uav, place)
    if pad is None or world.free(place)[0] or lifted(nominal, world, uav, place)[2] > place[2]:
        return None
    error, reason = world.error, _too_near(world, pad)
    if reason is None:
        return (
            f"has nothing above it, up to z = {pad.top:.6g} m, from where the UAV may stray by its tracking error of "
            f"{error.horizontal:g} m horizontally and {error.vertical:g} m vertically"
        )
    return (
        f"{reason}: all but what it stands on must keep the tracking error of {error.horizontal:g} m horizontally and "
        f"{error.vertical:g} m vertically from its pad, {pad.radius:g} m about it and up to z = {pad.top:.6g} m"
    )


def _pad(world: World, uav: int, place: tuple[float, float, float]) -> Pad | None:
    return pad_at(world.scenario, uav, place, world.least_height(place))


def _way_out(world: World, pad: Pad) -> Floats | None:
    """Return the lowest place above that of a pad, up to its top, from which a UAV may stray, or ``None``."""
    top = np.array(pad.place)
    for _ in range(MAX_EXITS):
        above = world.way_out_above(top)
        if above is None or above + PAD_LIFT > pad.top:
            return None
        top[2] = max(above, top[2]) + PAD_LIFT
        if world.free(top)[0]:
            return top
    return None


def _too_near(world: World, pad: Pad) -> str | None:
    """Return what is too near a pad beside what the UAV stands on, in words, or ``None`` if nothing is."""
    around = world.about_pads
    if around.is_steep_about(pad.place):
        return "is too near ground that is steeper than 45 degrees"
    others = around.without_support(pad.place, pad.place[2] - world.clearance + SURFACE_DEPTH)
    axis = np.array([pad.place, (*pad.place[:2], pad.top)])
    if others.segments_free(*axis)[0]:
        return None
    beyond = float(np.maximum(others.space.low - axis, axis - others.space.high).max())
    if beyond > 0:
        return f"is {beyond:.3g} m too near the bounds"
    places = np.linspace(axis[0], axis[1], PLACES)
    place = places[others.distance(places).argmin()]
    number = others.blocker(place)
    if number is None:
        return next((why for why in map(others.why_unsafe, places) if why is not None), "is too near something")
    near, far = 0.0, others.clearance + others.error.horizontal + float(np.ptp(axis[:, 2]))
    for _ in range(HALVINGS):  # of the metres by which it is too near
        middle = (near + far) / 2
        near, far = (near, middle) if others.blocker(place, -middle) is None else (middle, far)
    return f"is {far:.3g} m too near {others.named(number)}"


def fleet_pads(mission: Mission) -> list[FleetPad]:
    """Return the pads of a mission's fleet on which a tracking error matters, at starts and targets."""
    scenario = mission.scenario
    worlds: dict[TrackingError, World] = {}
    found = []
    for number, uav in enumerate(scenario.uavs):
        visits = [visit.target for sortie in mission.sorties_of(number) for visit in sortie.visits]
        visits = visits or [target for target in mission.assignment[number : number + 1] if target is not None]
        places = {"its start": uav.start}
        for target in (scenario.targets[visit] for visit in visits):
            places["its target" if len(visits) == 1 else target.name] = target.position
        for end, place in places.items():
            if uav.tracking_error == NO_ERROR or uav.fixed_wing is not None:
                continue
            for error in {NO_ERROR, uav.tracking_error} - worlds.keys():
                worlds[error] = World(scenario, error)
            world = worlds[uav.tracking_error]
            pad = _pad(world, number, place)
            if pad is not None and lifted(worlds[NO_ERROR], world, number, place)[2] > place[2]:
                found.append(FleetPad(number, end, pad))
    return found


def pads_sentence(scenario: Scenario, pads: Sequence[FleetPad]) -> str:
    """Return a sentence that names the pads of a fleet; empty where there are none."""
    told = []
    for number in dict.fromkeys(one.uav for one in pads):
        own = [f"at {one.end} up to z = {one.pad.top:.4g} m" for one in pads if one.uav == number]
        told.append(f"{scenario.uavs[number].name} {' and '.join(own)}")
    if not told:
        return ""
    rest = len(told) - MAX_NAMED
    more = f"; and of {counted(rest, 'more UAV')}" if rest > 0 else ""
    return (
        "On the pads at starts and targets the tracking error does not count for the ground and roofs below: "
        f"of {'; of '.join(told[:MAX_NAMED])}{more}."
    )
