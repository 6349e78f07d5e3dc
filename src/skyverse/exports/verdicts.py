"""What matters most of each exported flight, and a table of it."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.exports.autopilots import End
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import origin_of
from skyverse.exports.requirements import ExportOptions
from skyverse.exports.separation import Apart, FleetApart, circle_reach, few
from skyverse.exports.way_home import WayHome
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_seconds
from skyverse.model.uav import UAV

MAX_GAPS = 2
"""Times without a way home that a line of the table tells; of more it says only how many."""
MAX_OTHERS = 3
"""Names of other UAVs in a cell of the table; of more it says only how many."""
HEADS = ("UAV", "legs", "at its end", "way home, m above home", "apart in flight")
"""The columns of the table."""
AT_END = {"loiter": "stays at its target", "land": "lands below its target", "rtl": "lands at home"}
"""How the table tells what UAVs do at their ends."""
KEPT = {
    Apart.SPACE: "in space",
    Apart.TIMING: "by timing",
    Apart.SCHEDULE: f"{Caution.ONLY} on schedule",
    Apart.CLOSE: Caution.NOT,
}
"""How the table tells the ways to keep a separation."""


class ExportedFleet(NamedTuple):
    """All that is told of an export: its flight plans and their ways home, how they are apart, and what was asked."""

    mission: Mission
    plans: Sequence[FlightPlan]
    returns: Sequence[WayHome | None]
    apart: FleetApart
    options: ExportOptions

    @property
    def scenario(self) -> Scenario:
        """The mission's scenario, with an origin."""
        return self.mission.scenario

    @property
    def flying(self) -> dict[int, UAV]:
        """The UAVs that fly, by their indices."""
        return {plan.route.uav: self.scenario.uavs[plan.route.uav] for plan in self.plans}

    def name(self, plan: FlightPlan) -> str:
        """Return what the flight of a plan is called."""
        return plan.route.name(self.scenario)

    def place(self, place: Floats) -> tuple[float, float, float]:
        """Return latitude, longitude and altitude above mean sea level of a place, (3,) metres."""
        latitude, longitude, sea = to_wgs84(origin_of(self.scenario), place[None])[0].tolist()
        return latitude, longitude, sea


@dataclass(frozen=True)
class FlightVerdict:
    """What matters most of one exported flight.

    Attributes
    ----------
    uav
        The name of the UAV and, where it has several, its sortie.
    legs_proven
        Whether all that is flown between its waypoints is proven clear; not so for an aeroplane whose autopilot turns
        at a distance of its own.
    at_end
        What it does at its end, in words: whether it stays or circles, and otherwise where it lands.
    duration
        Seconds from the start of all UAVs to its last waypoint.
    gaps
        Seconds of the exported schedule between which no way home is proven; all of the flight where none is at all.
    apart
        The least sure way in which it keeps its separation from any other UAV; ``None`` if it flies alone.
    depends_on
        The UAVs from which it is apart in no surer way than that, unless it is apart from all in space.
    return_altitude
        Metres above home at which it returns; ``None`` where its file names none.
    begin
        Seconds from the start of all UAVs to that of this flight: later than 0 for later sorties.
    """

    uav: str
    legs_proven: bool
    at_end: str
    duration: float
    gaps: tuple[tuple[float, float], ...]
    apart: Apart | None
    depends_on: tuple[str, ...]
    return_altitude: float | None = None
    begin: float = 0.0

    @property
    def has_way_home(self) -> bool:
        """Whether its way home is proven at every instant."""
        return not self.gaps

    @property
    def row(self) -> tuple[str, ...]:
        """Its line of the table."""
        legs = "proven" if self.legs_proven else f"{Caution.NOT} proven at corners"
        up = "" if self.return_altitude is None else f", {self.return_altitude:.4g} m up"
        cells = (self.uav, legs, self.at_end, self._way_home + up)
        if self.apart is None:
            return cells
        flying = KEPT[self.apart] + (f" from {few(self.depends_on, MAX_OTHERS)}" if self.depends_on else "")
        return (*cells, flying)

    @property
    def _way_home(self) -> str:
        if self.has_way_home:
            return "at every instant"
        if self.gaps[0][0] <= self.begin and self.gaps[-1][1] >= self.duration and len(self.gaps) == 1:
            return f"{Caution.NOT} proven"
        spans = [f"{told_seconds(begin).removesuffix(' s')} to {told_seconds(end)}" for begin, end in self.gaps]
        return f"{Caution.NOT} from {few(spans, MAX_GAPS)}"


@dataclass(frozen=True, eq=False)
class ExportCertificate:
    """What is proven of exported waypoints.

    Attributes
    ----------
    apart
        How each two UAVs keep their separation.
    returns
        The way home of each UAV that flies, ``None`` for an aeroplane.
    flights
        What matters most of each UAV that flies.
    """

    apart: FleetApart
    returns: tuple[WayHome | None, ...]
    flights: tuple[FlightVerdict, ...]


def end_of(plan: FlightPlan) -> End:
    """Return what is said of the end of a flight plan: at home all land as after a return."""
    return "rtl" if plan.route.to_home else plan.end


def flight_verdicts(fleet: ExportedFleet) -> tuple[FlightVerdict, ...]:
    """Return the verdict on each UAV that flies."""
    names = {plan.route.uav: fleet.scenario.uavs[plan.route.uav].name for plan in fleet.plans}
    made = []
    for plan, back in zip(fleet.plans, fleet.returns, strict=True):
        uav = plan.route.uav
        kinds = {other: fleet.apart.pairs[min(uav, other), max(uav, other)] for other in names if other != uav}
        weakest = max(kinds.values(), key=list(Apart).index, default=None)
        timed = [names[other] for other in kinds if weakest is not Apart.SPACE and kinds[other] is weakest]
        duration, reach = float(plan.arrivals[-1]), circle_reach(fleet.scenario, uav)
        gaps = ((plan.begin, duration),) if back is None else tuple((gap.begin, gap.end) for gap in back.gaps)
        circles = (
            f"circles within {reach:.3g} m of its {'start' if plan.route.to_home else 'target'} ({Caution.NOT} proven)"
        )
        at_end, up = circles if reach else AT_END[end_of(plan)], None if back is None else back.altitude
        of = fleet.name(plan), plan.corners_proven, at_end, duration, gaps, weakest, tuple(timed), up, plan.begin
        made.append(FlightVerdict(*of))
    return tuple(made)


def verdict_table(flights: Sequence[FlightVerdict]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the table of some flights; the last row is the fleet's, if there are several."""
    rows = [flight.row for flight in flights]
    if len(flights) > 1:
        rows.append(_fleet_row(flights))
    return HEADS[: len(rows[0])] if rows else HEADS, rows


def _fleet_row(flights: Sequence[FlightVerdict]) -> tuple[str, ...]:
    """Return the line of the fleet: of how many UAVs each good thing holds."""
    count, ends = len(flights), Counter(flight.at_end.partition(",")[0] for flight in flights)
    kinds = [flight.apart for flight in flights if flight.apart is not None]

    def share(held: int, good: str, bad: str) -> str:
        return good if held == count else f"{bad} for {count - held} of {count}"

    return (
        "fleet",
        share(sum(flight.legs_proven for flight in flights), "proven", f"{Caution.NOT} proven at corners"),
        next(iter(ends)) if len(ends) == 1 else "; ".join(f"{words}: {number}" for words, number in ends.items()),
        share(sum(flight.has_way_home for flight in flights), "at every instant", f"{Caution.NOT} at every instant"),
        *((KEPT[max(kinds, key=list(Apart).index)],) if kinds else ()),
    )
