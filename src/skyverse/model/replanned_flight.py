"""The record of a mission that was replanned while it was flown in a simulator: frozen data with read-only arrays."""

from dataclasses import dataclass, field
from functools import cached_property

from skyverse.model.arrays import ArrayRecord
from skyverse.model.conditions import Sensor
from skyverse.model.flight_record import Flight, Flown, Nearest
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt
from skyverse.model.mover_motions import WaypointMotion
from skyverse.model.quantities import Flag, Real, Whole
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import as_lines, counted
from skyverse.model.timed_shapes import not_judged_as_flown
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Verdict, Violation

REPLANNED_FLIGHT_1 = "skyverse/replanned-flight/1"


@dataclass(frozen=True, eq=False)
class Prediction(ArrayRecord):
    """Where the replanner holds a mover that was seen.

    Attributes
    ----------
    mover
        The index of the mover in the truth.
    motion, doubt
        How it goes on from its last sighting, and how far it may be from there.
    """

    mover: Whole
    motion: WaypointMotion
    doubt: Doubt


@dataclass(frozen=True, eq=False)
class ReplanAnswer(ArrayRecord):
    """What the replanner answered for one UAV to one observation.

    Attributes
    ----------
    uav
        Its index.
    kept, proven, clear_until, sentence
        As those of a `Replan`.
    motion
        What the UAV flies from then on, to rest; ``None`` where it goes on with the motion of an earlier answer.
    restarted
        Whether the UAV was so far off that its motion began anew from where it was.
    """

    uav: Whole
    kept: Flag
    proven: Flag
    clear_until: Real
    sentence: str
    motion: Trajectory | None = None
    restarted: Flag = False


@dataclass(frozen=True, eq=False)
class ReplanStep(ArrayRecord):
    """One observation that arrived, and what the replanner answered.

    Attributes
    ----------
    time, arrival
        The instants at which it was made, and at which it arrived; seconds into the mission.
    movers
        The indices, in the truth, of the movers that were within range.
    obstacles
        Those of the obstacles that were seen for the first time.
    predictions
        All movers that the replanner knows of then and did not know beforehand.
    answers
        One for each UAV, in the scenario's order.
    """

    time: Real
    arrival: Real
    movers: tuple[Whole, ...]
    obstacles: tuple[Whole, ...]
    predictions: tuple[Prediction, ...]
    answers: tuple[ReplanAnswer, ...]


