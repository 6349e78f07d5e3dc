"""What is told of judged missions: a table for each, a line for each thing that is wrong, data, and a page."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from skyverse.draw import LandingPlace
from skyverse.exports.separation import Apart
from skyverse.model.caution import Caution
from skyverse.model.flight_table import told_energy
from skyverse.model.short_lines import counted, told_metres, told_seconds
from skyverse.waypoints.check import CheckedMission, Height, MissionFinding, Subject
from skyverse.waypoints.fleet import CheckedFleet

PROVEN, NOT = "proven", f"{Caution.NOT} proven"
KEPT = {Apart.SPACE: "in space", Apart.TIMING: "by timing", Apart.SCHEDULE: f"{Caution.ONLY} on schedule"}
MAX_RANGE = 3
"""Numbers of items that are told one by one; of more the first and the last."""


def check_table(fleet: CheckedFleet, number: int) -> list[tuple[str, str]]:
    """Return the rows of the table of one mission: what was judged, and what is found."""
    mission, scenario = fleet.missions[number], fleet.scenario
    flown, route = mission.flown, mission.flown.plan.route
    legs, corners = flown.legs, int(((route.waypoint_radii > 0) & (route.waypoint_holds == 0))[1:-1].sum())
    rows = [
        ("take-off", _verdict(mission, Subject.TAKEOFF, 1)),
        ("legs", _verdict(mission, Subject.LEGS, legs)),
        ("corners", _verdict(mission, Subject.CORNERS, corners) + _radii(route.waypoint_radii)),
        ("end", f"{_end(mission)}: {NOT if mission.of(Subject.END) else PROVEN}"),
        ("way home", _way_home(mission)),
    ]
    if mission.lowest is not None and mission.highest is not None:
        heights = f"{_height(mission.lowest)} at least, {_height(mission.highest)} at most"
        rows.append(("height above ground", heights))
    met = [finding.what for finding in mission.findings if finding.wrong]
    if scenario.max_height is not None:
        rows.append(("ceiling", f"{scenario.max_height:g} m above ground: {_kept(met.count('ceiling'))}"))
    zones = sum(what not in ("ground", "ceiling", "bounds", "") for what in met if not what.startswith("building"))
    rows.append(("fence and zones", _kept(zones) if flown.waypoints.fence or scenario.obstacles else "none"))
    rows.append(("bounds", _kept(met.count("bounds"))))
    summary = mission.summary
    energy = "" if summary.energy is None else f", about {told_energy(summary.energy)}"
    rows.append(("flight", f"{told_seconds(summary.time)}, {told_metres(summary.length)}{energy}"))
    if mission.photos is not None:
        rows.append(("photos", f"{mission.photos:,} by distance"))
    rows.append(("limits", "kept" if not mission.of(Subject.LIMITS) else f"{Caution.NOT} kept"))
    others = [(pair, kind) for pair, kind in fleet.apart.pairs.items() if number in pair]
    for (first, second), kind in others:
        other = scenario.uavs[second if first == number else first].name
        rows.append((f"apart from {other}", KEPT.get(kind, f"{Caution.NOT}: too close")))
    return rows


def finding_line(finding: MissionFinding) -> str:
    """Return a finding in one line: the items, what is wrong, and where."""
    items = f"{_items(finding.items)}: " if finding.items else ""
    where = ""
    if finding.place is not None:
        latitude, longitude, sea = finding.place
        where = f"; at {latitude:.5f}, {longitude:.5f}, {sea:.1f} m amsl"
    clear = "" if finding.clear_at is None else f"; clear from {finding.clear_at:.1f} m amsl"
    return f"{finding.subject.value} {items}{finding.said}{where}{clear}"


def assumptions(fleet: CheckedFleet, number: int) -> Iterator[str]:
    """Yield what was taken from defaults, and what the mission tells that is passed on without being understood."""
    mission = fleet.missions[number]
    yield from (f"Taken as usual: {said}." for said in (*fleet.assumed, *mission.flown.assumed))
    for name, items in mission.flown.waypoints.passed_on.items():
        yield f"Not understood, passed on: {name} ({_items(tuple(items))})."


def as_data(fleet: CheckedFleet) -> list[dict[str, Any]]:
    """Return what is found of each mission as plain data, in the order in which they were given."""
    made = []
    for number, mission in enumerate(fleet.missions):
        findings = [asdict(one) | {"subject": one.subject.value} for one in mission.findings]
        rows = dict(check_table(fleet, number))
        summary = asdict(mission.summary)
        heights = {
            name: None if height is None else height._asdict()
            for name, height in (("lowest", mission.lowest), ("highest", mission.highest))
        }
        back = mission.back
        home = None if back is None else {"altitude": back.altitude, "everywhere": back.everywhere}
        made.append(
            {
                "file": mission.flown.waypoints.name,
                "proven": mission.is_proven,
                "findings": findings,
                "table": rows,
                "flight": summary,
                "photos": mission.photos,
                "way_home": home,
                **heights,
                "assumed": list(assumptions(fleet, number)),
            }
        )
    return made


def _verdict(mission: CheckedMission, subject: Subject, count: int) -> str:
    wrong = mission.of(subject)
    if not wrong:
        return f"{count:,} {PROVEN}" if count != 1 else PROVEN
    return NOT if count == 1 else f"{len(wrong):,} of {count:,} {NOT}"


def _radii(radii: np.ndarray[Any, Any]) -> str:
    most = float(radii.max(initial=0.0))
    return f", cut within {most:.3g} m at most" if most else ""


def _kept(wrong: int) -> str:
    return "kept" if not wrong else f"{Caution.NOT} kept, {counted(wrong, 'time')}"


def _end(mission: CheckedMission) -> str:
    up = f"returns at {mission.flown.return_altitude:.4g} m above home, and lands there"
    return {"loiter": "stays at its last place", "land": "lands", "rtl": up}[mission.flown.end]


def _way_home(mission: CheckedMission) -> str:
    back = mission.back
    if back is None:
        return "not judged"
    gaps = (
        "at every instant" if back.everywhere else f"{Caution.NOT} from {counted(len(back.gaps), 'part')} of the flight"
    )
    return f"{gaps}, {back.altitude:.4g} m above home"


def _height(height: Height) -> str:
    return f"{height.metres:.1f} m ({_items(height.items)})"


def _items(items: Sequence[int]) -> str:
    """Return numbers as ground stations show them: ``3``, ``3-4``."""
    if len(items) > MAX_RANGE or (len(items) > 1 and list(items) == list(range(items[0], items[-1] + 1))):
        return f"{items[0]}-{items[-1]}"
    return ", ".join(map(str, items))


def landing_places(fleet: CheckedFleet) -> tuple[LandingPlace, ...]:
    """Return the homes to which vehicles return, as a page marks them."""
    made = []
    for number, mission in enumerate(fleet.missions):
        x, y, z = mission.flown.plan.home.tolist()
        level = z + mission.flown.return_altitude
        words = f"{fleet.scenario.uavs[number].name}: home; it returns {mission.flown.return_altitude:.4g} m above it"
        made.append(LandingPlace(number, words, (x, y, z), level))
    return tuple(made)
