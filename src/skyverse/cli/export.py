"""``skyverse export``: a mission as a file that other software opens."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter

from skyverse.cli.given_scenario import judging_scenario
from skyverse.cli.option_types import FLAG, SIGNED, GivenMission, GivenScenario
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import origin_of
from skyverse.cli.report import say, table
from skyverse.errors import InputError
from skyverse.model.short_lines import counted

if TYPE_CHECKING:
    from skyverse.exports import ExportCertificate


@Parameter(name="*")
@dataclass(frozen=True)
class PlaceOptions:
    """Where the mission is, and how it is sampled.

    Attributes
    ----------
    altitude
        What altitudes are counted from: mean sea level, the ground below the UAV's start, or that below the UAV.
    origin
        Where the scenario's zero lies: latitude,longitude,altitude (amsl), as in `47.39,8.54,410 m amsl`.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres; .geojson and .wpml.kmz (amsl) need it.
    rate
        Samples a second, in formats that are sampled.
    """

    altitude: Literal["amsl", "home", "agl"] = "amsl"
    origin: Annotated[str | None, SIGNED] = None
    geoid: Annotated[float | None, SIGNED] = None
    rate: float | None = None


@Parameter(name="*", group=Group("Waypoints (.plan, .waypoints, .wpml.kmz, .litchi.csv)"))
@dataclass(frozen=True)
class WaypointOptions:
    """How waypoints are flown.

    Attributes
    ----------
    radius
        The acceptance radius of waypoints at first, metres; it is halved until all legs are proven clear.
    takeoff
        In .plan and .waypoints, metres above home to climb to first; fewer where obstacles are above.
    end
        Whether a UAV stays at the target (loiter; one that ends at home lands there), lands below it, on the ground or
        an obstacle, or returns and lands at home.
    return_altitude
        Metres above home at which UAVs return by themselves, unless they are higher. When left out, each at another
        altitude, a separation apart, where there is room: at 30 m or the next that is proven.
    autopilot
        What flies the waypoints: px4 or ardupilot (.plan, .waypoints) or dji (.wpml.kmz, .litchi.csv). By default
        .plan is for px4, or for ardupilot with --altitude agl, and .waypoints for ardupilot.
    apart_in_space
        Refuse paths that are not apart in space, so that UAVs keep apart whatever the timing.
    survey_item
        In .plan, show the photos of an area as QGroundControl's own survey item, if it has one part and no holes;
        editing it there loses the proof.
    """

    radius: float = 2.0
    takeoff: float = 3.0
    end: Literal["loiter", "land", "rtl"] = "loiter"
    return_altitude: float | None = None
    autopilot: Literal["px4", "ardupilot", "dji"] | None = None
    apart_in_space: Annotated[bool, FLAG] = False
    survey_item: Annotated[bool, FLAG] = False


_PLACE, _WAYPOINTS = PlaceOptions(), WaypointOptions()


def export(
    mission: GivenMission,
    output: Path,
    /,
    *,
    scenario: GivenScenario | None = None,
    place: PlaceOptions = _PLACE,
    waypoints: WaypointOptions = _WAYPOINTS,
    allow_close: Annotated[bool, FLAG] = False,
    page: Path | None = None,
    details: Annotated[bool, FLAG] = False,
) -> None:
    """Export a mission to ground stations, maps, robots and light shows; the file's ending tells which.

    The referee judges the mission first, and what it refutes is not exported.

    Waypoints for an autopilot, one file for each UAV, with straight legs that are proven clear: QGroundControl .plan,
    Mission Planner .waypoints, DJI .wpml.kmz, Litchi .litchi.csv. Paths on the globe: Google Earth .kml and .kmz,
    .geojson, .gpx, .geo.csv.
    Robots: ROS .path.json, .path.yaml, .trajectory.json, .trajectory.yaml. Light shows: Skybrush .skybrush.zip. Tables:
    waypoints .waypoints.csv, sampled trajectories .csv.

    Examples: `skyverse export out/city.json city.plan --scenario city.yaml`,
    `skyverse export out/map1.json map1.csv --rate 50`,
    `skyverse export out/map1.json map1.kmz --origin "47.39,8.54,410 m amsl"`,
    `skyverse export out/fleet.json fleet.waypoints --apart-in-space --end rtl`

    Parameters
    ----------
    mission
        A mission file.
    output
        The file to write; its ending tells the format.
    scenario
        The scenario that the mission has to answer, a file or a built-in name: a mission that embeds another one is
        refused. Without it, the mission is judged by the scenario that it embeds, whoever wrote that.
    allow_close
        Export even if UAVs come too close to each other, as planned or as their autopilots fly waypoints.
    page
        A web page to write as well, .html: the mission, where UAVs land when they return, and what is proven of
        their waypoints.
    details
        Print all that is proven of waypoints, too: legs, returns and landing places of each UAV, and pairs of UAVs.
    """
    import skyverse as sky
    from skyverse.exports import verdict_table
    from skyverse.model.caution import stands_out, urgency
    from skyverse.model.frame import require_geoid
    from skyverse.space.mission_cautions import mission_cautions

    read = sky.read_mission(mission)
    refuse_output(output, mission)
    if page is not None:
        if page.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"--page: expected a file ending in .html, found {str(page)!r}")
        refuse_output(page, mission)
    world, judged_by = judging_scenario(read, scenario)
    at = read.scenario.frame.origin if place.origin is None else origin_of(place.origin)
    if at is not None and place.geoid is not None:
        require_geoid(place.geoid)
        at = at.model_copy(update={"geoid": place.geoid})
    notes: list[str] = []
    proven: list[ExportCertificate] = []
    how = sky.ExportOptions(
        altitude=place.altitude, origin=at, rate=place.rate, allow_close=allow_close, **vars(waypoints)
    )
    files = sky.export(read, output, how, scenario=world, page=page, on_note=notes.append, on_certificate=proven.append)
    for certificate in proven:
        table(*verdict_table(certificate.flights), aside=True)
    told = {caution.sentence for caution in mission_cautions(read)}  # when it was planned
    notes = [note for note in notes if note not in told]
    rest = [note for note in notes if not stands_out(note)]
    say(*sorted(filter(stands_out, notes), key=urgency), aside=True)
    sys.stderr.flush()
    for path in files:
        print(path, flush=True)
    if proven and place.rate is not None:
        print("Without effect on waypoints: --rate (.csv, .kml and others are sampled).", file=sys.stderr)
    if proven and not details:
        rest = [f"--details tells all that is proven: {counted(len(rest), 'line')}."] if rest else []
    say(*rest, judged_by, aside=True)
