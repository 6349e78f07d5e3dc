"""What the verb ``fly`` does with a mission that is replanned in flight: the truth, the sensor, and what is printed."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from skyverse.cli.option_types import FLAG, WHOLE, GivenScenario, Whole
from skyverse.cli.report import flight_violations, json_text, say, table, violation_data
from skyverse.cli.watch import count_bar
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.conditions import Conditions, Sensor
    from skyverse.model.mission import Mission
    from skyverse.model.replanned_flight import ReplannedFlight
    from skyverse.model.scenario import Scenario


@Parameter(name="*")
@dataclass(frozen=True)
class FlightOptions:
    """How often it is flown, what is safe, and what is random.

    Parameters
    ----------
    runs
        Fly the mission this many times in the compiled simulator, each time with other gusts, vehicles and noise.
    margin
        How far a UAV may stray from its trajectory, metres; half the clearance when left out.
    seed
        The seed of all that is random; when left out, it is drawn and told if anything is.
    until_safe
        Where the flight is not safe, slow the mission down or plan it anew, and fly again. With --runs, until no run
        touches anything, or the mission is refused as too tight.
    rounds
        With --until-safe: how many flights there are at most; 5 when left out, or 8 with --runs.
    jobs
        How many processes share the work; as many as there are cores when left out.
    """

    runs: Whole = None
    margin: float | None = None
    seed: Whole = None
    until_safe: Annotated[bool, FLAG] = False
    rounds: Whole = None
    jobs: Annotated[int | None, Parameter(name=["--jobs", "-j"]), WHOLE] = None


@Parameter(name="*")
@dataclass(frozen=True)
class ReplanOptions:
    """What is there in flight, what is seen of it, and how the mission is replanned.

    Parameters
    ----------
    replan
        Replan the mission in flight, among what the sensors of its UAVs see.
    truth
        With --replan: a scenario, a file or a built-in name, whose movers and obstacles are there though the mission
        does not know of them.
    movers
        With --replan: this many random movers are there that the mission does not know of.
    mover_kind
        With --movers: whether they go round circles (spinners, when left out), back and forth (patrols), round trefoil
        knots, or from side to side (traffic).
    mover_speed
        With --movers: their mean speed, m/s; 0.5 when left out.
    sensor_range
        With --replan: how many metres from a UAV movers and obstacles are seen; all of them are when left out.
    sensor_rate
        With --replan: observations a second, up to 100; 10 when left out.
    sensor_delay
        With --replan: seconds after which an observation arrives, less than --lead; 0 when left out.
    sensor_error
        With --replan: how many metres the position of a mover is off at most; 0 when left out.
    lead
        With --replan: seconds from an observation to the beginning of the motion that answers it; 0.1 when left out.
    horizon
        With --replan: seconds from an observation up to which motions are proven; when left out, half a second more
        than a UAV takes to come to rest.
    longest
        With --replan: seconds into the mission after which the flight is given up; when left out, a minute more than
        the mission takes twice.
    """

    replan: Annotated[bool, FLAG] = False
    truth: GivenScenario | None = None
    movers: Whole = None
    mover_kind: Literal["spinners", "patrols", "knots", "traffic"] | None = None
    mover_speed: float | None = None
    sensor_range: float | None = None
    sensor_rate: float | None = None
    sensor_delay: float | None = None
    sensor_error: float | None = None
    lead: float | None = None
    horizon: float | None = None
    longest: float | None = None


ELSEWHERE = ("runs", "until_safe", "rounds", "jobs")
"""The options that are of no use with ``--replan``."""


def refuse_mixed(replanned: ReplanOptions, flight: FlightOptions) -> None:
    """Refuse options that do not go together."""

    def first(options: Any, names: Iterable[str]) -> str | None:
        found = next((name for name in names if getattr(options, name) not in (None, False)), None)
        return None if found is None else f"--{found.replace('_', '-')}"

    if replanned.replan and (option := first(flight, ELSEWHERE)):
        raise InputError(f"{option}: expected a flight that is not replanned, found --replan with it")
    if not replanned.replan and (option := first(replanned, vars(replanned))):
        raise InputError(f"{option}: expected --replan with it, found it alone")
    if replanned.movers is None and (option := first(replanned, ("mover_kind", "mover_speed"))):
        raise InputError(f"{option}: expected --movers with it, found it alone")


def fly_replanned(
    mission: "Mission", conditions: "Conditions", flight: FlightOptions, given: ReplanOptions
) -> "ReplannedFlight":
    """Fly a mission that is replanned in flight, among what the options say is there."""
    import skyverse as sky

    settings = {name: value for name in ("lead", "horizon") if (value := getattr(given, name)) is not None}
    replanner, truth, sensor = sky.Replanner(mission, **settings), _truth(mission, flight.seed, given), _sensor(given)
    how: dict[str, Any] = {"margin": flight.margin, "rng": flight.seed, "longest": given.longest}
    with count_bar("flying", "seconds at most") as on_progress:
        return sky.fly_replanned(replanner, truth, sensor, conditions, **how, on_progress=on_progress)


def _truth(mission: "Mission", seed: int | None, given: ReplanOptions) -> "Scenario":
    """Return the scenario with what the mission does not know of: that of ``--truth``, and random movers."""
    import skyverse as sky

    truth = mission.scenario if given.truth is None else sky.read_scenario(given.truth)
    if given.movers is None:
        return truth
    speed = 0.5 if given.mover_speed is None else given.mover_speed
    kind = given.mover_kind or "spinners"
    made = sky.random_movers(mission.scenario, given.movers, kind=kind, speed=speed, seed=seed or 0)
    new = made.movers[len(mission.scenario.movers) :]
    return truth.model_copy(update={"movers": (*truth.movers, *new)})


def _sensor(given: ReplanOptions) -> "Sensor":
    """Return the sensor that the options describe."""
    import skyverse as sky

    fields = {name: getattr(given, f"sensor_{name}") for name in ("range", "rate", "delay", "error")}
    try:
        return sky.Sensor(**{name: value for name, value in fields.items() if value is not None})
    except InputError as error:
        raise InputError(f"--sensor-{error.sentence.field}: {error.sentence.text}") from None


def report_replanned(flight: "ReplannedFlight", written: list[Path], as_json: bool) -> None:
    """Print how often each UAV was replanned, what is proven, how near it came to movers, and the verdict."""
    from skyverse.model.short_lines import told_metres

    rows = [_row(flight, uav) for uav in range(len(flight.truth.uavs))]
    if as_json:
        flown = flight.flight
        summary = {
            "safe": None if flown.stands_in else flight.safe,
            "verdict": flight.sentence,
            "proven": flight.certificate is not None and flight.certificate.verdict.value == "proven",
            "commanded": flight.proof_sentence,
            "simulated": flown.vehicle_sentence,
            **{name: getattr(flown, name) for name in ("seed", "margin")},
            **vars(flown.conditions),
            "sensor": dict(flight.sensor),
            "observations": len(flight.steps),
            "uavs": rows,
            "approaches": [vars(one) for one in flight.approaches],
            "violations": [violation_data(violation) for violation in flight.violations],
            "files": [str(path) for path in written],
        }
        print(json_text(summary), end="")
        return
    say(flight.flight.vehicle_sentence, flight.sensor.sentence)
    forms: dict[str, Callable[[Any], str]] = {
        "arrival": "{:.2f} s".format,
        "replanned": str,
        "without way out": str,
        "largest error": "{:.3f} m".format,
        "to obstacles": told_metres,
        "to movers": told_metres,
    }
    known = {title: form for title, form in forms.items() if any(row[title] is not None for row in rows)}
    cells = [[row["uav"], *("-" if row[t] is None else form(row[t]) for t, form in known.items())] for row in rows]
    table(["uav", *known], cells)
    flown = flight.flight
    say(flown.conditions.told(flown.seed), flight.replans_sentence, flight.proof_sentence)
    say(*flight_violations(flown), flight.sentence, *written)


def _row(flight: "ReplannedFlight", uav: int) -> dict[str, Any]:
    """Return what is told of a UAV."""
    answers = [step.answers[uav] for step in flight.steps]
    flown = flight.flown[uav]
    assert flown is not None
    near = [one.distance for one in flight.approaches if one.uavs == (uav,)]
    return {
        "uav": flight.truth.uavs[uav].name,
        "arrival": flight.arrivals[uav],
        "replanned": sum(not answer.kept for answer in answers),
        "without way out": sum(not answer.proven for answer in answers),
        "largest error": flown.largest,
        "to obstacles": flown.clearance if flown.clearance < float("inf") else None,
        "to movers": min(near, default=None),
    }
