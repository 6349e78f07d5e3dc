"""What a verb found, as tables for people and as JSON for programs."""

import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.verdict import Certificate, Violation


def json_text(data: Any) -> str:
    """Return data as a JSON document."""
    return json.dumps(data, indent=2) + "\n"


def violation_data(violation: "Violation") -> dict[str, Any]:
    """Return a violation as plain data."""
    return asdict(violation) | {"fault": violation.fault.value}


def report(mission: "Mission", written: list[Path], as_json: bool, details: bool = False) -> None:
    """Print what became of each UAV, the verdict, and where the files are; `details` adds a table of the searches."""
    from skyverse.model.digest import short
    from skyverse.model.what_is_proven import what_is_proven
    from skyverse.space.named_columns import named_columns

    results = [result for result in mission.results if result is not None]
    terms = max((list(result.terms) for result in results if len(result.terms) > 3), key=len, default=[])
    exact = not terms and not any(result.any_angle for result in results)
    costs = mission.costs if mission.complete else {}
    rows = []
    flights = mission.flights or (None,) * len(mission.scenario.uavs)
    for uav, target, result, trajectory, flight in zip(
        mission.scenario.uavs, mission.assignment, mission.results, mission.trajectories, flights, strict=True
    ):
        if target is not None and result is not None:
            rows.append(
                {
                    "uav": uav.name,
                    "target": mission.scenario.targets[target].name,
                    "status": result.status.value,
                    "cost": result.cost if result.path.size else None,
                    "optimum" if exact else "bound": result.bound,
                    "gap": result.gap,
                    "departs at": None if trajectory is None else trajectory.start,
                    "arrives at": None if trajectory is None else trajectory.end,
                    "flies": None if trajectory is None else trajectory.form,
                    "generated paths": result.effort.generated_paths,
                    "flight": None if flight is None else asdict(flight),
                    **{term: result.terms.get(term) for term in terms},
                }
            )
    if as_json:
        summary = {
            "mission": str(written[0]),
            "page": str(written[1]) if len(written) > 1 else None,
            "cost": mission.cost if len(costs) == 1 else None,
            "costs": costs,
            "total_time": mission.total_time,
            "makespan": mission.makespan,
            "deconfliction": None if mission.deconfliction is None else asdict(mission.deconfliction),
            "certificates": [None if c is None else certificate_data(c) for c in mission.certificates],
            "apart": None if mission.apart is None else certificate_data(mission.apart),
            "scenario": {"name": mission.scenario.name, "sha256": mission.scenario.digest},
            "interrupted": mission.interrupted,
            "provenance": asdict(mission.provenance),
            "uavs": rows,
            "violations": [violation_data(v) for v in mission.violations],
        }
        print(json_text(summary), end="")
        return
    _report_flights(mission)
    if details and rows:
        heads = [head for head in rows[0] if head not in ("flight", "target", "status", "gap")]
        table(heads, [[_cell(row[head]) for head in heads] for row in rows])
    if any(result.status.value == "optimal" for result in results):
        print("Paths called optimal are so as claimed by the planner; skyverse check --optimality searches anew.")
    if results:
        planners = dict.fromkeys(result.provenance.planner.partition("(")[0] for result in results)
        print(f"planned by {' and '.join(planners)}")
    sums = [f"{value:.6g}{f' {unit}' if len(costs) > 1 else ''}" for unit, value in costs.items()]
    total = " and ".join(sums) or "-"
    times = f"total time {mission.total_time:.1f} s, makespan {mission.makespan:.1f} s"
    print(f"total cost {total}, {times}{'' if mission.seed is None else f', seed {mission.seed}'}")
    told = gaps_sentence(mission)
    if told:
        print(told)
    _report_conflicts(mission)
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None and trajectory.note:
            print(f"{uav.name} flies {trajectory.form}: {trajectory.note}")
    if mission.interrupted:
        print("Interrupted: this is the best so far.")
    for result in {r.status: r for r in mission.results if r is not None and not r.status.reached}.values():
        print(f"{result.status.value}: {result.status.sentence}")
    for violation in mission.violations:
        print(f"{violation.fault.value}: {violation.message}")
    if not mission.violations:
        print("The referee found nothing wrong.")
        if mission.complete and mission.apart is not None:
            print(f"Proven at every instant: {what_is_proven(mission.scenario)}.")
            columns = named_columns(mission.scenario, mission.assignment)
            if columns:
                print(columns)
        print(f"Judged by scenario {mission.scenario.name!r} ({short(mission.scenario.digest)}).")
    for path in written:
        print(path)


