"""Judged missions as a web page: flights over the terrain, and what is wrong with them on map and profile."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from skyverse.draw import JudgedScene, LandingPlace, NumberedPlace, SceneFinding, judged_page
from skyverse.draw.track import track
from skyverse.model.caution import warning_of
from skyverse.model.geodesy import to_local
from skyverse.model.mission import PlannedFlight
from skyverse.model.short_lines import counted, told_clock, told_metres
from skyverse.waypoints.findings import Subject
from skyverse.waypoints.fleet import CheckedFleet
from skyverse.waypoints.report import assumptions, check_table, finding_line, subject_and_words, verdict
from skyverse.waypoints.site import with_fence

INSTANTS = 4000
"""Instants of a flight among which the one is sought at which it is where something is wrong."""
STEPS = 64
"""Points by which a stretch of a flight is drawn."""


def check_page(fleet: CheckedFleet) -> str:
    """Return the page of judged missions."""
    numbers = range(len(fleet.missions))
    tables = [dict(check_table(fleet, number)) for number in numbers]
    names = dict.fromkeys(name for one in tables for name in one)
    told = [(number, one) for number, mission in enumerate(fleet.missions) for one in mission.findings]
    shown = fleet.scenario
    for mission in fleet.missions:
        shown = with_fence(shown, mission.flown.waypoints, mission.flown.plan.autopilot.name)
    flights = [(uav, one.flown.plan.predicted()) for uav, one in zip(shown.uavs, fleet.missions, strict=True)]
    scene = JudgedScene(
        scenario=shown,
        tracks=tuple(
            track(PlannedFlight(uav=uav, trajectory=flight), number, shown.bounds)
            for number, (uav, flight) in enumerate(flights)
        ),
        spare_targets=(),
        findings=tuple(one for number in numbers for one in _wrong(fleet, number)),
        places=tuple(_places(fleet)),
        landings=tuple(_homes(fleet)),
        verdict=_verdict(fleet),
        verdicts=(
            ("", *(mission.flown.waypoints.name for mission in fleet.missions)),
            *((name, *(one.get(name, "") for one in tables)) for name in names),
        ),
        cautions=(
            *(warning_of(one.file, said) for one in fleet.scenario.sources for said in one.cautions),
            *(finding_line(fleet, number, one) for number, one in told if not one.wrong),
        ),
        notes=tuple(dict.fromkeys(said for number in numbers for said in assumptions(fleet, number))),
        figures=tuple(_figures(fleet)),
    )
    return judged_page(scene)


def _verdict(fleet: CheckedFleet) -> str:
    wrong = sum(one.wrong for mission in fleet.missions for one in mission.findings)
    return counted(wrong, "fault") if wrong else "; ".join(dict.fromkeys(map(verdict, fleet.missions)))


def _figures(fleet: CheckedFleet) -> Iterator[tuple[str, str, str]]:
    summaries = [mission.summary for mission in fleet.missions]
    yield "Flown", told_metres(sum(one.length for one in summaries)), counted(len(summaries), "mission")
    yield "Time", f"{told_clock(max(one.time for one in summaries))} min", "of the longest"
    low = [mission.lowest.metres for mission in fleet.missions if mission.lowest is not None]
    high = [mission.highest.metres for mission in fleet.missions if mission.highest is not None]
    if low and high:
        yield "Above ground", f"{min(low):.1f} to {max(high):.1f} m", "after the take-off"


def _places(fleet: CheckedFleet) -> Iterator[NumberedPlace]:
    for uav, mission in enumerate(fleet.missions):
        plan, shown = mission.flown.plan, set[int]()
        wrong = {number for one in mission.findings if one.part is not None for number in one.items}
        for visit, time in zip(mission.flown.visits, plan.arrivals, strict=False):
            if visit.order.number not in shown:
                shown.add(visit.order.number)
                x, y, z = visit.at.tolist()
                yield NumberedPlace(uav, visit.order.number, (x, y, z), float(time), visit.order.number in wrong)


def _homes(fleet: CheckedFleet) -> Iterator[LandingPlace]:
    for number, mission in enumerate(fleet.missions):
        x, y, z = mission.flown.plan.home.tolist()
        level = z + mission.flown.return_altitude
        how = "along its mission" if mission.flown.retraces else f"{mission.flown.return_altitude:.4g} m above it"
        words = f"{fleet.scenario.uavs[number].name}: home, at z = {z:.1f} m; it returns {how}"
        yield LandingPlace(number, words, (x, y, z), level)


def _wrong(fleet: CheckedFleet, number: int) -> Iterator[SceneFinding]:
    """Yield what is wrong with a mission as it is drawn: its place, and the stretch of the flight that is wrong."""
    origin, mission = fleet.scenario.frame.origin, fleet.missions[number]
    assert origin is not None
    flown, flight, arrivals = mission.flown, mission.flown.plan.predicted(), mission.flown.plan.arrivals.tolist()
    whose = (fleet.scenario.uavs[number].name,) if len(fleet.missions) > 1 else ()
    for finding in (one for one in mission.findings if one.wrong):
        severity: Literal["warning", "error"] = "warning" if finding.part is None and finding.times else "error"
        times, stretch, time, place = finding.times, None, None, None
        if finding.part is not None and finding.subject in (Subject.LEGS, Subject.TAKEOFF):
            before, after = flown.ends(finding.part)
            times = arrivals[before] if before >= 0 else flight.start, arrivals[after]
        if times is not None and times[0] < times[1]:
            instants = np.linspace(*times, STEPS)
            stretch = np.column_stack([flight.at(instants).position, instants])
        if finding.place is not None:
            x, y, z = to_local(origin, [finding.place])[0].tolist()
            place, instants = (x, y, z), np.linspace(*(times or (flight.start, flight.end)), INSTANTS)
            away = np.linalg.norm(flight.at(instants).position - [x, y, z], axis=1)
            time = float(instants[away.argmin()])
        subject, said = subject_and_words(fleet, number, finding)
        yield SceneFinding(severity, subject, whose, said, time, place, stretch)
