"""All that a picture of a scenario, a mission or a flight shows, as data, for pages and figures alike."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.drawn_world import DrawnWorld, Overhead, overhead, world
from skyverse.draw.palette import TARGET_TO_REACH, TARGET_TO_SPARE
from skyverse.draw.photo_views import DrawnSurvey, drawn_surveys
from skyverse.draw.profile import Profile, profile
from skyverse.draw.track import DrawnTrack, Point, track
from skyverse.errors import in_words
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.flight_table import BoundKind, bound_kind
from skyverse.model.mission import Mission, PlannedFlight, planned_flights
from skyverse.model.replanned_flight import ReplannedFlight
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.uav import kept_ellipsoid
from skyverse.model.verdict import Fault, Verdict, Violation
from skyverse.space.mission_cautions import mission_cautions
from skyverse.space.pads import FleetPad, fleet_pads
from skyverse.space.unsafe_points import unsafe_points
from skyverse.tour_table import NumberedSortie, numbered_sorties, numbered_visits, planned_sheet

MAX_PROFILE_POINTS = 10_000
"""The largest number of points of all profiles together."""


@dataclass(frozen=True)
class LandingPlace:
    """Where a UAV may land when it returns.

    Attributes
    ----------
    uav
        Its index.
    words
        What is told of the place.
    position
        x, y, z in metres.
    level
        z at which the UAV returns there, unless it is higher already, metres.
    """

    uav: int
    words: str
    position: Point
    level: float


@dataclass(frozen=True)
class NumberedPlace:
    """A place to which the item of a mission leads.

    Attributes
    ----------
    uav, number
        The index of the UAV, and the item's number.
    position, time
        Metres, and seconds into the mission.
    wrong
        Whether something is wrong with what is flown there.
    """

    uav: int
    number: int
    position: Point
    time: float
    wrong: bool


@dataclass(frozen=True)
class SceneFinding:
    """One thing that is wrong: a warning where UAVs come too close, otherwise an error.

    Where a whole `stretch` of a flight is wrong, that is x, y, z and the seconds of its points, (n, 4).
    """

    severity: Literal["warning", "error"]
    kind: str
    uavs: tuple[str, ...]
    message: str
    time: float | None
    position: Point | None
    stretch: Floats | None = field(default=None, compare=False)


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """All that a picture shows, of a scenario or of a mission.

    `spare_targets` are the names and positions of targets to which no UAV flies; `findings` are what is wrong. The
    planning of a mission may have been `interrupted`. The `pads` at starts and targets are those of a mission that
    is proven. The `landings` are the places where UAVs of an export may land when they return. The `places` are those
    that are told by their numbers.
    """

    scenario: Scenario
    tracks: tuple[DrawnTrack, ...]
    spare_targets: tuple[tuple[str, Point], ...]
    findings: tuple[SceneFinding, ...]
    interrupted: bool = False
    pads: tuple[FleetPad, ...] = ()
    landings: tuple[LandingPlace, ...] = ()
    places: tuple[NumberedPlace, ...] = ()
    spare_note: ClassVar[str] = ""
    """What is said of a spare target besides its name."""
    spare_colour: ClassVar[str] = TARGET_TO_REACH
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

    @cached_property
    def surveys(self) -> tuple[DrawnSurvey, ...]:
        """The surveys; those of a mission with their photos."""
        return tuple(drawn_surveys(self.scenario))


@dataclass(frozen=True, eq=False, kw_only=True)
class MissionScene(Scene):
    """All that a picture of a mission shows.

    `curves` are the tracks and results of searches that kept their history; `notes` say what the mission lacks, even
    where the referee found nothing wrong. The mission is `complete` when every UAV that has a target has a path to it
    and, where any UAV flies, a trajectory along the path. `bound` says what costs are compared with. The mission is
    `judged` where it has a certificate of the fleet, which no file holds. It is `proven` when its certificates say that
    the referee proved all of it at every instant. The `cautions` are what a pilot must heed. The `export_notes` are
    what an export says of its waypoints, and the `export_verdicts` are the head and the lines of its table, the columns
    of a line as words. The `sheet` is such a table of what whoever prepares the flights must know.
    """

    mission: Mission
    bound: BoundKind
    curves: tuple[tuple[DrawnTrack, Result], ...]
    notes: tuple[str, ...]
    complete: bool
    judged: bool
    proven: bool
    cautions: tuple[str, ...] = ()
    export_notes: tuple[str, ...] = ()
    export_verdicts: tuple[tuple[str, ...], ...] = ()
    sheet: tuple[tuple[str, ...], ...] = ()
    spare_note: ClassVar[str] = " (no UAV flies here)"

    @cached_property
    def sorties(self) -> tuple[NumberedSortie, ...]:
        """The sorties of all UAVs."""
        return tuple(numbered_sorties(self.mission))

    @cached_property
    def surveys(self) -> tuple[DrawnSurvey, ...]:
        """The surveys with their photos."""
        return tuple(drawn_surveys(self.scenario, self.mission))

    spare_colour: ClassVar[str] = TARGET_TO_SPARE


def scene(mission: Mission) -> MissionScene:
    """Return the scene of `mission`, which may be one that the referee found wrong."""
    scenario, flights = mission.scenario, planned_flights(mission)
    visits = list(numbered_visits(mission))
    tracks = [
        track(flight, uav, scenario.bounds, tuple(one for one in visits if one.uav == uav))
        for uav, flight in enumerate(flights)
    ]
    flies = any(track.arrival is not None for track in tracks)
    notes = [_note(flight, flies) for flight in flights]
    targets = [flight.target for flight in flights]
    curves = ((track, flight.result) for track, flight in zip(tracks, flights, strict=True))
    proven = mission.apart is not None and mission.apart.verdict is Verdict.PROVEN and not mission.violations
    covered = tuple(one.sentence for one in mission.coverage)  # which stand on cards of their own
    cautions = (caution.sentence for caution in mission_cautions(mission))
    return MissionScene(
        scenario=scenario,
        mission=mission,
        bound=bound_kind(mission),
        tracks=tuple(tracks),
        spare_targets=tuple((scenario.targets[k].name, scenario.targets[k].position) for k in mission.spare_targets),
        places=tuple(
            NumberedPlace(one.uav, one.number, one.target.position, one.visit.arrival, False) for one in visits
        ),
        curves=tuple((track, result) for track, result in curves if result and len(result.history.cost) > 1),
        findings=tuple(finding_of(scenario, violation) for violation in mission.violations),
        notes=tuple(track.name + note for track, note in zip(tracks, notes, strict=True) if note),
        complete=not any(note and target is not None for note, target in zip(notes, targets, strict=True)),
        interrupted=mission.interrupted,
        judged=mission.apart is not None,
        proven=proven,
        pads=tuple(fleet_pads(mission)) if proven else (),
        cautions=tuple(said for said in cautions if not said.endswith(covered)),
        sheet=planned_sheet(mission),
    )


def finding_of(scenario: Scenario, violation: Violation) -> SceneFinding:
    """Return a violation as it is drawn."""
    uavs = [scenario.uavs[uav] for uav in violation.uavs if 0 <= uav < len(scenario.uavs)]
    return SceneFinding(
        severity="warning" if violation.fault is Fault.SEPARATION else "error",
        kind=violation.fault.value,
        uavs=tuple(uav.name for uav in uavs),
        message=violation.message,
        time=violation.time,
        position=violation.position,
    )


def _note(flight: PlannedFlight, flies: bool) -> str:
    if flight.target is None and flight.trajectory is not None:
        return ""
    if flight.target is None:
        return " has no target and stays at its start."
    if flight.result is None:
        return " has a target but was not planned."
    if not flight.result.status.reached:
        return f": {in_words(flight.result.status.sentence)}"
    return " has a path but no trajectory along it." if flies and flight.trajectory is None else ""


def scenario_scene(scenario: Scenario) -> Scene:
    """Return the scene of a scenario: its UAVs at their starts, and every target as one to which no UAV flies yet."""
    return Scene(
        scenario=scenario,
        tracks=tuple(
            track(PlannedFlight(uav=uav), number, scenario.bounds) for number, uav in enumerate(scenario.uavs)
        ),
        spare_targets=tuple((target.name, target.position) for target in scenario.targets),
        findings=tuple(
            SceneFinding(
                severity="error",
                kind="start" if point.field.startswith("uavs") else "target",
                uavs=(point.name,),
                message=f"{point.advice}.",
                time=None,
                position=point.position,
            )
            for point in unsafe_points(scenario)
        ),
    )


SAMPLE_STRIDE = 5
"""One sample of a flight in this many is drawn."""


def flight_scene(flight: Flight | ReplannedFlight) -> MissionScene:
    """Return the scene of `flight`; the path of a track is the planned trajectory, its positions are as flown.

    That of a flight that was replanned shows the truth, and as paths what was commanded.
    """
    if isinstance(flight, ReplannedFlight):
        flight = flight.flight
    planned = scene(flight.mission)
    tracks = tuple(_track(track, flown) for track, flown in zip(planned.tracks, flight.flown, strict=True))
    return replace(
        planned,
        tracks=tracks,
        curves=(),
        findings=tuple(replace(finding_of(planned.scenario, one), severity="error") for one in flight.violations),
        notes=(),
        complete=True,
    )


def _track(planned: DrawnTrack, flown: Flown | None) -> DrawnTrack:
    meant = planned.positions
    if flown is None:
        return replace(planned, path=meant)
    kept = np.unique(np.r_[0 : len(flown.times) : SAMPLE_STRIDE, len(flown.times) - 1])
    times = flown.times[kept]
    return replace(planned, path=meant, times=times, positions=flown.positions[kept], arrival=float(times[-1]))
