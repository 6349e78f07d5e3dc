"""What is said of an answer: violations, certificates, conflicts between UAVs, and how they were resolved."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal

from skyverse.model.frame import Frame
from skyverse.model.geodesy import told_on_globe
from skyverse.model.quantities import Flag, Real, Whole


class Fault(Enum):
    """The kinds of things that the referee can find wrong."""

    SCENARIO = "scenario"
    ASSIGNMENT = "assignment"
    STATUS = "status"
    PATH_SHAPE = "path shape"
    PATH_BOUNDS = "path out of bounds"
    PATH_CLEARANCE = "path too close"
    PATH_ENDS = "path ends"
    PATH_STEP = "path off the lattice"
    TRAJECTORY_SHAPE = "trajectory shape"
    TRAJECTORY_BOUNDS = "trajectory out of bounds"
    TRAJECTORY_CLEARANCE = "trajectory too close"
    MOVER = "mover too close"
    ACTIVE_ZONE = "active zone too close"
    TRAJECTORY_ENDS = "trajectory ends"
    CONTINUITY = "trajectory jumps"
    SPEED = "too fast"
    ZONE_SPEED = "too fast in a zone"
    ACCELERATION = "accelerates too hard"
    JERK = "jerks too hard"
    THRUST = "too much thrust"
    TILT = "tilts too far"
    TURN = "turns too tightly"
    CLIMB = "climbs too steeply"
    CLIMB_RATE = "climbs too fast"
    DESCENT_RATE = "descends too fast"
    YAW = "yaws too fast"
    AIRSPEED = "off its airspeed"
    BATTERY = "battery"
    WIND = "too much wind"
    VISIT = "visit"
    STRIP = "strip"
    SEPARATION = "UAVs too close"
    GIVEN = "given too close"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Violation:
    """One thing that the referee found wrong.

    Attributes
    ----------
    fault
        The kind of violation.
    uavs
        The indices of the UAVs concerned: one, two for a separation, none for the mission as a whole.
    message
        One sentence with the numbers.
    time
        Seconds into the mission, or ``None`` where the violation belongs to no instant.
    position
        x, y, z in metres, or ``None`` where the violation belongs to no place.
    """

    fault: Fault
    uavs: tuple[Whole, ...]
    message: str
    time: Real | None = None
    position: tuple[Real, Real, Real] | None = None


def with_global_places(frame: Frame, violations: Iterable[Violation]) -> list[Violation]:
    """Return violations whose sentences tell latitude and longitude, too, where a frame has an origin."""

    def told(one: Violation) -> Violation:
        place = one.position and told_on_globe(frame.origin, one.position)
        said = one.message.removesuffix(".")
        return replace(one, message=one.message.replace(said, f"{said} (at {place})")) if place else one

    return [told(one) for one in violations]


class Verdict(Enum):
    """The referee's verdict on a trajectory, or on the fleet."""

    PROVEN = "proven"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Certificate:
    """What the referee can prove at every instant, not only at samples.

    Attributes
    ----------
    verdict
        Proven, refuted, or undecided after `subdivisions`.
    sentence
        One sentence: what is proven; or what is wrong, when and where; or what could not be decided.
    time, position
        The refuted or undecided instant, seconds into the mission, and where the UAV is then, metres.
    subdivisions
        How often pieces of the trajectory were cut in two.
    scenario
        The digest of the scenario that it was judged by; see `Scenario.digest`. Empty in files of older versions.
    """

    verdict: Verdict
    sentence: str
    time: Real | None = None
    position: tuple[Real, Real, Real] | None = None
    subdivisions: Whole = 0
    scenario: str = ""

    def __repr__(self) -> str:
        return f"Certificate: {self.verdict.value}\n  {self.sentence}"


@dataclass(frozen=True)
class Conflict:
    """Two UAVs that come closer than their separation.

    Attributes
    ----------
    uavs
        Their indices.
    begin, end
        Seconds into the mission between which they are too close.
    time
        When they are nearest to each other, seconds into the mission.
    nearness
        How near they are then, as a share of the separation: 1 on the ellipsoid, 0 where both are at one place.
    position
        The point midway between them then, metres.
    given
        Whether their starts or their targets are given too close, so that nothing can resolve the conflict.
    """

    uavs: tuple[Whole, Whole]
    begin: Real
    end: Real
    time: Real
    nearness: Real
    position: tuple[Real, Real, Real]
    given: Flag = False


ActionKind = Literal["delay", "slow down", "exchange", "detour", "wait"]


@dataclass(frozen=True)
class Action:
    """One change to one UAV's flight that resolves conflicts.

    Attributes
    ----------
    uav
        Its index.
    kind
        ``"delay"``, ``"slow down"``, ``"exchange"`` (of targets), ``"detour"`` or ``"wait"`` (on the way).
    sentence
        One sentence with the numbers.
    """

    uav: Whole
    kind: ActionKind
    sentence: str


@dataclass(frozen=True)
class Deconfliction:
    """How the conflicts of a fleet were resolved.

    Attributes
    ----------
    found, left
        The conflicts before, and those that could not be resolved or that were given.
    actions
        What was changed, in order.
    total_before, total_after
        The sum of the UAVs' arrival times before and after, seconds.
    makespan_before, makespan_after
        The time of the last arrival before and after, seconds.
    """

    found: tuple[Conflict, ...]
    left: tuple[Conflict, ...]
    actions: tuple[Action, ...]
    total_before: Real
    total_after: Real
    makespan_before: Real
    makespan_after: Real
