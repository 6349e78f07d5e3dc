"""What is told of judged missions: a table for each, a line for each thing that is wrong, data, and a page."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from skyverse.exports.separation import Apart
from skyverse.exports.way_home import UNPROVEN_NEAR_HOME
from skyverse.model.caution import Caution
from skyverse.model.flight_table import told_energy, told_left
from skyverse.model.geodesy import told_globe
from skyverse.model.short_lines import counted, listed, told_clock, told_metres
from skyverse.waypoints.check import CheckedMission, Height
from skyverse.waypoints.findings import FindingKind, MissionFinding, Subject
from skyverse.waypoints.fleet import CheckedFleet

PROVEN, NOT = "proven", f"{Caution.NOT} proven"
NOT_JUDGED = f"{Caution.NOT} judged"
FARTHER = f"{Caution.ONLY} {PROVEN} farther from home"
KEPT = {Apart.SPACE: "in space", Apart.TIMING: "by timing", Apart.SCHEDULE: f"{Caution.ONLY} on schedule"}
MOST_ON_END = 5
"""Legs or corners on end that meet the same and are told one by one."""
MOST_LISTED = 12
"""Numbers of items that are told one by one."""
_NOUNS = {
    Subject.ORDERS: "item",
    Subject.LEGS: "leg",
    Subject.CORNERS: "corner",
    Subject.APART: "leg",
    Subject.WAY_HOME: "way home from",
    Subject.LIMITS: "item",
}
"""What the numbers of a finding are, where its subject alone does not say it."""

_NEAR = "may {near} {one.name}, where {limit} off it are required"
_RETURN = "no return at {mission.back.altitude:.4g} m above home is proven from {times} min of the flight: {one.kind}"
_REFUSED = "{autopilot} takes no {one.kind} in missions, and refuses these orders"
_SAID = {
    FindingKind.GROUND: "may be {off} {above} ground, where {limit} above it are required",
    FindingKind.CEILING: "may be {off} above the ceiling of {mission.scenario.max_height:.4g} m above ground",
    FindingKind.OBSTACLE: _NEAR,
    FindingKind.ZONE: _NEAR,
    FindingKind.FENCE: "may {crosses} the fence",
    FindingKind.BOUNDS: "may be {off} out of bounds",
    FindingKind.UNDECIDED: "could not be decided",
    FindingKind.CURVED: "the curves that these orders ask for are not published, so nothing is proven of them: "
    "fly straight legs",
    FindingKind.LANDING: "it cannot land there, as {one.name}",
    FindingKind.NO_WAY_BACK: "it does not return along its mission, since {one.name}",
    FindingKind.RALLY: "it may return to any of its {one.limit:.0f} rally points in place of home, and nothing is "
    "proven of the ways there: take them out of the file",
    FindingKind.HOME_ALTITUDE: "home is at {one.found:.1f} m above the sea by the file, and the ground there at "
    "{one.limit:.1f} m by the terrain: it was planned over another ground",
    FindingKind.NOT_FOLLOWED: "{one.name} may lead elsewhere, move home or end the flight: nothing is proven from "
    "there on, and all is judged as if left out",
    FindingKind.NO_TERRAIN_FOLLOWING: _REFUSED,
    FindingKind.NO_CIRCLES: _REFUSED,
    FindingKind.SPEED: "{one.found:.3g} m/s is commanded, and {one.name} flies {one.limit:.3g} m/s at most",
    FindingKind.CLOSE: "comes too close to {one.name}{at}, if both start together",
    FindingKind.TURNS: "{autopilot} turns an aeroplane at a distance of its own: legs are proven, and corners are not",
    FindingKind.RETURN: "the take-off and the return of an aeroplane are not judged",
    FindingKind.NOT_AEROPLANE: "the file is for an aeroplane, and is judged as flown by a vehicle that can stop: "
    "name an aeroplane as its vehicle",
    FindingKind.COUNT: "{one.found:,.0f} items, and usual boards with {autopilot} take {one.limit:,.0f}",
    FindingKind.BATTERY: "the flight takes up to {energy}, and the battery gives {battery} above its reserve",
    FindingKind.LENGTH: "it is {one.found:,.0f} m long, and {autopilot} may refuse more than {one.limit:,.0f} m",
}


_OPEN = {
    FindingKind.NEAR_HOME: "returns within {near:g} m of home",
    FindingKind.TURNS: "corners",
    FindingKind.RETURN: "the take-off and the way home",
}
"""Of what nothing is proven, where that refutes no mission."""


def verdict(mission: CheckedMission) -> str:
    """Return in words how many faults a mission has, or that it is proven, and but for what."""
    wrong = sum(one.wrong for one in mission.findings)
    if wrong:
        return counted(wrong, "fault")
    kinds, near = {one.kind for one in mission.findings}, UNPROVEN_NEAR_HOME[mission.flown.plan.autopilot.name]
    but_for = [said.format(near=near) for kind, said in _OPEN.items() if kind in kinds]
    return f"{PROVEN}, but for {listed(but_for)}" if but_for else PROVEN


def check_table(fleet: CheckedFleet, number: int) -> list[tuple[str, str]]:
    """Return the rows of the table of one mission: what was judged, and what is found."""
    mission, scenario = fleet.missions[number], fleet.scenario
    flown, route = mission.flown, mission.flown.plan.route
    legs, corners = flown.legs, int(((route.waypoint_radii > 0) & (route.waypoint_holds == 0))[1:-1].sum())
    rows = [
        ("take-off", _takeoff(mission)),
        ("legs", _verdict(mission, Subject.LEGS, legs)),
        ("corners", _corners(mission, corners)),
        ("end", _end(mission)),
        ("way home", _way_home(mission)),
    ]
    if mission.lowest is not None and mission.highest is not None:
        heights = f"least {_height(mission.lowest)}, most {_height(mission.highest)}"
        rows.append(("height above ground", heights))
    met = Counter(finding.kind for finding in mission.findings)
    if scenario.max_height is not None:
        rows.append(("ceiling", f"{_kept(met[FindingKind.CEILING])}: {scenario.max_height:g} m above ground"))
    zones = met[FindingKind.ZONE] + met[FindingKind.FENCE]
    rows.append(("fence and zones", _kept(zones) if flown.waypoints.fence or scenario.obstacles else "none"))
    rows.append(("bounds", _kept(met[FindingKind.BOUNDS])))
    length, time, energy = told_metres(mission.summary.length), told_clock(mission.summary.time), mission.summary.energy
    rows.append(("flight", f"{time} min, {length}" + ("" if energy is None else f", about {told_energy(energy)}")))
    if mission.summary.left is not None:
        rows.append(("battery left", told_left(mission.summary.left, scenario.uavs[flown.plan.route.uav].reserve)))
    if mission.of(Subject.ORDERS):
        rows.append(("orders", f"{Caution.NOT} all followed"))
    if mission.photos is not None:
        rows.append(("photos", f"{mission.photos:,}"))
    rows.append(("limits", "kept" if not mission.of(Subject.LIMITS) else f"{Caution.NOT} kept"))
    for pair, kind in fleet.apart.pairs.items():
        if number in pair:
            other = scenario.uavs[sum(pair) - number].name
            rows.append((f"apart from {other}", KEPT.get(kind, f"{Caution.NOT}: too close")))
    return rows


def finding_lines(fleet: CheckedFleet, number: int) -> Iterator[str]:
    """Yield a line for each finding of a mission; of more on end that meet the same, only for the worst."""
    mission = fleet.missions[number]
    for run in _on_end(mission):
        some = run if len(run) <= MOST_ON_END else [max(run, key=lambda one: one.deep or 0.0)]
        more = "" if len(some) == len(run) else f"; the worst of {len(run):,} on end, {_span(run[0].items)} to "
        last = more and _span(run[-1].items)
        for one in some:
            said = "" if one.wrong else f"{Caution.WARNING}: "
            yield f"{said}{finding_line(fleet, number, one)}{more}{last}"


def _on_end(mission: CheckedMission) -> list[list[MissionFinding]]:
    """Return findings one by one, but those of legs or corners on end that meet the same together."""
    runs, latest, ends = list[list[MissionFinding]](), dict[object, list[MissionFinding]](), mission.flown.ends
    for one in mission.findings:
        same = one.subject, one.what
        last = latest[same][-1].part if same in latest else None
        if one.part is None or last is None or ends(one.part)[0] > ends(last)[1]:
            runs.append([])
            latest[same] = runs[-1]
        latest[same].append(one)
    return runs


def finding_line(fleet: CheckedFleet, number: int, finding: MissionFinding) -> str:
    """Return a finding of a mission in one line: the items, what is wrong, where, and what would be clear."""
    subject, said = subject_and_words(fleet, number, finding)
    return f"{subject}{': ' if finding.part is None else ' '}{said}"


def subject_and_words(fleet: CheckedFleet, number: int, finding: MissionFinding) -> tuple[str, str]:
    """Return what a finding of a mission is about, with the numbers of items, and what is wrong with that."""
    legs = finding.kind in (FindingKind.SPEED, FindingKind.LENGTH)
    noun = "leg" if legs else _NOUNS.get(finding.subject, "") if finding.items else ""
    several = not legs and finding.part is None and finding.subject in (Subject.ORDERS, Subject.LEGS, Subject.LIMITS)
    items = (_listed if several else _span)(finding.items)
    subject = noun + "s" * (several and len(finding.items) > 1) or finding.subject.value
    said = _said(fleet.missions[number], finding)
    if finding.place is not None:
        latitude, longitude, sea = finding.place
        said += f"; at {told_globe(latitude, longitude)}, {_above_home(fleet, number, sea)}"
    if finding.clear_at is not None:
        said += f"; clear from {_above_home(fleet, number, finding.clear_at)} ({finding.clear_at:.1f} m amsl)"
    return f"{subject} {items}".rstrip(), said


def _said(mission: CheckedMission, finding: MissionFinding) -> str:
    """Return what is wrong, in words that stand alone."""
    found, times = finding.found or 0.0, [told_clock(at) for at in finding.times or ()]
    off, inside = told_metres(abs(found)), found < 0
    near = f"be {off} inside" if inside else f"come within {off} of"
    return _SAID.get(finding.kind, _RETURN).format(
        one=finding,
        mission=mission,
        autopilot=mission.flown.plan.autopilot.title,
        off=off,
        limit=told_metres(finding.limit or 0.0),
        above="below" if inside else "above",
        near=near,
        crosses="cross" if inside else near,
        at=f" at {times[0]} min" if times else "",
        times=" to ".join(times),
        energy=told_energy(found),
        battery=told_energy(finding.limit or 0.0),
    )


def _above_home(fleet: CheckedFleet, number: int, sea: float) -> str:
    """Return in words how far a height, metres above mean sea level, is above home."""
    origin = fleet.scenario.frame.origin
    assert origin is not None
    above = sea - origin.altitude - (fleet.scenario.uavs[number].home or 0.0)
    return f"{abs(above):.1f} m {'above' if above >= 0 else 'below'} home"


def assumptions(fleet: CheckedFleet, number: int) -> Iterator[str]:
    """Yield what was taken from defaults, and what the mission tells that is taken to move nothing, and passed on."""
    mission = fleet.missions[number]
    yield from (f"Taken as usual: {said}." for said in (*fleet.assumed, *mission.flown.assumed))
    for name, items in mission.flown.waypoints.passed_on.items():
        yield f"Taken to move nothing, passed on: {name} (item {_listed(items)})."


def as_data(fleet: CheckedFleet) -> list[dict[str, Any]]:
    """Return what is found of each mission as plain data, in the order in which they were given."""
    return [_data(fleet, number, mission) for number, mission in enumerate(fleet.missions)]


def _data(fleet: CheckedFleet, number: int, mission: CheckedMission) -> dict[str, Any]:
    back = mission.back
    return {
        "file": mission.flown.waypoints.name,
        "proven": mission.is_proven,
        "verdict": verdict(mission),
        "findings": [
            asdict(one) | {"what": one.what, "deep": one.deep, "wrong": one.wrong, "said": _said(mission, one)}
            for one in mission.findings
        ],
        "table": dict(check_table(fleet, number)),
        "flight": asdict(mission.summary),
        "photos": mission.photos,
        "way_home": None if back is None else {"altitude": back.altitude, "everywhere": back.everywhere},
        "lowest": mission.lowest and mission.lowest._asdict(),
        "highest": mission.highest and mission.highest._asdict(),
        "assumed": list(assumptions(fleet, number)),
    }


def _verdict(mission: CheckedMission, subject: Subject, count: int) -> str:
    wrong = {one.items for one in mission.of(subject)}
    if count == 1:
        return NOT if wrong else PROVEN
    return f"{NOT}: {len(wrong):,} of {count:,}" if wrong else f"{count:,} {PROVEN}"


def _takeoff(mission: CheckedMission) -> str:
    if mission.back is None:
        return NOT_JUDGED
    return _verdict(mission, Subject.TAKEOFF, 1) if mission.flown.plan.route.takeoff else NOT


def _corners(mission: CheckedMission, count: int) -> str:
    if not count:
        return "none"
    if not mission.flown.plan.corners_proven:
        return NOT
    most = float(mission.flown.plan.route.waypoint_radii.max())
    return f"{_verdict(mission, Subject.CORNERS, count)}, cut within {most:.3g} m at most"


def _kept(wrong: int) -> str:
    return "kept" if not wrong else f"{Caution.NOT} kept, {counted(wrong, 'time')}"


def _end(mission: CheckedMission) -> str:
    up = f"returns at {mission.flown.return_altitude:.4g} m above home, and lands there"
    if mission.flown.returns_along:
        up = "returns along its mission, and lands at home"
    kinds = {one.kind for one in mission.findings if one.subject is Subject.END or mission.flown.end == "rtl"}
    unclear = mission.of(Subject.END) or FindingKind.RALLY in kinds
    near = any(one.subject is Subject.END and one.kind is FindingKind.NEAR_HOME for one in mission.findings)
    proven = NOT if unclear else NOT_JUDGED if FindingKind.RETURN in kinds else FARTHER if near else PROVEN
    return f"{proven}: { {'loiter': 'stays at its last place', 'land': 'lands', 'rtl': up}[mission.flown.end] }"


def _way_home(mission: CheckedMission) -> str:
    back = mission.back
    if back is None:
        return NOT_JUDGED
    where = f"{NOT} in {counted(len(back.gaps), 'part')} of the flight"
    if all(gap.why == FindingKind.NEAR_HOME for gap in back.gaps):
        where = f"{PROVEN} at every instant" if back.everywhere else FARTHER
    if any(one.kind is FindingKind.RALLY for one in mission.findings):
        where = f"{NOT} to its rally points"
    return f"{where}, {'along its mission' if back.retraces else f'at {back.altitude:.4g} m above home'}"


def _height(height: Height) -> str:
    return f"{height.metres:.1f} m ({_span(height.items)})"


def _span(items: Sequence[int]) -> str:
    """Return from which item to which, as of a leg: ``3``, ``3-4``; between them there may be actions."""
    return "-".join(map(str, dict.fromkeys((items[0], items[-1])))) if items else ""


def _listed(items: Sequence[int]) -> str:
    """Return items one by one, the first of many: ``3, 7``."""
    more = f" and {len(items) - MOST_LISTED} more" if len(items) > MOST_LISTED else ""
    return ", ".join(map(str, items[:MOST_LISTED])) + more