@dataclass(frozen=True, eq=False)
class ReplannedFlight(ArrayRecord):
    """A mission that was replanned while it was flown in a simulator.

    Attributes
    ----------
    mission
        As it was planned, with what was known beforehand.
    sensor
        What UAVs saw with.
    flight
        What was flown, judged. Its mission has the truth as its scenario, and as trajectories the references: what the
        UAVs were commanded to fly, one motion after another.
    steps
        The observations, in the order in which they arrived.
    arrivals
        The instants at which the references end at the targets, seconds; ``None`` for a UAV that has not arrived.
    approaches
        Each UAV and mover when they were nearest to each other.
    lead, horizon
        Seconds from an observation after which the motion that answers it begins, and up to which it is proven.
    """

    mission: Mission
    sensor: Sensor
    flight: Flight
    steps: tuple[ReplanStep, ...]
    arrivals: tuple[Real | None, ...]
    approaches: tuple[Nearest, ...]
    lead: Real
    horizon: Real
    format: str = field(default=REPLANNED_FLIGHT_1)

    def __repr__(self) -> str:
        return as_lines(
            f"Replanned flight of mission {self.mission.scenario.name!r}: {self.sentence}",
            self.proof_sentence,
            self.replans_sentence,
            self.sensor.sentence,
        )

    @property
    def truth(self) -> Scenario:
        """The mission's scenario with all movers and obstacles that there were."""
        return self.flight.mission.scenario

    @property
    def references(self) -> tuple[Trajectory | None, ...]:
        """What each UAV was commanded to fly."""
        return self.flight.mission.trajectories

    @property
    def flown(self) -> tuple[Flown | None, ...]:
        """How each UAV flew; see `Flight`."""
        return self.flight.flown

    @property
    def passings(self) -> tuple[Nearest, ...]:
        """All pairs of UAVs that must keep a separation."""
        return self.flight.passings

    @property
    def violations(self) -> tuple[Violation, ...]:
        """What went wrong in the flight; empty if nothing did."""
        return self.flight.violations

    @property
    def safe(self) -> bool:
        """Whether nothing went wrong in the flight, with the vehicle that was planned."""
        return self.flight.safe

    @property
    def certificate(self) -> Certificate | None:
        """What the referee proved of the references; of several certificates the worst.

        ``None`` if it was not asked, as of a flight that was read from a file, which holds no certificates.
        """
        found = [one for one in (*self.flight.mission.certificates, self.flight.mission.apart) if one is not None]
        worst = (Verdict.REFUTED, Verdict.UNDECIDED, Verdict.PROVEN)
        return min(found, key=lambda one: worst.index(one.verdict), default=None)

    @cached_property
    def replanned(self) -> int:
        """How many answers replaced what was being flown."""
        return sum(not answer.kept for step in self.steps for answer in step.answers)

    @property
    def without_way_out(self) -> int:
        """How many answers had no way out that was proven."""
        return sum(not answer.proven for step in self.steps for answer in step.answers)

    @property
    def nearest(self) -> Nearest | None:
        """The least distance of a UAV from a mover; ``None`` where there are none."""
        return min(self.approaches, key=lambda one: one.distance, default=None)

    @property
    def sentence(self) -> str:
        """The verdict on what was flown, in one sentence, with the thresholds that it used."""
        if not self.safe:
            return self.flight.sentence
        left = f"{self.truth.clearance - self.flight.margin:.3g} m"
        kept = [name for name, there in (("mover", self.truth.movers), ("obstacle", self.truth.obstacles)) if there]
        clear = f" and kept the required {left} from every {' and '.join(kept)} as it truly was" if kept else ""
        apart = ", and no two entered their separation by more than the margin" if len(self.truth.uavs) > 1 else ""
        return (
            f"Safe as flown: every UAV arrived{clear}{apart}.{self._nearest_sentence}{not_judged_as_flown(self.truth)}"
        )

    @property
    def _nearest_sentence(self) -> str:
        nearest = self.nearest
        if nearest is None:
            return ""
        assert nearest.mover is not None
        who = f"{self.truth.uavs[nearest.uavs[0]].name} was {nearest.distance:.3f} m from mover"
        return f" At the nearest, {who} {self.truth.movers[nearest.mover].name!r}, at t = {nearest.time:.2f} s."

    @property
    def proof_sentence(self) -> str:
        """What the referee proved of the references, and how far the UAVs strayed from them."""
        found = self.certificate
        if found is None:
            return "Not judged: what was commanded is proven or refuted when it is flown; no file holds that."
        strayed = f"UAVs stayed within {self.flight.largest:.3f} m of it as flown"
        errors = [uav.tracking_error for uav in self.truth.uavs]
        allowed = min(min(error.horizontal, error.vertical) for error in errors)
        if found.verdict is not Verdict.PROVEN:
            restarts = sum(answer.restarted for step in self.steps for answer in step.answers)
            anew = f" Motions began anew from where UAVs were {restarts} times." if restarts else ""
            return f"What was commanded is {found.verdict.value}: {found.sentence}{anew} {strayed}."
        among = "clear of all movers and obstacles as they truly were"
        if allowed == 0.0:
            return (
                f"What was commanded is proven {among}, at every instant; as the mission allows for no tracking error, "
                f"that is said of the command alone; {strayed}."
            )
        return f"What was commanded is proven {among}, with a tracking error of {allowed:g} m; {strayed}."

    @property
    def replans_sentence(self) -> str:
        """How often there were observations, and how they were answered."""
        answers = sum(len(step.answers) for step in self.steps)
        lost = self.without_way_out
        ways = "each with a proven way out" if not lost else f"{lost} of them without a proven way out"
        return (
            f"{counted(len(self.steps), 'observation')}, {counted(answers, 'answer')}, {ways}; "
            f"{self.replanned} replaced what was being flown."
        )