def _report_flights(mission: "Mission") -> None:
    """Print what each UAV flies: how far, how steeply, how high, how long, and with how much energy."""
    from skyverse.model.flight_measures import measure_flight
    from skyverse.model.gaps import told_gap
    from skyverse.model.seconds import told_seconds
    from skyverse.model.short_lines import told_metres

    terrain = mission.scenario.terrain
    height = "altitude" if terrain is None else "above ground"
    rows = []
    flights = mission.flights or (None,) * len(mission.scenario.uavs)
    for uav, target, result, trajectory, flight in zip(
        mission.scenario.uavs, mission.assignment, mission.results, mission.trajectories, flights, strict=True
    ):
        if target is None or result is None:
            continue
        cost = f"{result.cost:.6g}" if result.path.size else "-"
        found = [uav.name, mission.scenario.targets[target].name, result.status.value, cost, told_gap(result.gap)]
        if trajectory is None or flight is None:
            rows.append([*found, *["-"] * 6])
            continue
        measures = measure_flight(trajectory, terrain)
        found += [told_metres(flight.length), f"{measures.climb:.1f} m", f"{measures.steepest:.0f}\N{DEGREE SIGN}"]
        found += [f"{measures.lowest:.1f} to {measures.highest:.1f} m", told_seconds(flight.time)]
        rows.append([*found, "-" if flight.energy is None else f"{flight.energy / 1000:.3g} kJ/kg"])
    if rows:
        heads = ["uav", "target", "status", "cost", "gap at most"]
        table([*heads, "flown", "climb", "steepest", height, "time", "energy"], rows)


def gaps_sentence(mission: "Mission") -> str:
    """Return what the gaps of a mission are counted from; nothing where no path has any."""
    from skyverse.model.gaps import SMALLEST_GAP

    results = [result for result in mission.results if result is not None]
    if not any(result.gap is not None and result.gap > SMALLEST_GAP for result in results):
        return ""
    if not any(result.any_angle for result in results):
        return "Gaps are counted from the cheapest path on the same lattice."
    turn = mission.scenario.objective.divergence
    straight = sum(result.bounded_by_straight_line(turn) for result in results)
    many = "every UAV" if straight == len(results) else f"{straight} of {len(results)} UAVs"
    line = f", for {many} that of the straight line" if straight else ""
    return f"Gaps are counted from a cost that no path beats{line}; the best possible path may cost more."


def certificate_data(certificate: "Certificate") -> dict[str, Any]:
    """Return a certificate as plain data."""
    return asdict(certificate) | {"verdict": certificate.verdict.value}


def _report_conflicts(mission: "Mission") -> None:
    """Print how many conflicts there were, and what was done."""
    done = mission.deconfliction
    if done is None or not done.found:
        return
    before, after = f"{done.total_before:.1f} s", f"{done.total_after:.1f} s"
    many = "1 conflict" if len(done.found) == 1 else f"{len(done.found)} conflicts"
    print(
        f"{many} between UAVs found, {len(done.left)} left: total time {before} -> {after}, "
        f"makespan {done.makespan_before:.1f} s -> {done.makespan_after:.1f} s"
    )
    for action in done.actions:
        print(f"{action.kind}: {action.sentence}")


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, aside: bool = False) -> None:
    """Print a table on standard output, or `aside`, on standard error."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    stream = sys.stderr if aside else sys.stdout
    console = Console(width=None if stream.isatty() else 140, stderr=aside)
    table = Table(*head, box=None, header_style="bold", pad_edge=False)
    for row in rows:
        table.add_row(*map(escape, row))  # names may have brackets, which rich would read as markup
    console.print(table)
