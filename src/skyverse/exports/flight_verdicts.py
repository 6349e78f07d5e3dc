"""What matters most of each exported flight: a few facts, and the line of a table that tells them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.draw import LandingPlace, page, scene
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import origin_of
from skyverse.exports.mavlink_formats import End
from skyverse.exports.separation import Apart, FleetApart, circle_reach
from skyverse.exports.way_home import WayHome
from skyverse.exports.waypoint_notes import few
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_seconds

MAX_GAPS = 2
"""Times without a way home that a line of the table tells; of more it says only how many."""
MAX_OTHERS = 3
"""Names of other UAVs in a cell of the table; of more it says only how many."""
HEADS = ("UAV", "legs", "at its end", "way home", "apart in flight")
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


@dataclass(frozen=True)
class FlightVerdict:
    """What matters most of one exported flight.

    Attributes
    ----------
    uav
        The name of the UAV.
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
    """

    uav: str
    legs_proven: bool
    at_end: str
    duration: float
    gaps: tuple[tuple[float, float], ...]
    apart: Apart | None
    depends_on: tuple[str, ...]
    return_altitude: float | None = None

    @property
    def has_way_home(self) -> bool:
        """Whether its way home is proven at every instant."""
        return not self.gaps

    @property
    def row(self) -> tuple[str, ...]:
        """Its line of the table."""
        legs = "proven" if self.legs_proven else f"{Caution.NOT} proven at corners"
        cells = (self.uav, legs, self.at_end, self._way_home)
        if self.apart is None:
            return cells
        flying = KEPT[self.apart] + (f" from {few(self.depends_on, MAX_OTHERS)}" if self.depends_on else "")
        return (*cells, flying)

    @property
    def _way_home(self) -> str:
        if self.has_way_home:
            return f"at every instant, {self.return_altitude:.4g} m up"
        if self.gaps[0][0] <= 0 and self.gaps[-1][1] >= self.duration and len(self.gaps) == 1:
            return f"{Caution.NOT} proven"
        spans = [f"{told_seconds(begin).removesuffix(' s')} to {told_seconds(end)}" for begin, end in self.gaps]
        return f"{Caution.NOT} from {few(spans, MAX_GAPS)}"


def flight_verdicts(
    scenario: Scenario,
    plans: Sequence[FlightPlan],
    end: End,
    apart: FleetApart,
    returns: Sequence[WayHome | None],
) -> tuple[FlightVerdict, ...]:
    """Return the verdict on each UAV that flies.

    Parameters
    ----------
    scenario, plans
        The scenario and the flight plans.
    end
        How the mission ends.
    apart
        How each two UAVs keep their separation.
    returns
        The way home of each flight plan, ``None`` for an aeroplane.
    """
    names = {plan.route.uav: scenario.uavs[plan.route.uav].name for plan in plans}
    made = []
    for plan, back in zip(plans, returns, strict=True):
        uav, others = plan.route.uav, [other for other in names if other != plan.route.uav]
        kinds = {other: apart.pairs[min(uav, other), max(uav, other)] for other in others}
        weakest = max(kinds.values(), key=list(Apart).index, default=None)
        timed = [other for other in others if weakest is not Apart.SPACE and kinds[other] is weakest]
        duration = float(plan.arrivals[-1])
        gaps = ((0.0, duration),) if back is None else tuple((gap.begin, gap.end) for gap in back.gaps)
        at_end = AT_END[end]
        if (reach := circle_reach(scenario, uav)) > 0:
            at_end = f"circles within {reach:.3g} m of its target ({Caution.NOT} proven)"
        made.append(
            FlightVerdict(
                names[uav],
                plan.corners_proven,
                at_end,
                duration,
                gaps,
                weakest,
                tuple(names[other] for other in timed),
                None if back is None else back.altitude,
            )
        )
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
        KEPT[max(kinds, key=list(Apart).index)],
    )


def write_export_page(
    path: Path,
    mission: Mission,
    flights: Sequence[FlightVerdict],
    returns: Sequence[WayHome | None],
    notes: Sequence[str],
) -> None:
    """Write the page of an export.

    Parameters
    ----------
    path
        The file.
    mission
        The mission with the referee's verdict, in a scenario with an origin.
    flights, returns
        The verdict on each UAV that flies, and its way home.
    notes
        What the export says, in sentences.
    """
    landings = tuple(_home(mission.scenario, back) for back in returns if back is not None)
    head, rows = verdict_table(flights)
    told = replace(scene(mission), landings=landings, export_notes=tuple(notes), export_verdicts=(head, *rows))
    write_text(path, page(told))


def _home(scenario: Scenario, back: WayHome) -> LandingPlace:
    """Return where a UAV lands when it returns, as it is drawn."""
    uav, (x, y, _) = back.plan.route.uav, back.plan.route.points[0].tolist()
    latitude, longitude, ground = to_wgs84(origin_of(scenario), back.plan.home[None])[0].tolist()
    words = (
        f"{scenario.uavs[uav].name}: home, {latitude:.6f}, {longitude:.6f}, {ground:z.1f} m above mean sea level; it "
        f"returns there {back.altitude:.4g} m above it, or higher"
    )
    return LandingPlace(uav, words, (x, y, float(back.plan.home[2])), back.level)
