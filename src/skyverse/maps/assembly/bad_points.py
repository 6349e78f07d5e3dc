"""Starts and targets that cannot be where they are: all are named at once, with the roof's height and a free place.

Points from which nothing could be planned, or to which nothing could, are among them, and ends too near to one another.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.model.altitude import AboveSea, Altitude
from skyverse.model.geodesy import to_wgs84
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.short_lines import told_metres
from skyverse.model.uav import kept_ellipsoid

Point = tuple[float, float, float]

FORGIVEN = 1e-6
"""Share of the separation by which two points may be too close, as far as numbers are rounded."""


class EndsApart:
    """The starts of a fleet, and its targets, each of which must keep the separation from the others of its sort.

    Where there are more targets than UAVs, not all of them are flown to, and any of them may be close to each other.

    Parameters
    ----------
    scenario
        The fleet, whose UAVs all have the same limits.
    """

    def __init__(self, scenario: Scenario) -> None:
        uavs, targets = scenario.uavs, scenario.targets
        aside, up = kept_ellipsoid(uavs[0], uavs[0]) if uavs else (0.0, 0.0)
        self._kept = np.array([aside, aside, up])
        self._starts = {uav.name: uav.start for uav in uavs}
        self._targets = {target.name: target.position for target in targets} if len(targets) <= len(uavs) else {}

    def close(self) -> Iterator[tuple[str, Point, str]]:
        """Yield each start or target that is too near to one before it: its name, the point, and what is wrong."""
        if not self._kept.all():
            return
        aside, _, up = self._kept
        for noun, ends in (("start", self._starts), ("target", self._targets)):
            names, points = list(ends), np.array(list(ends.values())).reshape(-1, 3)
            for k in range(1, len(names)):
                shares = np.linalg.norm((points[:k] - points[k]) / self._kept, axis=1)
                j = int(shares.argmin())
                if shares[j] >= 1.0 - FORGIVEN:
                    continue
                away = math.dist(points[j], points[k])
                yield (
                    names[k],
                    ends[names[k]],
                    f"expected a {noun} at least {aside:.3g} m from that of {names[j]} at one height, or {up:.3g} m "
                    "above or below it (the separation, counting the tracking errors of both), found it "
                    f"{f'{told_metres(away)} away' if away else 'at the same place'}",
                )

    def apart(self, name: str, at: Point, points: Floats, margin: float) -> NDArray[np.bool_]:
        """Tell for each of (m, 3) points whether an end may move there without coming too near to another one.

        Parameters
        ----------
        name, at
            The end's name, and where it is.
        points
            Metres.
        margin
            Metres to keep besides.
        """
        found = np.ones(len(points), dtype=bool)
        ends = next((ends for ends in (self._starts, self._targets) if ends.get(name) == at), {})
        if self._kept.all():
            for other, place in ends.items():
                if other != name:
                    found &= np.linalg.norm((points - place) / (self._kept + margin), axis=1) >= 1.0
        return found

    def move(self, name: str, at: Point, place: Point) -> None:
        """Take note of the place to which an end is to be moved, so that the others keep away from there."""
        for ends in (self._starts, self._targets):
            if ends.get(name) == at:
                ends[name] = place
                return


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
