"""The numbers of a mission as people read them: tables of flights and of searches, and sentences beside them.

How far, how steeply and how high a trajectory flies is read off at samples; no proof rests on it.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import Remedy, Sentence
from skyverse.model.arrays import arctan2
from skyverse.model.mission import Mission, PlannedFlight, planned_flights
from skyverse.model.power import JOULES_OF_WATT_HOUR, TRUSTED_SHARE
from skyverse.model.result import Result
from skyverse.model.shapes import Terrain
from skyverse.model.short_lines import SMALLEST_GAP, counted, listed, told_gap, told_metres, told_seconds, told_share
from skyverse.model.timed_shapes import temporary_zones
from skyverse.model.trajectory import Trajectory

SAMPLES = 16
"""Samples of each piece of a trajectory at least."""
MAX_SAMPLES = 100_000
"""Samples of a trajectory at most, unless its pieces alone need more, which bounds time and memory."""
APART = 1.0
"""Metres, about, between the places along a flight."""
MIN_PLACES, MAX_PLACES = 1000, 20_000
"""Places along a flight at least and at most."""
LEAST_STEP = 1e-3
"""Metres between two samples at least, for the slope from one to the next to count."""


@dataclass(frozen=True)
class FlightMeasures:
    """What is read off a flight at samples.

    Attributes
    ----------
    length
        Metres that are flown.
    climb
        Metres that are climbed, all climbs together.
    steepest
        The largest angle between the flight and the horizontal, up or down, degrees.
    lowest, highest
        The least height above the terrain, and the greatest above its lowest heights, from which a ceiling is counted;
        z where there is no terrain. Metres.
    """

    length: float
    climb: float
    steepest: float
    lowest: float
    highest: float


def measure_flight(trajectory: Trajectory, terrain: Terrain | None = None) -> FlightMeasures:
    """Return what is read off a trajectory at `SAMPLES` samples of each piece, and at two in each cell of a terrain."""
    points = trajectory.at(_sample_times(trajectory, math.inf if terrain is None else min(terrain.step) / 2)).position
    steps = np.diff(points, axis=0)
    distances, rises = np.linalg.norm(steps, axis=1), steps[:, 2]
    slopes = arctan2(np.abs(rises), np.linalg.norm(steps[:, :2], axis=1))[distances >= LEAST_STEP]
    lowest = highest = points[:, 2]
    if terrain is not None:
        lowest = points[:, 2] - terrain.height(points[:, :2])
        highest = points[:, 2] - terrain.lowest_ground.height(points[:, :2])
    return FlightMeasures(
        length=float(distances.sum()),
        climb=float(rises[rises > 0].sum()),
        steepest=math.degrees(float(slopes.max(initial=0.0))),
        lowest=float(lowest.min()),
        highest=float(highest.max()),
    )


def places_along(trajectory: Trajectory) -> Floats:
    """Return places (n, 3) along a trajectory, metres, at equal times, about `APART` metres from one another."""

    def places(count: int) -> Floats:
        return trajectory.at(np.linspace(trajectory.start, trajectory.end, count)).position

    rough = places(MIN_PLACES)
    wanted = int(min(float(np.linalg.norm(np.diff(rough, axis=0), axis=1).sum()) / APART, MAX_PLACES))
    return rough if wanted <= MIN_PLACES else places(wanted)


def _sample_times(trajectory: Trajectory, apart: float) -> Floats:
    """Return instants (m,), seconds: the same number in each piece, about `apart` metres of flight from one another."""
    pieces = len(trajectory.coefficients)
    for_length = 1
    if math.isfinite(apart):
        rough = trajectory.at(trajectory.instants(SAMPLES)).position
        legs = np.linalg.norm(np.diff(rough, axis=0), axis=1)
        for_length = math.ceil(SAMPLES * min(float(legs.max()) / apart, MAX_SAMPLES / pieces))
    return trajectory.instants(max(SAMPLES, min(for_length, MAX_SAMPLES // pieces)))


NO_VALUE = "-"
"""What stands in a table where there is no value."""
SHORTEST_WAIT = 0.005
"""Seconds before departure that are told; less would be told as none."""
SAME_LENGTH = 1e-3
"""The share of a length by which a cost that differs is told beside it."""
EXACT_TERMS = {"fuel", "divergence", "end"}
"""The terms of a cost of which exact search on the lattice finds the optimum."""
_TERMS = {"altitude": "outside band", "climb": "steepness"}

BoundKind = Literal["exact optimum", "straight line", "lower bound"]


@dataclass(frozen=True)
class Column:
    """A column of a table: its head, what it means in one sentence, and a cell for each row, as for each UAV."""

    head: str
    meaning: str
    cells: tuple[str, ...]


def flight_columns(mission: Mission) -> list[Column]:
    """Return the table of flights: who goes where, at what cost, how far, how steeply, how high and how long."""
    flights, terrain = planned_flights(mission), mission.scenario.terrain
    measures = [None if one.trajectory is None else measure_flight(one.trajectory, terrain) for one in flights]
    above = ("altitude", "Least and greatest z of the flight.")
    if terrain is not None:
        above = ("above ground", "Least and greatest height of the flight above the terrain below.")
        if terrain.lowest is not None:
            above = ("above ground", "Least height above the raised terrain, greatest above its lowest heights.")

    def measured(told: Callable[[FlightMeasures], str]) -> tuple[str, ...]:
        return tuple(NO_VALUE if one is None else told(one) for one in measures)

    energies = [None if one.summary is None else one.summary.energy for one in flights]
    energy = tuple(NO_VALUE if value is None else told_energy(value) for value in energies)
    columns = [
        Column("UAV", "", tuple(one.uav.name for one in flights)),
        Column("target", "", tuple(map(_targets, flights))),
        Column("status", "How the search for the path ended.", tuple(one.status for one in flights)),
        Column("cost", "What the objective counts of the path.", tuple(_cost(one, mission) for one in flights)),
        Column(
            "gap at most",
            f"How far the cost is above the {bound_kind(mission)}, rounded up.",
            tuple(told_gap(None if one.result is None else one.result.gap) for one in flights),
        ),
        Column("flown", "Length of the flight.", tuple(map(_length, flights, measures))),
        Column("climb", "All climbs together.", measured(lambda one: told_metres(round(one.climb, 1)))),
        Column("steepest", "Largest slope, up or down.", measured(lambda one: f"{one.steepest:.0f}\N{DEGREE SIGN}")),
        Column(*above, measured(lambda one: f"{one.lowest:.1f} to {one.highest:.1f} m")),
        Column("time", "From departure to arrival, without a wait before it.", _of_trajectories(flights, _time)),
        Column("energy", "By the power that the UAV takes at its airspeeds, climbs and loads.", energy),
        Column(
            "battery left",
            f"At landing, of the {TRUSTED_SHARE:.0%} of the battery that count, and how near that is to the reserve.",
            tuple(map(_left, flights)),
        ),
    ]
    return [one for one in _told(columns) if one.head != "cost" or not _costs_are_lengths(flights)]


def _told(columns: Sequence[Column]) -> list[Column]:
    """Return the columns that tell anything of anybody."""
    return [one for one in columns if not one.cells or set(one.cells) - {NO_VALUE}]


def _costs_are_lengths(flights: Sequence[PlannedFlight]) -> bool:
    """Return whether the cost of each path is what is flown, so that one number tells both."""
    pairs = [(one.result.cost, one.summary.length) for one in flights if one.result is not None and one.summary]
    return bool(pairs) and all(abs(cost - length) <= SAME_LENGTH * length for cost, length in pairs)


def search_columns(mission: Mission) -> list[Column]:
    """Return the table of searches, for those who study planners: bounds, terms of the cost, effort and timing."""
    flights = planned_flights(mission)
    found = [one.result for one in flights if one.result is not None]
    terms = list(dict.fromkeys(term for result in found for term in result.terms))
    bound = bound_kind(mission)

    def searched(told: Callable[[Result], str]) -> tuple[str, ...]:
        return tuple(NO_VALUE if one.result is None else told(one.result) for one in flights)

    columns = [
        Column("UAV", "", tuple(one.uav.name for one in flights)),
        Column("cost", "The terms together.", searched(lambda one: _plain(one.cost))),
        Column(bound, _BOUND_MEANINGS[bound], searched(lambda one: _plain(one.bound))),
        *(
            Column(_TERMS.get(term, term), "Its weighted share of the cost.", searched(_share_of(term)))
            for term in terms
        ),
        Column("generated paths", "By the search.", searched(lambda one: f"{one.effort.generated_paths:,}")),
        Column("search", "Wall-clock time of the search.", searched(lambda one: _duration(one.seconds))),
        Column("departs at", "", _instants(flights, lambda one: one.start)),
        Column("arrives at", "", _instants(flights, lambda one: one.end)),
        Column("flies", "The form of the trajectory.", _of_trajectories(flights, lambda one: one.form)),
    ]
    return _told(columns)


_BOUND_MEANINGS: dict[BoundKind, str] = {
    "exact optimum": "The cheapest path on the same lattice.",
    "straight line": "The cost of the straight line, which no path beats.",
    "lower bound": "A cost that no path beats; it may be far below that of the best path.",
}


def bound_kind(mission: Mission) -> BoundKind:
    """Return what the bounds of a mission's paths are: optima on the lattice, straight lines, or other lower bounds."""
    found = [one.result for one in planned_flights(mission) if one.result is not None]
    if not any(result.any_angle for result in found) and all(result.terms.keys() <= EXACT_TERMS for result in found):
        return "exact optimum"
    straight = [result.straight_bound for result in found if result.bound is not None]
    return "straight line" if straight and all(straight) else "lower bound"


