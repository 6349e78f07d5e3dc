"""Where missions are flown: a scenario made of maps around their places, or one that is given, with a UAV for each."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilots import AutopilotName
from skyverse.maps.assembly.build import build_scenario, outdoor_limits
from skyverse.maps.assembly.fences import Rule, fence_area, fence_around, fence_circle
from skyverse.maps.assembly.options import BuildOptions
from skyverse.maps.assembly.places import highest_ground
from skyverse.maps.georeference.feature import SWAPPED
from skyverse.maps.georeference.reading import Raster
from skyverse.maps.readers.raster import open_raster
from skyverse.model.altitude import AboveSea
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.frame import MAX_FAR
from skyverse.model.geodesy import to_local
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario, Source
from skyverse.model.short_lines import listed
from skyverse.model.uav import UAV, with_limits
from skyverse.model.waypoints import OrderKind, Waypoints
from skyverse.waypoints.defaults import USUAL_CIRCLE, home_of
from skyverse.waypoints.flown import flown

ROOM, AROUND = 200.0, 30.0
"""Metres that maps are read around the places of missions, where they reach that far, and at least."""
WIDE = 100.0
"""Metres that the maps are read around a mission for which another way is sought."""
METRES_PER_DEGREE = 111_000.0
TALL = 9_000.0
"""Metres above the sea at which the bounds end until it is known how high is flown."""
FENCE_REACH = 50.0
"""Metres that a fence is thick around the bounds."""
SAME_HOME = 1.0
"""Metres between a UAV's start and a mission's home at which they are the same."""
_FLOWN_TO = (OrderKind.TAKEOFF, OrderKind.WAYPOINT, OrderKind.LOITER, OrderKind.LAND)


@dataclass(frozen=True, eq=False)
class Site:
    """Where missions are flown.

    Attributes
    ----------
    scenario
        With a UAV for each mission.
    homes
        (3,) metres: where each of them stands before it takes off.
    grounds
        Metres above the sea of the ground there by the terrain; ``None`` where none is known.
    assumed
        What was taken from defaults, in words.
    """

    scenario: Scenario
    homes: tuple[Floats, ...]
    grounds: tuple[float | None, ...]
    assumed: tuple[str, ...]


def built_site(missions: Sequence[Waypoints], options: BuildOptions, settings: FlightSettings) -> Site:
    """Return the site of missions, made of maps; without an area, it is what lies around their places."""
    homes = [home_of(one, settings) for one in missions]
    assumed, known = [], [_altitude_of_home(one, settings) for one in missions]
    grounds: list[float | None] = [None] * len(missions)
    if options.terrain:
        grounds = list(_covered_homes(missions, options, homes))
    elif options.ground is None:
        if None in known:
            told = missions[known.index(None)].name
            said = f"{told}: expected a terrain, or the altitude of level ground, as it does not say how high home is"
            raise InputError(said, field="ground", give=[Remedy("terrain"), Remedy("ground")])
        level = min(one for one in known if one is not None)
        options = replace(options, ground=AboveSea(level))
        assumed.append(f"without a terrain, the ground is taken to be level, {level:.1f} m above the sea as home")
    scenario = _with_room(missions, homes, replace(options, ceiling=options.ceiling or AboveSea(TALL)))
    origin = scenario.frame.origin
    assert origin is not None
    level = 0.0 if options.ground is None else options.ground.metres
    altitudes = [level if ground is None else ground for ground in grounds]
    places = to_local(origin, [[*home, z] for home, z in zip(homes, altitudes, strict=True)])
    if options.vehicle is None and options.max_speed is None:  # of no vehicle it is known that it is too slow
        told_speeds = (settings.speed, *(speed for one in missions for speed in _speeds(one)))
        options = replace(options, max_speed=max((one for one in told_speeds if one is not None), default=None))
    limits = outdoor_limits(options)
    if options.vehicle is None and options.tracking_error is None and limits.tracking_error is not None:
        aside, up = limits.tracking_error
        assumed.append(f"no vehicle is named: it may stray {aside:g} m aside and {up:g} m up and down in calm air")
    uavs = [
        with_limits(UAV(name=name, start=(x, y, z + 1.0), home=z), limits)
        for name, (x, y, z) in zip(_names(missions), places.tolist(), strict=True)
    ]
    return Site(derived(scenario, uavs=tuple(uavs)), tuple(places), tuple(grounds), tuple(assumed))


def same_site(missions: Sequence[Waypoints], others: Sequence[Waypoints], settings: FlightSettings) -> bool:
    """Tell whether missions are flown at the site of others: from the same homes, and within the same area."""
    each = [[home_of(one, settings) for one in some] for some in (missions, others)]
    same = each[0] == each[1] and [one.home for one in missions] == [one.home for one in others]
    return same and _area(missions, each[0], AROUND) == _area(others, each[1], AROUND)


def _with_room(missions: Sequence[Waypoints], homes: Sequence[tuple[float, float]], options: BuildOptions) -> Scenario:
    """Return the scenario of maps around missions, with room for ways around them if the maps reach that far."""
    options = replace(options, uavs=(), targets=())
    if options.area is not None:
        return build_scenario(options)
    try:
        return build_scenario(replace(options, area=_area(missions, homes, ROOM)))
    except InputError:
        return build_scenario(replace(options, area=_area(missions, homes, AROUND)))


def options_of_mission(waypoints: Waypoints, options: BuildOptions) -> BuildOptions:
    """Return the options of a scenario with the area of a mission, its first and its last place, and its speed.

    What the options give themselves stays.
    """
    require_near(waypoints, FlightSettings())
    home = home_of(waypoints, FlightSettings())
    places = [order for order in waypoints.orders if order.kind in _FLOWN_TO and order.place is not None]
    first = next((order.place for order in places if order.place is not None), None)
    ends = [order.place for order in places if order.kind is not OrderKind.LAND and order.place is not None]
    last = next((place for place in reversed(ends) if np.isfinite(place[:2]).all() and any(place[:2])), None)
    if first is None or last is None:
        raise InputError(f"{waypoints.name}: expected places to fly to, found none")
    area = options.area or _area([waypoints], [home], options.margin or WIDE)
    return replace(
        options,
        uavs=options.uavs or {_names([waypoints])[0]: (*home, first[2])},
        targets=options.targets or {"end of the mission": last},
        area=area,
        margin=None,
        max_speed=options.max_speed or waypoints.speed,
    )


def with_mission(scenario: Scenario, waypoints: Waypoints) -> Scenario:
    """Return a scenario of `options_of_mission` that knows how far and how long the mission flies."""
    (uav, *_) = scenario.uavs
    home = np.array([*uav.start[:2], uav.home if uav.home is not None else uav.start[2]])
    plan = flown(waypoints, scenario, 0, home, FlightSettings()).plan
    length = float(np.linalg.norm(np.diff(plan.waypoints, axis=0), axis=1).sum())
    seconds = float(plan.arrivals[-1] - plan.arrivals[0])
    if length <= 0 or seconds <= 0:
        return scenario
    told = Source(file=Path(waypoints.name).name, gives="mission", flown=(length, seconds))
    return derived(scenario, sources=(*scenario.sources, told))


def given_site(missions: Sequence[Waypoints], scenario: Scenario, settings: FlightSettings) -> Site:
    """Return the site of missions in a scenario that is given; UAVs that start at the same homes keep their limits."""
    origin = scenario.frame.origin
    if origin is None:
        said = f"{scenario.name}: expected a scenario that says where its zero lies, found none"
        raise InputError(said, field="origin")
    uavs, homes, grounds = [], [], list[float | None]()
    for name, one in zip(_names(missions), missions, strict=True):
        ((x, y, _),) = to_local(origin, [[*home_of(one, settings), 0.0]]).tolist()
        own = next((uav for uav in scenario.uavs if np.hypot(uav.start[0] - x, uav.start[1] - y) <= SAME_HOME), None)
        known = _altitude_of_home(one, settings)
        if own is not None and own.home is not None:
            z = own.home
        elif scenario.terrain is not None:
            z = float(scenario.terrain.lowest_ground.height((x, y)))
        elif own is not None:
            z = own.start[2]
        elif known is not None:
            z = known - origin.altitude
        else:
            z = scenario.bounds.min[2]
        like = own or (scenario.uavs[0] if scenario.uavs else UAV(start=(x, y, z)))
        uavs.append(derived(like, name=name, start=(x, y, z + 1.0), home=z))
        homes.append(np.array([x, y, z]))
        grounds.append(None if scenario.terrain is None else z + origin.altitude)
    return Site(derived(scenario, uavs=tuple(uavs), targets=()), tuple(homes), tuple(grounds), ())


def with_height(scenario: Scenario, top: float) -> Scenario:
    """Return a scenario of `built_site` whose bounds end at z = `top`, metres, or where they end already."""
    low, (x, y, z) = scenario.bounds.min, scenario.bounds.max
    return derived(scenario, bounds=Bounds(min=low, max=(x, y, min(z, max(top, low[2] + 1.0)))))


def with_fence(scenario: Scenario, waypoints: Waypoints, autopilot: AutopilotName) -> Scenario:
    """Return a scenario with the fence of a mission's file, which binds its vehicle alone.

    Of several areas to stay in, ArduPilot has to be in all of them, and PX4, until 2025, in any.
    """
    fence, origin = waypoints.fence, scenario.frame.origin
    if not fence:
        return scenario
    assert origin is not None
    where = f"{waypoints.name}: geofence"
    inside, outside = (
        [
            *(one for ring in rings for one in fence_area(np.array(ring)[:, ::-1], (), where, outside=out)),
            *(one for y, x, radius in circles for one in fence_circle(x, y, radius, where, outside=out)),
        ]
        for out, rings, circles in (
            (False, fence.inside, fence.circles_inside),
            (True, fence.outside, fence.circles_outside),
        )
    )
    rule: Rule = "intersection" if autopilot == "ardupilot" else "union"
    reach = FENCE_REACH + scenario.clearance
    around = fence_around(inside, origin, scenario.bounds, rule=rule, outside=outside, reach=reach)
    return derived(scenario, obstacles=(*scenario.obstacles, *around.prisms))


def _names(missions: Sequence[Waypoints]) -> list[str]:
    """Return a name for each mission: its file's, numbered where several have it."""
    stems = [Path(one.name).name.partition(".")[0] or "mission" for one in missions]
    return [stem if stems.count(stem) == 1 else f"{stem}-{k}" for k, stem in enumerate(stems, 1)]


