"""Files of missions and flights: one self-contained JSON, and waypoints and sampled trajectories as CSV."""

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from skyverse.cost import make_rates, wrong_figures
from skyverse.errors import InputError
from skyverse.files.document import JsonFormat
from skyverse.model.flight_record import Flight
from skyverse.model.mission import Mission
from skyverse.model.replanned_flight import REPLANNED_FLIGHT_1, ReplannedFlight
from skyverse.model.sortie import Strip
from skyverse.model.trajectory import Pointing
from skyverse.summary import with_flight_summaries

_JUDGED = {"certificates": True, "apart": True, "coverage": True}  # only the referee can say what is proven
MISSIONS = JsonFormat(Mission, "skyverse/mission/2", _JUDGED)
FLIGHTS = JsonFormat(Flight, "skyverse/flight/1", {"mission": _JUDGED})
REPLANNED_FLIGHTS = JsonFormat(
    ReplannedFlight, REPLANNED_FLIGHT_1, {"mission": _JUDGED, "flight": {"mission": _JUDGED}}
)
MAX_CSV_ROWS = 1e7
"""Rows of sampled trajectories that a CSV file may have for each UAV."""


def mission_from_data(source: str | Path, data: Any) -> Mission:
    """Return the mission that a file's data describe, or raise `InputError` that names file and field."""
    mission = MISSIONS.from_data(source, data)
    _require_sound_arrays(source, mission)
    fleet = len(mission.scenario.uavs)
    for name in ("assignment", "results", "trajectories", *(("sorties",) if mission.sorties else ())):
        if len(getattr(mission, name)) != fleet:
            found = len(getattr(mission, name))
            raise InputError(f"{source}: {name}: expected one entry for each UAV, {fleet} in all, found {found}")
    return _with_true_figures(source, mission)


def _with_true_figures(source: str | Path, mission: Mission) -> Mission:
    """Return a mission whose flights and arrival times are computed anew; costs that are not so are refused."""
    scenario = mission.scenario
    rates = make_rates(scenario)
    with np.errstate(all="ignore"):
        for i, result in enumerate(mission.results):
            if result is not None and (wrong := wrong_figures(scenario, rates, result)):
                raise InputError(f"{source}: results[{i}]: {wrong}")
        if mission.flights:
            mission = with_flight_summaries(mission)
    record = mission.deconfliction
    if record is None:
        return mission
    named = [uav for conflict in (*record.found, *record.left) for uav in conflict.uavs]
    for wrong_one in {*named, *(action.uav for action in record.actions)} - {*range(len(scenario.uavs))}:
        numbers = f"0 to {len(scenario.uavs) - 1}"
        raise InputError(f"{source}: deconfliction: expected UAVs numbered {numbers}, found {wrong_one}")
    return replace(
        mission, deconfliction=replace(record, total_after=mission.total_time, makespan_after=mission.makespan)
    )


def replanned_flight_from_data(source: str | Path, data: Any) -> ReplannedFlight:
    """Return the replanned flight that a file's data describe, or raise `InputError` that names file and field."""
    flight = REPLANNED_FLIGHTS.from_data(source, data)
    for mission in (flight.mission, flight.flight.mission):
        _require_sound_arrays(source, mission)
    fleet, movers, obstacles = (len(part) for part in (flight.truth.uavs, flight.truth.movers, flight.truth.obstacles))
    for name, rows in (("arrivals", flight.arrivals), ("flight.flown", flight.flown)):
        if len(rows) != fleet:
            raise InputError(f"{source}: {name}: expected one entry for each UAV, {fleet} in all, found {len(rows)}")
    for number, step in enumerate(flight.steps):
        place = f"{source}: steps[{number}]"
        if [answer.uav for answer in step.answers] != list(range(fleet)):
            raise InputError(f"{place}.answers: expected one for each UAV, in their order")
        named = (
            ("movers", step.movers, movers),
            ("predictions", tuple(one.mover for one in step.predictions), movers),
            ("obstacles", step.obstacles, obstacles),
        )
        for name, numbers, count in named:
            for wrong in (one for one in numbers if one not in range(count)):
                raise InputError(f"{place}.{name}: expected numbers from 0 to {count - 1}, found {wrong}")
    return flight


def _require_sound_arrays(source: object, mission: Mission) -> None:
    """Refuse arrays whose shapes do not fit each other; the referee judges what they hold."""
    for i, trajectory in enumerate(mission.trajectories):
        if trajectory is not None:
            knots, rows = trajectory.knots, trajectory.coefficients
            if knots.ndim != 1 or len(knots) < 2 or not (np.diff(knots) > 0).all() or not np.isfinite(knots).all():
                raise InputError(f"{source}: trajectories[{i}].knots: expected two or more rising numbers of seconds")
            if rows.ndim != 3 or rows.shape[0] != len(knots) - 1 or rows.shape[1] < 1 or rows.shape[2] != 3:
                raise InputError(
                    f"{source}: trajectories[{i}].coefficients: expected {len(knots) - 1} pieces of rows of x, y, z, "
                    f"found an array of shape {rows.shape}"
                )
            if not np.isfinite(rows).all():
                raise InputError(f"{source}: trajectories[{i}].coefficients: expected numbers, found NaN or infinity")
            _require_sound_pointing(f"{source}: trajectories[{i}].pointing", trajectory.pointing)
    for i, result in enumerate(mission.results):
        if result is not None:
            columns = vars(result.history).values()
            if any(c.ndim != 1 for c in columns) or len({len(c) for c in columns}) > 1:
                raise InputError(f"{source}: results[{i}].history: expected columns of one length")
    _require_sound_sorties(source, mission)