def gaps_sentence(mission: Mission) -> str:
    """Return what the gaps of a mission are counted from; nothing where no path has any."""
    found = [one.result for one in planned_flights(mission) if one.result is not None]
    if not any(result.gap is not None and result.gap > SMALLEST_GAP for result in found):
        return ""
    if not any(result.any_angle for result in found):
        return "Gaps are counted from the cheapest path on the same lattice."
    straight = sum(result.straight_bound for result in found)
    many = "every UAV" if straight == len(found) else f"{straight} of {len(found)} UAVs"
    line = f", for {many} that of the straight line" if straight else ""
    return f"Gaps are counted from a cost that no path beats{line}; the best possible path may cost more."


def battery_sentence(mission: Mission) -> str:
    """Return why no battery is told to be full; nothing where nobody has one."""
    if not any(one.summary is not None and one.summary.left is not None for one in planned_flights(mission)):
        return ""
    counts = f"Of a full battery {told_share(TRUSTED_SHARE)} count, as the model of its power may be off by the rest"
    return f"{counts}; take-offs, landings and gusts at their worst are taken off."


def idle_sentence(mission: Mission) -> str:
    """Return how UAVs get work that have none while others make tours; nothing where that cannot be."""
    targets, visits = mission.scenario.targets, list[set[int]]()
    for uav in range(len(mission.scenario.uavs)):
        visits.append({visit.target for sortie in mission.sorties_of(uav) for visit in sortie.visits})
    shared = {target for own in visits if len(own) > 1 for target in own}
    idle = [
        uav.name
        for uav, own in zip(mission.scenario.uavs, visits, strict=True)
        if not own and any(uav.name in (targets[k].uavs or uav.name) for k in shared)
    ]
    if not idle or "criterion='min-sum'" not in mission.provenance.planner:
        return ""
    said = f"{listed(idle)} {'has' if len(idle) == 1 else 'have'} no target, as the sum of all costs is the least so"
    return Sentence(said, give=[Remedy("criterion", "min-max", "for the last UAV to be done as soon as possible")])


