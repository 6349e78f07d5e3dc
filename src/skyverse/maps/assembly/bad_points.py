"""Starts and targets that cannot be where they are: all are named at once, with the roof's height and a free place.

Points from which nothing could be planned, or to which nothing could, are among them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from skyverse.errors import InputError, Remedy
from skyverse.maps.assembly.close_ends import EndsApart, Point
from skyverse.model.altitude import AboveSea, Altitude
from skyverse.model.geodesy import to_wgs84
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.short_lines import told_metres

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


def refuse_bad_points(found: Sequence[BadPoint], scenario: Scenario, altitudes: Mapping[Point, Altitude]) -> None:
    """Raise `InputError` that names all points of a scenario that cannot be where they are, if there are any.

    Parameters
    ----------
    found
        Those that are known already, from the maps.
    scenario
        The scenario, whose points must also be safe for its UAVs to start from and to arrive at, and apart.
    altitudes
        The altitude that the user gave of each point.
    """
    worst = {(bad.name, bad.point): bad for bad in sorted(found, key=lambda bad: bad.roof or -math.inf)}
    known = list(dict.fromkeys(worst[bad.name, bad.point] for bad in found))
    ends, named = EndsApart(scenario), set(worst)
    for name, point, text in [*_unsafe(scenario), *ends.close()]:
        if (name, point) not in named:
            named.add((name, point))
            known.append(BadPoint(name, point, text))
    if known:
        sentences = _sentences(known, scenario, ends, altitudes)
        refuse_all(sentences, tuple(dict.fromkeys(remedy for bad in found for remedy in bad.give)))


def _unsafe(scenario: Scenario) -> list[tuple[str, Point, str]]:
    """Return the name of each point that is not safe, the point, and what is wrong with it."""
    if not (scenario.uavs or scenario.targets):
        return []
    from skyverse.space.unsafe_points import unsafe_points  # it compiles kernels, which nothing else here needs

    return [
        (bad.name, bad.position, f"expected a safe point, found one that {bad.reason}")
        for bad in unsafe_points(scenario)
    ]


def _sentences(
    known: Sequence[BadPoint], scenario: Scenario, ends: EndsApart, altitudes: Mapping[Point, Altitude]
) -> list[str]:
    """Return what is wrong with each point, and a place for it that is free and apart from the others."""
    from skyverse.space.unsafe_points import SafePlaces, free_place_noun

    places, noun = SafePlaces(_narrowed(scenario)), free_place_noun(scenario.uavs)
    sentences = []
    for bad in known:
        roof = "" if bad.roof is None else f", whose roof is at {_height(scenario, (*bad.point[:2], bad.roof))}"
        place = places.nearest(bad.point, partial(ends.apart, bad.name, bad.point, margin=ROUNDING))
        if place is None:
            hint = "no place here is free"
        else:
            ends.move(bad.name, bad.point, place)
            hint = f"{noun} is {_told(scenario, bad, place, altitudes.get(bad.point))}"
        sentences.append(f"{bad.name}: {bad.text}{roof}; {hint}")
    return sentences


def _narrowed(scenario: Scenario) -> Scenario:
    """Return a scenario in which everything keeps `ROUNDING` more from everything."""
    low, high, ground, most = scenario.bounds.min, scenario.bounds.max, scenario.terrain, scenario.max_height
    if ground is not None and ground.clearance is not None:
        ground = derived(ground, clearance=ground.clearance + ROUNDING)
    return derived(
        scenario,
        clearance=scenario.clearance + ROUNDING,
        bounds=Bounds(min=_moved(low, ROUNDING), max=_moved(high, -ROUNDING)),
        max_height=None if most is None else most - ROUNDING,
        terrain=ground,
    )


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
    sea = f"{point[2] + scenario.frame.origin.altitude:.1f} m amsl"
    if scenario.terrain is None:
        return sea
    return f"{sea} ({point[2] - float(scenario.terrain.height(point[:2])):.1f} m agl)"


def _told(scenario: Scenario, bad: BadPoint, place: Point, given: Altitude | None) -> str:
    """Return a free place as a user writes places, its altitude counted as it was given, and how far away it is.

    An altitude above home, which would be another one there, is told above ground.
    """
    assert scenario.frame.origin is not None
    latitude, longitude, sea = to_wgs84(scenario.frame.origin, [place])[0].tolist()
    written = f"{sea:.1f} m amsl"
    if scenario.terrain is not None and not isinstance(given, AboveSea):
        written = f"{round(place[2] - float(scenario.terrain.height(place[:2])), 1):g} m agl"
    return f"{latitude:.7f},{longitude:.7f},{written}, {told_metres(math.dist(place, bad.point))} away"