def _speeds(waypoints: Waypoints) -> list[float | None]:
    """Return all speeds of a mission, m/s, where it says any."""
    return [waypoints.speed, *(order.speed for order in waypoints.orders)]


def _altitude_of_home(waypoints: Waypoints, settings: FlightSettings) -> float | None:
    """Return the altitude of home that a file states, unless home is another one."""
    return None if settings.home is not None or waypoints.home is None else waypoints.home[2]


def _places(waypoints: Waypoints) -> list[tuple[int, float, float]]:
    """Return the number, latitude and longitude of each order that leads somewhere else."""
    placed = [(order.number, *order.place[:2]) for order in waypoints.orders if order.place and order.kind in _FLOWN_TO]
    return [one for one in placed if np.isfinite(one[1:]).all() and any(one[1:])]


def require_near(waypoints: Waypoints, settings: FlightSettings) -> None:
    """Raise `InputError` for a place, or a circle, that reaches farther from home than a scenario does."""
    home = home_of(waypoints, settings)
    radii = {order.number: order.radius or 0.0 for order in waypoints.orders if order.turns}

    def away(latitude: float, longitude: float) -> float:
        north, east = latitude - home[0], (longitude - home[1] + 180) % 360 - 180
        return METRES_PER_DEGREE * float(np.hypot(north, east * np.cos(np.radians(home[0]))))

    for number, latitude, longitude in _places(waypoints):
        far, radius = away(latitude, longitude), radii.get(number, 0.0)
        if far + radius > MAX_FAR:
            hint = SWAPPED if abs(longitude) <= 90 and away(longitude, latitude) <= MAX_FAR else ""
            found = f"latitude {latitude:g}, longitude {longitude:g}, {far / 1000:,.0f} km away{hint}"
            raise InputError(
                f"{waypoints.name}: item {number}: expected a place within {MAX_FAR / 1000:g} km of home, latitude "
                f"{home[0]:g}, longitude {home[1]:g}, found "
                f"{found if far > MAX_FAR else f'a circle of {radius / 1000:,.0f} km around one'}",
                give=[Remedy("home", None, "if home is elsewhere")] if far > MAX_FAR else (),
            )


