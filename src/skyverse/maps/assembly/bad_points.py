"""Starts and targets that cannot be where they are: all are named at once, with the roof's height and a free place."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from skyverse.errors import InputError, Remedy
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Bounds, Scenario

Point = tuple[float, float, float]

ROUNDING = 0.1
"""Metres: free places keep so much more from everything, so that they stay free when they are rounded."""


@dataclass(frozen=True)
class BadPoint:
    """A start or target that is too low, too high, or in an obstacle.

    Attributes
    ----------
    name
        That of its UAV or target.
    point
        x, y, z in the local frame, metres.
    text
        What was expected of it, and what was found.
    roof
        The z at which what it lies in ends; ``None`` where it lies in nothing.
    give
        Parameters of which any one helps.
    """

    name: str
    point: Point
    text: str
    roof: float | None = None
    give: tuple[Remedy, ...] = ()


def refuse_bad_points(found: Sequence[BadPoint], scenario: Scenario) -> None:
    """Raise `InputError` that names all points of a scenario that cannot be where they are, if there are any."""
    if not found:
        return
    from skyverse.space.unsafe_points import nearest_free  # it compiles kernels, which nothing else here needs
    from skyverse.space.world import World

    low, high = scenario.bounds.min, scenario.bounds.max
    inner = Bounds(min=_moved(low, ROUNDING), max=_moved(high, -ROUNDING))
    world = World(scenario.model_copy(update={"clearance": scenario.clearance + ROUNDING, "bounds": inner}))
    worst = {(bad.name, bad.point): bad for bad in sorted(found, key=lambda bad: bad.roof or -math.inf)}
    sentences = []
    for bad in dict.fromkeys(worst[bad.name, bad.point] for bad in found):
        roof = "" if bad.roof is None else f", whose roof is at {_height(scenario, (*bad.point[:2], bad.roof))}"
        place = nearest_free(world, bad.point)
        hint = "no place here is free" if place is None else f"the nearest free place is {_told(scenario, bad, place)}"
        sentences.append(f"{bad.name}: {bad.text}{roof}; {hint}")
    refuse_all(sentences, tuple(dict.fromkeys(remedy for bad in found for remedy in bad.give)))


def refuse_all(sentences: Sequence[str], give: Sequence[Remedy] = ()) -> None:
    """Raise `InputError` of one sentence, or of several, each on a line of its own; do nothing where there is none."""
    if len(sentences) == 1:
        raise InputError(sentences[0], give=give)
    if sentences:
        heading = f"{len(sentences)} starts and targets cannot be where they are:"
        raise InputError("\n  ".join([heading, *sentences]), give=give)


def _moved(corner: Point, metres: float) -> Point:
    x, y, z = (value + metres for value in corner)
    return x, y, z


def _height(scenario: Scenario, point: Point) -> str:
    """Return a point's altitude above the sea, and above the ground where that is known."""
    assert scenario.frame.origin is not None
    sea = f"{to_wgs84(scenario.frame.origin, [point])[0, 2]:.1f} m amsl"
    if scenario.terrain is None:
        return sea
    return f"{sea} ({point[2] - float(scenario.terrain.height(point[:2])):.1f} m agl)"


def _told(scenario: Scenario, bad: BadPoint, place: Point) -> str:
    """Return a free place as a user writes places, and how far away it is."""
    assert scenario.frame.origin is not None
    latitude, longitude, sea = to_wgs84(scenario.frame.origin, [place])[0].tolist()
    written = f"{sea:.1f} m amsl"
    if scenario.terrain is not None:
        written = f"{math.ceil(10 * (place[2] - float(scenario.terrain.height(place[:2])))) / 10:g} m agl"
    return f"{latitude:.7f},{longitude:.7f},{written}, {math.dist(place, bad.point):.3g} m away"
