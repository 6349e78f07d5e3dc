"""All that a picture of a mission shows, as data, for pages and figures alike."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Literal, TypeVar

import numpy as np

from skyverse.draw.drawn_world import DrawnWorld, Overhead, overhead, world
from skyverse.draw.landing_place import LandingPlace
from skyverse.draw.profile import Profile, profile
from skyverse.draw.track import Point, Track, track
from skyverse.model.kept_ellipsoid import kept_ellipsoid
from skyverse.model.mission import Mission
from skyverse.model.result import Provenance, Result, Status
from skyverse.model.scenario import Scenario, Target
from skyverse.model.verdict import Fault, Verdict, Violation
from skyverse.space.named_columns import NamedColumn, fleet_columns

Thing = TypeVar("Thing")

MAX_PROFILE_POINTS = 10_000
"""The largest number of points of all profiles together."""


@dataclass(frozen=True)
class TableRow:
    """One UAV's row in the table; values that do not exist are ``None``.

    `gap` is in per cent, `length` in metres; `duration` is that of the flight and `seconds` that of the search. `terms`
    are the weighted shares of the cost.
    """

    uav: str
    colour: str
    target: str | None
    status: Status | None
    cost: float | None = None
    optimum: float | None = None
    gap: float | None = None
    terms: Mapping[str, float] = field(default_factory=dict)
    length: float | None = None
    duration: float | None = None
    generated_paths: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class SceneFinding:
    """One thing that the referee found wrong: a warning where UAVs come too close, otherwise an error."""

    severity: Literal["warning", "error"]
    kind: str
    uavs: tuple[str, ...]
    message: str
    time: float | None
    position: Point | None


@dataclass(frozen=True)
class Totals:
    """Sums over the fleet.

    `costs` are the sums of costs by unit. `optimum` and `gap` (per cent) are ``None`` unless every bound is known and
    all costs are in one unit.
    """

    uavs: int
    targeted: int
    reached: int
    costs: Mapping[str, float]
    optimum: float | None
    gap: float | None
    makespan: float | None
    seconds: float
    generated_paths: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """All that a picture shows, of a scenario or of a mission.

    `spare_targets` are the names and positions of targets to which no UAV flies; `findings` are what is wrong. The
    planning of a mission may have been `interrupted`. The `columns` over starts and targets are those of a mission that
    is proven. The `landings` are the places where UAVs of an export may land when they return.
    """

    scenario: Scenario
    tracks: tuple[Track, ...]
    spare_targets: tuple[tuple[str, Point], ...]
    findings: tuple[SceneFinding, ...]
    interrupted: bool = False
    columns: tuple[NamedColumn, ...] = ()
    landings: tuple[LandingPlace, ...] = ()
    spare_note: ClassVar[str] = ""
    """What is said of a spare target besides its name."""
    spare_colour: ClassVar[str] = "#b5179e"
    """The colour of spare targets, which stands out where no path leads to them."""

    @property
    def makespan(self) -> float | None:
        """Seconds until the last arrival; ``None`` where no UAV flies."""
        return max((track.arrival for track in self.tracks if track.arrival is not None), default=None)

    @cached_property
    def separations(self) -> tuple[tuple[float, float], ...]:
        """Half the semi-axes, horizontal and vertical, of the ellipsoid that another such UAV must keep out of, metres.

        Two UAVs of one kind are apart where these smaller ellipsoids around both do not meet. A UAV alone has none.
        """
        uavs = self.scenario.uavs
        if len(uavs) < 2:
            return ((0.0, 0.0),) * len(uavs)
        kept = (kept_ellipsoid(uav, uav) for uav in uavs)
        return tuple((aside / 2, up / 2) for aside, up in kept)

    @cached_property
    def world(self) -> DrawnWorld:
        """The obstacles, zones and ground."""
        return world(self.scenario, self.tracks)

    @cached_property
    def overhead(self) -> Overhead:
        """The ground and the degrees of the map."""
        return overhead(self.scenario, self.world)

    @cached_property
    def profiles(self) -> tuple[Profile, ...]:
        """The altitude profile of each track."""
        most = MAX_PROFILE_POINTS // max(1, len(self.tracks))
        return tuple(profile(track, self.scenario, self.world.kinds, most) for track in self.tracks)


@dataclass(frozen=True, eq=False, kw_only=True)
class MissionScene(Scene):
    """All that a picture of a mission shows.

    `curves` are the tracks and results of searches that kept their history; `notes` say what the mission lacks, even
    where the referee found nothing wrong. The mission is `complete` when every UAV that has a target has a path to it
    and, where any UAV flies, a trajectory along the path. `bound` says what the optimum is: exact on the lattice, but a
    lower bound where a path leaves the lattice or its cost has more terms than fuel, turns and end. The mission is
    `judged` where it has a certificate of the fleet, which no file holds. It is `proven` when its certificates say that
    the referee proved all of it at every instant. The `export_notes` are what an export says of its waypoints, and
    the `export_verdicts` are the head and the lines of its table, the columns of a line as words.
    """

    bound: Literal["exact optimum", "lower bound"]
    curves: tuple[tuple[Track, Result], ...]
    rows: tuple[TableRow, ...]
    notes: tuple[str, ...]
    totals: Totals
    complete: bool
    judged: bool
    proven: bool
    provenance: Provenance
    export_notes: tuple[str, ...] = ()
    export_verdicts: tuple[tuple[str, ...], ...] = ()
    spare_note: ClassVar[str] = " (no UAV flies here)"
    spare_colour: ClassVar[str] = "#8a94a3"


def scene(mission: Mission) -> MissionScene:
    """Return the scene of `mission`, which may be one that the referee found wrong."""
    scenario = mission.scenario
    targets: list[Target | None] = []
    tracks: list[Track] = []
    results: list[Result | None] = []
    for number, uav in enumerate(scenario.uavs):
        wanted = _nth(mission.assignment, number)
        targets.append(None if wanted is None else _nth(scenario.targets, wanted))
        results.append(_nth(mission.results, number))
        flight = _nth(mission.trajectories, number)
        tracks.append(track(uav, number, targets[-1], results[-1], flight, scenario.bounds))
    answers = list(zip(tracks, results, strict=True))
    rows = [_row(track, result) for track, result in answers]
    flies = any(track.arrival is not None for track in tracks)
    notes = [_note(track, row, flies) for track, row in zip(tracks, rows, strict=True)]
    proven = mission.apart is not None and mission.apart.verdict is Verdict.PROVEN and not mission.violations
    return MissionScene(
        scenario=scenario,
        bound="exact optimum" if all(r is None or _exactly_bounded(r) for r in results) else "lower bound",
        tracks=tuple(tracks),
        spare_targets=tuple((spare.name, spare.position) for spare in scenario.targets if spare not in targets),
        curves=tuple((track, result) for track, result in answers if result and len(result.history.cost) > 1),
        rows=tuple(rows),
        findings=tuple(finding_of(scenario, violation) for violation in mission.violations),
        notes=tuple(track.name + note for track, note in zip(tracks, notes, strict=True) if note),
        totals=_totals(mission.costs, tracks, [result for result in results if result is not None]),
        complete=not any(note and target is not None for note, target in zip(notes, targets, strict=True)),
        interrupted=mission.interrupted,
        judged=mission.apart is not None,
        proven=proven,
        columns=tuple(fleet_columns(scenario, mission.assignment)) if proven else (),
        provenance=mission.provenance,
    )


def _nth(things: Sequence[Thing | None], number: int) -> Thing | None:
    return things[number] if 0 <= number < len(things) else None


def _exactly_bounded(result: Result) -> bool:
    return not result.any_angle and result.terms.keys() <= {"fuel", "divergence", "end"}


def _row(track: Track, result: Result | None) -> TableRow:
    if result is None:
        return TableRow(track.name, track.colour, track.target_name, None)
    steps = np.linalg.norm(np.diff(result.path, axis=0), axis=1)
    return TableRow(
        uav=track.name,
        colour=track.colour,
        target=track.target_name,
        status=result.status,
        cost=result.cost,
        optimum=result.bound,
        gap=_gap(result.cost, result.bound) if result.status.reached else None,
        terms=result.terms,
        length=float(steps.sum()) if len(result.path) else None,
        duration=None if track.arrival is None else float(track.arrival - track.times[0]),
        generated_paths=result.effort.generated_paths,
        seconds=result.seconds,
    )


def _gap(cost: float, bound: float | None) -> float | None:
    """Return by how many per cent `cost` exceeds `bound`; 0 where both are 0, ``None`` where there is no gap."""
    if bound is None:
        return None
    return 100.0 * (cost / bound - 1.0) if bound else 0.0 if cost == 0 else None


def finding_of(scenario: Scenario, violation: Violation) -> SceneFinding:
    """Return a violation as it is drawn."""
    uavs = (_nth(scenario.uavs, uav) for uav in violation.uavs)
    return SceneFinding(
        severity="warning" if violation.fault is Fault.SEPARATION else "error",
        kind=violation.fault.value,
        uavs=tuple(uav.name for uav in uavs if uav is not None),
        message=violation.message,
        time=violation.time,
        position=violation.position,
    )


def _note(track: Track, row: TableRow, flies: bool) -> str:
    if track.target is None:
        return " has no target and stays at its start."
    if row.status is None:
        return " has a target but was not planned."
    if not row.status.reached:
        return f": {row.status.sentence}"
    return " has a path but no trajectory along it." if flies and track.arrival is None else ""


def _totals(costs: dict[str, float], tracks: list[Track], results: list[Result]) -> Totals:
    bounds = [result.bound for result in results if result.bound is not None and result.status.reached]
    optimum = sum(bounds) if len(costs) == 1 and len(bounds) == len(results) else None
    return Totals(
        uavs=len(tracks),
        targeted=sum(track.target is not None for track in tracks),
        reached=sum(result.status.reached for result in results),
        costs=costs,
        optimum=optimum,
        gap=None if optimum is None else _gap(sum(costs.values()), optimum),
        makespan=max((track.arrival for track in tracks if track.arrival is not None), default=None),
        seconds=sum(result.seconds for result in results),
        generated_paths=sum(result.effort.generated_paths for result in results),
    )
