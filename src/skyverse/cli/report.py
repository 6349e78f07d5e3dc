"""What a verb found, as tables for people and as JSON for programs."""

import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyverse.cli.option_names import for_command_line, told_option
from skyverse.cli.streams import plain
from skyverse.model.short_lines import counted, told_metres, told_seconds

if TYPE_CHECKING:
    from skyverse.mission.closed_ways import ClosedWay
    from skyverse.model.flight_record import Flight
    from skyverse.model.mission import FlightSummary, Mission
    from skyverse.model.scenario import Source
    from skyverse.model.verdict import Certificate, Violation


def json_text(data: Any) -> str:
    """Return data as a JSON document, in which no key has a blank: ``departs_at`` for what tables call "departs_at"."""

    def named(part: Any) -> Any:
        if isinstance(part, dict):
            return {re.sub(r"\W+", "_", key).strip("_") if " " in key else key: named(part[key]) for key in part}
        return [named(one) for one in part] if isinstance(part, list | tuple) else part

    return json.dumps(named(data), indent=2) + "\n"


def violation_data(violation: "Violation") -> dict[str, Any]:
    """Return a violation as plain data."""
    return asdict(violation) | {"fault": violation.fault.value}


def say(*said: object, aside: bool = False) -> None:
    """Print sentences, which name options, and names of files on lines of standard output, or `aside`, of error."""
    for one in said:
        print(for_command_line(one) if isinstance(one, str) else one, file=sys.stderr if aside else sys.stdout)


def told_violations(violations: "Iterable[Violation]", whose: str = "") -> Iterator[str]:
    """Yield what is wrong, one sentence each, and whose it is."""
    return (f"{whose}{violation.fault.value}: {violation.message}" for violation in violations)


def flight_violations(flight: "Flight") -> Iterator[str]:
    """Yield what went wrong in a flight, and whose it is where another vehicle was planned."""
    return told_violations(flight.violations, f"{flight.vehicle} alone: " if flight.stands_in else "")


def report(
    mission: "Mission", written: list[Path], as_json: bool, details: bool = False, *, maps_told: bool = False
) -> None:
    """Print what became of each UAV, the verdict, and where the files are; `details` adds a table of the searches.

    What a pilot must heed of maps is left out where it was told when these were read.
    """
    from skyverse.mission.closed_ways import closed_ways
    from skyverse.model.flight_table import (
        battery_sentence,
        flight_columns,
        gaps_sentence,
        idle_sentence,
        measure_flight,
        planners_sentence,
        search_columns,
        told_costs,
        unit_sentence,
        unknown_gaps_sentence,
    )
    from skyverse.model.go_no_go import go_no_go
    from skyverse.model.quantities import short
    from skyverse.model.timed_shapes import what_is_proven
    from skyverse.space.mission_cautions import mission_cautions, nearest_obstacle
    from skyverse.space.pads import fleet_pads, pads_sentence
    from skyverse.tour_table import sortie_columns, visit_columns

    if as_json:
        print(json_text(_summary(mission, written)), end="")
        return
    results = [result for result in mission.results if result is not None]
    visits = [visit_columns(mission)] if mission.visited else []
    done = mission.visited or any(one.strips for uav in mission.sorties for one in uav)
    tours = [sortie_columns(mission), *visits] if done and mission.sorties else []
    for columns in [flight_columns(mission), *tours, *([search_columns(mission)] if details else [])]:
        table([column.head for column in columns], zip(*(column.cells for column in columns), strict=True))
    if any(result.status.value == "optimal" for result in results):
        print("Paths called optimal are so as claimed by the planner.")
    if results:
        print(planners_sentence(mission))
    times = f"total time {told_seconds(mission.total_time)}, makespan {told_seconds(mission.makespan)}"
    seed = mission.provenance.seed
    total = told_costs(mission.costs) if mission.complete else "-"
    print(f"total cost {total}, {times}{'' if seed is None else f', seed {seed}'}")
    if mission.scenario.terrain is not None and mission.makespan > 0:
        measured = [measure_flight(one, mission.scenario.terrain) for one in mission.trajectories if one is not None]
        low, high = min(one.lowest for one in measured), max(one.highest for one in measured)
        print(f"above ground: {low:.1f} m at least, {high:.1f} m at most")
    for source in mission.scenario.sources:
        if source.flown is not None and mission.flights and mission.flights[0] is not None:
            print(_compared(source, mission.flights[0]))
    near = nearest_obstacle(mission)
    if near is not None:
        print(f"nearest obstacle: about {near:.2f} m")
    sentences = unit_sentence, gaps_sentence, unknown_gaps_sentence, battery_sentence, idle_sentence
    say(*filter(None, (sentence(mission) for sentence in sentences)))
    _report_conflicts(mission)
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None and trajectory.note:
            print(f"{uav.name} flies {trajectory.form}: {trajectory.note}")
    if mission.interrupted:
        print(f"Interrupted: this is the best so far, not judged yet; skyverse show {written[0]} judges and draws it.")
    for result in {r.status: r for r in mission.results if r is not None and not r.status.reached}.values():
        print(f"{result.status.value}: {for_command_line(result.status.sentence)}")
    say(*(closed.sentence for closed in (() if mission.interrupted else closed_ways(mission))))
    say(*told_violations(mission.violations))
    if not mission.violations and not mission.interrupted:
        print("The referee found nothing wrong.")
        if mission.complete and mission.apart is not None:
            print(f"Proven at every instant: {what_is_proven(mission.scenario, mission.makespan)}.")
            say(*filter(None, [pads_sentence(mission.scenario, fleet_pads(mission))]))
        for one in (one for one in mission.coverage if one.verdict.value == "proven"):
            print(f"coverage: {mission.scenario.surveys[one.survey].name}: {one.sentence}")
        print(f"Judged by scenario {mission.scenario.name!r} ({short(mission.scenario.digest)}).")
    say(*(one.sentence for one in mission_cautions(mission) if not (maps_told and one.kind == "left out")))
    say(go_no_go(mission).sentence, *written)