def unit_sentence(mission: Mission) -> str:
    """Return what the unit of the costs means where the objective counts nodes; nothing where it counts metres."""
    found = [one.result for one in planned_flights(mission) if one.result is not None and len(one.result.path)]
    if mission.scenario.objective.unit != "nodes" or not found:
        return ""
    counted = "The scenario's objective counts the nodes of its lattice that a path visits"
    if any(result.any_angle for result in found):
        lengths = 'in metres; "flown" compares it with others'
        return f"{counted}; a path of any angle leaves the lattice, so that its cost is {lengths}."
    return f"{counted}; paths of any angle, as of Taut, leave the lattice and cost metres."


def _targets(flight: PlannedFlight) -> str:
    """Return the target of a flight, or how many there are in a tour, its strips and its sorties."""
    visits, strips = (sum(len(getattr(one, kind)) for one in flight.sorties) for kind in ("visits", "strips"))
    if visits < 2 and not strips and len(flight.sorties) < 2:
        return NO_VALUE if flight.target is None else flight.target.name
    many = f" in {counted(len(flight.sorties), 'sortie')}" if len(flight.sorties) > 1 else ""
    done = [counted(number, word) for number, word in ((visits, "target"), (strips, "strip")) if number]
    return f"{' and '.join(done) or counted(0, 'target')}{many}"


