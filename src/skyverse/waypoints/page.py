"""Judged missions as a web page: flights over the terrain, and what is wrong with them on map and profile."""

from dataclasses import replace

import numpy as np

from skyverse.draw import page, scene
from skyverse.model.geodesy import to_local
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import NO_STOP, Provenance
from skyverse.model.scenario import Scenario, Target
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.waypoints.check import CheckedMission, MissionFinding, Subject
from skyverse.waypoints.fleet import CheckedFleet
from skyverse.waypoints.report import assumptions, check_table, finding_line, landing_places

INSTANTS = 4000
"""Instants of a flight among which the one is sought at which it is where something is wrong."""
_FAULTS = {Subject.APART: Fault.SEPARATION, Subject.LIMITS: Fault.SPEED}


def check_page(fleet: CheckedFleet) -> str:
    """Return the page of judged missions."""
    targets = [
        Target(name=f"end of {uav.name}", position=tuple(mission.flown.plan.waypoints[-1].tolist()))
        for uav, mission in zip(fleet.scenario.uavs, fleet.missions, strict=True)
    ]
    scenario = derived(fleet.scenario, targets=tuple(targets), name=", ".join(uav.name for uav in fleet.scenario.uavs))
    count = len(fleet.missions)
    shown = Mission(
        scenario,
        tuple(range(count)),
        (None,) * count,
        tuple(mission.flown.plan.predicted() for mission in fleet.missions),
        tuple(
            _violation(scenario, number, mission, finding)
            for number, mission in enumerate(fleet.missions)
            for finding in mission.findings
            if finding.wrong
        ),
        Provenance("", "skyverse check", NO_STOP, None, ""),
        apart=Certificate(Verdict.PROVEN if fleet.is_proven else Verdict.REFUTED, ""),
    )
    tables = [dict(check_table(fleet, number)) for number in range(count)]
    names = dict.fromkeys(name for one in tables for name in one)
    head = ("", *(mission.flown.waypoints.name for mission in fleet.missions))
    rows = [(name, *(one.get(name, "") for one in tables)) for name in names]
    notes = [said for number in range(count) for said in assumptions(fleet, number)]
    told = replace(
        scene(shown), landings=landing_places(fleet), export_notes=tuple(notes), export_verdicts=(head, *rows)
    )
    return page(replace(told, export_title="What is judged of the missions."))


def _violation(scenario: Scenario, number: int, mission: CheckedMission, finding: MissionFinding) -> Violation:
    """Return a finding as the referee tells what is wrong, with the instant at which the flight is nearest to it."""
    kind, said = _FAULTS.get(finding.subject, Fault.TRAJECTORY_CLEARANCE), finding_line(finding)
    if finding.place is None or scenario.frame.origin is None:
        return Violation(kind, (number,), said)
    x, y, z = to_local(scenario.frame.origin, [finding.place])[0].tolist()
    flight = mission.flown.plan.predicted()
    instants = np.linspace(flight.start, flight.end, INSTANTS)
    away = np.linalg.norm(flight.at(instants).position - [x, y, z], axis=1)
    return Violation(kind, (number,), said, float(instants[away.argmin()]), (x, y, z))