def _compared(source: "Source", flight: "FlightSummary") -> str:
    """Say how a planned flight compares with the mission from which its scenario was made."""
    assert source.flown is not None
    length, seconds = source.flown
    less = 1 - flight.length / length
    return (
        f"{source.file} flies {told_metres(length)} in {told_seconds(seconds)} from the same start to the same target; "
        f"this mission {told_metres(flight.length)} in {told_seconds(flight.time)}, "
        f"{abs(less):.1%} {'shorter' if less >= 0 else 'longer'}"
    )


def _summary(mission: "Mission", written: list[Path]) -> dict[str, Any]:
    """Return what became of each UAV, the verdict, and where the files are, as plain data."""
    from skyverse.mission.closed_ways import closed_ways
    from skyverse.space.mission_cautions import mission_cautions

    costs, targets = mission.costs if mission.complete else {}, mission.scenario.targets
    surveys = mission.scenario.surveys
    flies = any(trajectory is not None for trajectory in mission.trajectories)
    return {
        "mission": str(written[0]),
        "page": str(written[1]) if len(written) > 1 else None,
        "cost": mission.cost if len(costs) == 1 else None,
        "costs": costs,
        "total_time": mission.total_time,
        "makespan": mission.makespan,
        "deconfliction": None if mission.deconfliction is None else asdict(mission.deconfliction),
        "certificates": [None if c is None else certificate_data(c) for c in mission.certificates],
        "apart": certificate_data(mission.apart) if mission.apart is not None and flies else None,
        "coverage": [
            asdict(one) | {"survey": surveys[one.survey].name, "verdict": one.verdict.value} for one in mission.coverage
        ],
        "scenario": {"name": mission.scenario.name, "sha256": mission.scenario.digest},
        "interrupted": mission.interrupted,
        "provenance": asdict(mission.provenance),
        "uavs": _uav_data(mission),
        "unvisited": [{"target": targets[one.target].name, "why": one.why} for one in mission.unvisited],
        "violations": [violation_data(v) for v in mission.violations],
        "closed_ways": [] if mission.interrupted else [_closed_way_data(closed) for closed in closed_ways(mission)],
        "cautions": [asdict(one) | {"sentence": for_command_line(one.sentence)} for one in mission_cautions(mission)],
    }


def _closed_way_data(closed: "ClosedWay") -> dict[str, Any]:
    """Return what closes a way as plain data, with the options of which any one may open it."""
    options = [told_option(one.field) for one in closed.give]
    return {"uav": closed.uav, "target": closed.target, "by": closed.by, "options": options}


def _uav_data(mission: "Mission") -> list[dict[str, Any]]:
    """Return of each UAV that was planned its path's cost and bound, and its flight, as plain data."""
    from skyverse.model.flight_table import EXACT_TERMS, bound_kind
    from skyverse.model.mission import planned_flights

    bound = "optimum" if bound_kind(mission) == "exact optimum" else "bound"
    rows = []
    for number, one in enumerate(planned_flights(mission)):
        if one.target is None or one.result is None:
            continue
        result, trajectory = one.result, one.trajectory
        rows.append(
            {
                "uav": one.uav.name,
                "target": one.target.name,
                "status": result.status.value,
                "cost": result.cost if result.path.size else None,
                bound: result.bound,
                "gap": result.gap,
                "departs at": None if trajectory is None else trajectory.start,
                "arrives_at": None if trajectory is None else trajectory.end,
                "flies": None if trajectory is None else trajectory.form,
                "generated_paths": result.effort.generated_paths,
                "flight": None if one.summary is None else asdict(one.summary),
                **({"sorties": _sorties_data(mission, number)} if mission.sorties else {}),
                **(result.terms if result.terms.keys() - EXACT_TERMS else {}),
            }
        )
    return rows