def told_energy(joules: float) -> str:
    """Return an energy as batteries are labelled: ``3.27 Wh``."""
    return f"{joules / JOULES_OF_WATT_HOUR:.3g} Wh"


def _left(flight: PlannedFlight) -> str:
    left = None if flight.summary is None else flight.summary.left
    return NO_VALUE if left is None else told_left(left, flight.uav.reserve)


def told_left(left: float, reserve: float) -> str:
    """Return which share of a battery is left, and how far that is above or below its reserve, on the safe side."""
    spare = left - reserve
    side = (
        f"{math.floor(1000 * spare) / 10:.1f} % above" if spare >= 0 else f"{math.ceil(-1000 * spare) / 10:.1f} % below"
    )
    return f"{100 * left:.0f} %, {side} its reserve" if left > 0 else f"none, {side} its reserve"


def told_costs(costs: dict[str, float]) -> str:
    """Return sums of costs by unit, as in ``265 nodes and 24.60 m``."""
    told = [f"{value:,.2f} m" if unit == "metres" else f"{_plain(value)} {unit}" for unit, value in costs.items()]
    return " and ".join(told) or NO_VALUE


def _cost(flight: PlannedFlight, mission: Mission) -> str:
    if flight.result is None or not len(flight.result.path):
        return NO_VALUE
    return told_costs({"metres" if flight.result.any_angle else mission.scenario.objective.unit: flight.result.cost})


def _share_of(term: str) -> Callable[[Result], str]:
    return lambda result: _plain(result.terms.get(term))


def _plain(value: float | None) -> str:
    """Return a number in six digits, never in powers of ten where it is large."""
    if value is None or not math.isfinite(value):
        return NO_VALUE
    return f"{value:,.6g}" if abs(value) < 1e6 else f"{value:,.0f}"


def _duration(seconds: float) -> str:
    return f"{1000 * seconds:.1f} ms" if seconds < 0.1 else told_seconds(seconds)


def _length(flight: PlannedFlight, measures: FlightMeasures | None) -> str:
    """Return the length of a flight as the mission states it, or else as it is measured."""
    if measures is None:
        return NO_VALUE
    return told_metres(measures.length if flight.summary is None else flight.summary.length)


def _time(trajectory: Trajectory) -> str:
    """Return how long a flight takes, and beside it how long the UAV waits before it departs."""
    wait = "" if trajectory.start < SHORTEST_WAIT else f" + {told_seconds(trajectory.start)} wait"
    return f"{told_seconds(trajectory.end - trajectory.start)}{wait}"


def _instants(flights: Iterable[PlannedFlight], instant: Callable[[Trajectory], float]) -> tuple[str, ...]:
    return _of_trajectories(flights, lambda one: told_seconds(instant(one)))


def _of_trajectories(flights: Iterable[PlannedFlight], told: Callable[[Trajectory], str]) -> tuple[str, ...]:
    return tuple(NO_VALUE if one.trajectory is None else told(one.trajectory) for one in flights)


def planners_sentence(mission: Mission) -> str:
    """Return which planners found the paths, and which led some around others; nothing where there is no result."""
    done = mission.deconfliction
    led = set() if done is None else {one.uav for one in done.actions if one.kind in ("detour", "wait")}
    found = [(uav, _planner(result)) for uav, result in enumerate(mission.results) if result is not None]
    if not found:
        return ""
    own = dict.fromkeys(name for uav, name in found if uav not in led) or dict.fromkeys(name for _, name in found)
    others = Counter(name for uav, name in found if name not in own)
    around = "others or zones" if temporary_zones(mission.scenario) else "others"
    more = "".join(f"; {counted(many, 'path')} led around {around} by {name}" for name, many in others.items())
    return f"planned by {' and '.join(own)}{more}"


def unknown_gaps_sentence(mission: Mission) -> str:
    """Return why some complete paths have no gap in the table; nothing where each has one, or none."""
    found = [one.result for one in planned_flights(mission) if one.result is not None and one.result.status.reached]
    if len({result.bound is None for result in found}) < 2:
        return ""
    return 'Where the gap is "-", what the best possible path costs at least was not computed.'


def _planner(result: Result) -> str:
    return result.provenance.planner.partition("(")[0].removesuffix(", led around others")