def _area(
    missions: Sequence[Waypoints], homes: Sequence[tuple[float, float]], margin: float
) -> tuple[float, float, float, float]:
    """Return west, south, east and north of all places, and of what is around them by a margin, metres; degrees."""
    places = np.array([*homes, *(one[1:] for mission in missions for one in _places(mission))])
    circles = [order.radius or USUAL_CIRCLE for one in missions for order in one.orders if order.turns]
    around = (margin + max(circles, default=0.0)) / METRES_PER_DEGREE
    east = (places[:, 1] - places[0, 1] + 180) % 360 - 180 + places[0, 1]  # across the antimeridian
    south, north = places[:, 0].min() - around, places[:, 0].max() + around
    aside = around / max(np.cos(np.radians(max(abs(south), abs(north)))), 0.01)
    west, most = east.min() - aside, east.max() + aside
    return _turned(west), float(south), _turned(most), float(north)


def _turned(longitude: float) -> float:
    """Return a longitude from -180 to 180 degrees."""
    return float((longitude + 180) % 360 - 180)


def _covered_homes(
    missions: Sequence[Waypoints], options: BuildOptions, homes: Sequence[tuple[float, float]]
) -> list[float]:
    """Return the ground at each home, metres above the sea; raise `InputError` for places that no terrain covers."""
    rasters = [one if isinstance(one, Raster) else Raster(one) for one in options.terrain]
    with ExitStack() as stack:
        files = [stack.enter_context(open_raster(raster)) for raster in rasters]

        for mission, home in zip(missions, homes, strict=True):
            places = [(0, *home), *_places(mission)]
            heights = highest_ground([one[1:] for one in places], files, options.geoid)
            missing = [one for one, height in zip(places, heights, strict=True) if np.isnan(height)]
            if missing:
                names = ", ".join(file.path for file in files)
                which = listed([str(number) if number else "home" for number, *_ in missing[:6]])
                more = f" and {len(missing) - 6} more" if len(missing) > 6 else ""
                south, west = np.min([one[1:] for one in missing], axis=0)
                north, east = np.max([one[1:] for one in missing], axis=0)
                raise InputError(
                    f"{names}: expected heights at all places of {mission.name}, found none at {which}{more}: between "
                    f"latitude {south:.5f} and {north:.5f}, longitude {west:.5f} and {east:.5f}",
                    field="terrain",
                )
        return highest_ground(homes, files, options.geoid).tolist()