def _sorties_data(mission: "Mission", uav: int) -> list[dict[str, Any]]:
    """Return the sorties of a UAV with the names of what is visited, and how much batteries give beyond them, Wh."""
    from skyverse.tour_table import numbered_sorties

    sorties, targets = [], mission.scenario.targets
    for one in numbered_sorties(mission):
        if one.uav == uav:
            visits = [asdict(visit) | {"target": targets[visit.target].name} for visit in one.sortie.visits]
            until = None if one.battery is None else one.battery.no_return
            spare = {"spare_wh": one.spare, "turning_back_until": until}
            sorties.append({"begin": one.sortie.begin, "end": one.sortie.end, "visits": visits, **spare})
    return sorties


def certificate_data(certificate: "Certificate") -> dict[str, Any]:
    """Return a certificate as plain data."""
    return asdict(certificate) | {"verdict": certificate.verdict.value}


def _report_conflicts(mission: "Mission") -> None:
    """Print how many conflicts there were, and what was done."""
    done = mission.deconfliction
    if done is None or not done.found:
        return
    before, after = f"{done.total_before:.1f} s", f"{done.total_after:.1f} s"
    print(
        f"{counted(len(done.found), 'conflict')} between UAVs found, {len(done.left)} left: "
        f"total time {before} -> {after}, makespan {done.makespan_before:.1f} s -> {done.makespan_after:.1f} s"
    )
    say(*(f"{action.kind}: {action.sentence}" for action in done.actions))


LEAST_TEXT = 24
"""Characters of a line, at least, to which a narrow terminal folds sentences."""
BETWEEN = 2
"""Spaces between two columns."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, aside: bool = False) -> None:
    """Print a table on standard output, or `aside`, on standard error.

    Where a terminal is too narrow, sentences are folded between words, and columns that do not fit follow in another
    table below, behind the first column again; nothing is cut.
    """
    from rich.cells import cell_len
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    stream = sys.stderr if aside else sys.stdout
    console = Console(width=None if stream.isatty() else sys.maxsize, stderr=aside)
    columns = [list(map(plain, column)) for column in zip(head, *rows, strict=True)]
    whole = [max(map(cell_len, column)) for column in columns]
    words = [max(map(cell_len, " ".join(column).split()), default=0) for column in columns]
    folded = [max(word, min(LEAST_TEXT, width)) for word, width in zip(words, whole, strict=True)]
    parts: list[list[int]] = [[]]
    for number, least in enumerate(folded):
        if len(parts[-1]) > 1 and sum(folded[k] + BETWEEN for k in parts[-1]) + least > console.width:
            parts.append([0])
        parts[-1].append(number)
    for part in parts:
        widths = {k: words[k] for k in part}
        for wished in (folded, whole):
            for k in part:
                room = console.width - sum(widths.values()) - BETWEEN * (len(part) - 1)
                widths[k] += max(0, min(room, wished[k] - widths[k]))
        shown = Table(box=None, header_style="bold", pad_edge=False, padding=(0, BETWEEN, 0, 0))
        for k in part:
            shown.add_column(Text(columns[k][0]), width=widths[k], overflow="fold")
        for row in zip(*(columns[k][1:] for k in part), strict=True):
            shown.add_row(*map(Text, row))  # as they are: rich would read brackets in names as markup
        console.print(shown)


MAX_NAMED = 6
"""Pairs of UAVs named in one sentence; of more it says only how many."""


def tell_apart_by_timing(mission: "Mission") -> None:
    """Say on standard error which pairs of UAVs are not proven to be apart in space."""
    from skyverse.deconfliction.paths_apart import apart_by_timing_only

    pairs = apart_by_timing_only(mission)
    if not pairs:
        return
    names = [" and ".join(mission.scenario.uavs[uav].name for uav in pair) for pair in pairs]
    said = "; ".join(names) if len(names) <= MAX_NAMED else f"{len(names)} pairs of UAVs"
    print(f"skyverse: not apart in space, but at most by timing: {said}.", file=sys.stderr)