def _require_sound_sorties(source: object, mission: Mission) -> None:
    """Refuse sorties at no instants, and targets and surveys that there are not; the referee judges the rest."""
    named = [(f"unvisited[{k}]", one.target) for k, one in enumerate(mission.unvisited)]
    for i, own in enumerate(mission.sorties):
        for j, sortie in enumerate(own):
            place = f"sorties[{i}][{j}]"
            named += [(f"{place}.visits[{k}]", visit.target) for k, visit in enumerate(sortie.visits)]
            instants = [sortie.begin, sortie.end, *(t for one in sortie.visits for t in (one.arrival, one.departure))]
            for k, strip in enumerate(sortie.strips):
                _require_sound_strip(f"{source}: {place}.strips[{k}]", strip, len(mission.scenario.surveys))
            if not np.isfinite(instants).all() or sortie.begin > sortie.end:
                raise InputError(f"{source}: {place}: expected seconds, none infinite, and a begin not after its end")
    count = len(mission.scenario.targets)
    for place, target in named:
        if not 0 <= target < count:
            raise InputError(f"{source}: {place}.target: expected a target's number below {count}, found {target}")


def _require_sound_strip(place: str, strip: Strip, surveys: int) -> None:
    if not 0 <= strip.survey < surveys:
        raise InputError(f"{place}.survey: expected a survey's number below {surveys}, found {strip.survey}")
    if not np.isfinite([strip.begin, strip.end, strip.every, strip.pitch, strip.heading or 0.0]).all():
        raise InputError(f"{place}: expected numbers, found NaN or infinity")
    if strip.begin > strip.end:
        raise InputError(f"{place}: expected a begin not after its end, found {strip.begin:g} and {strip.end:g} s")


def _require_sound_pointing(place: str, pointing: Pointing | None) -> None:
    """Refuse turns that cannot be evaluated."""
    if pointing is None:
        return
    if pointing.instants.ndim != 1 or pointing.instants.shape != pointing.turns.shape:
        raise InputError(
            f"{place}: expected as many instants as turns, found {pointing.instants.shape} and {pointing.turns.shape}"
        )
    if not (0 < pointing.rise <= pointing.spread < np.inf and np.isfinite(pointing.yaw)):
        raise InputError(
            f"{place}: expected a finite yaw and 0 < rise <= spread, found {pointing.yaw:g}, "
            f"{pointing.rise:g} and {pointing.spread:g}"
        )
    if not (np.isfinite(pointing.instants).all() and np.isfinite(pointing.turns).all()):
        raise InputError(f"{place}: expected numbers, found NaN or infinity")


def waypoints_csv(mission: Mission) -> str:
    """Return the places where the pieces of trajectories meet: uav, waypoint, t, x, y, z; seconds and metres."""
    rows: list[list[object]] = []
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None:
            places = trajectory.at(trajectory.knots).position
            rows += [
                [uav.name, i, *(repr(float(v)) for v in (t, *p))]
                for i, (t, p) in enumerate(zip(trajectory.knots, places, strict=True))
            ]
    return _csv(["uav", "waypoint", "t", "x", "y", "z"], rows)


def trajectories_csv(mission: Mission, rate: float) -> str:
    """Return trajectories, sampled `rate` times a second and at both ends: uav, t, position, velocity, acceleration."""
    rows: list[list[object]] = []
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None:
            if trajectory.end * rate > MAX_CSV_ROWS:
                raise InputError(
                    f"expected at most {MAX_CSV_ROWS:g} rows a UAV, found {rate:g} a second of {trajectory.end:g}",
                    field="rate",
                )
            count = int(np.floor(trajectory.end * rate) - np.ceil(trajectory.start * rate)) + 1
            ticks = (np.ceil(trajectory.start * rate) + np.arange(count)) / rate
            t = np.unique(np.r_[trajectory.start, ticks, trajectory.end])
            motion = trajectory.at(t)
            heading = trajectory.heading(t)
            table = np.column_stack([t, *motion, heading.yaw, heading.pitch])
            rows += [[uav.name, *(f"{value:.9g}" for value in row)] for row in table]
    head = ["uav", "t", *(f"{kind}{axis}" for kind in ("", "v", "a") for axis in "xyz"), "yaw", "pitch"]
    return _csv(head, rows)


def _csv(head: list[str], rows: list[list[object]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()
