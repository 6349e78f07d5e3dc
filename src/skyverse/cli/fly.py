"""The verb ``fly``: a mission in a simulator."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from skyverse.cli.exit_codes import FOUND_WRONG, NO_VERDICT
from skyverse.cli.fly_replanned import FlightOptions, ReplanOptions, fly_replanned, refuse_mixed, report_replanned
from skyverse.cli.fly_runs import report_runs
from skyverse.cli.given_scenario import tell_not_proven
from skyverse.cli.option_types import FLAG, SIGNED, AsJson, GivenMission, GivenScenario, Output
from skyverse.cli.outputs import make_folder, refuse_output
from skyverse.cli.places import share_of, wind_of
from skyverse.cli.report import flight_violations, json_text, say, table, violation_data
from skyverse.cli.watch import count_bar
from skyverse.errors import InputError
from skyverse.model.short_lines import told_metres

if TYPE_CHECKING:
    from skyverse.model.conditions import Conditions
    from skyverse.model.flight_record import Flight, FlightRuns
    from skyverse.model.mission import Mission
    from skyverse.model.replanned_flight import ReplannedFlight

ANIMATIONS = (".html", ".mp4", ".gif")


@Parameter(name="*")
@dataclass(frozen=True)
class ConditionOptions:
    """What flies in which wind, and what else disturbs it.

    Parameters
    ----------
    vehicle
        The quadrotor that flies in place of every multirotor of the mission; when left out, the vehicle that the
        mission was planned for where that can be simulated (thesis, indoor, camera), and otherwise thesis.
    wind
        The wind's velocity towards east, north and up, m/s; that of the mission's scenario when no wind is given.
    wind_speed
        The wind's speed, m/s, with --wind-from.
    wind_from
        Where the wind blows from, degrees from north, clockwise, as pilots tell it: 270 is a west wind.
    gusts
        Let the wind be gusty, as strongly as its speed says (Dryden, MIL-F-8785C).
    mismatch
        The share, as in 20%, within which the vehicle's mass, thrust, drag and inertia differ from its controller's
        model.
    noise
        The noise of what the controllers measure: its standard deviation, m of position and m/s of velocity.
    position_noise
        The standard deviation of a slowly drifting error of measured positions, as of GPS, metres on each axis.
    delay
        Seconds by which measured positions and velocities are late.
    """

    vehicle: Literal["thesis", "camera", "crazyflie", "hummingbird"] | None = None
    wind: Annotated[str | None, SIGNED] = None
    wind_speed: float | None = None
    wind_from: float | None = None
    gusts: Annotated[bool, FLAG] = False
    mismatch: Annotated[str, SIGNED] = "0"
    noise: float = 0.0
    position_noise: float = 0.0
    delay: float = 0.0

    def made(self, mission: "Mission") -> "Conditions":
        """Return the conditions that the options describe, for a mission that is flown."""
        import skyverse as sky
        from skyverse.flight.fly import planned_wind

        blown, share = wind_of(self.wind, self.wind_speed, self.wind_from), share_of("--mismatch", self.mismatch)
        blown = planned_wind(mission) if blown is None else blown
        return sky.Conditions(self.vehicle, blown, self.noise, self.gusts, share, self.position_noise, self.delay)


@Parameter(name="*")
@dataclass(frozen=True)
class FileOptions:
    """What is written.

    Parameters
    ----------
    output
        Write the flight to this file, .json; with --until-safe it holds the mission as it was last flown. With --runs
        this is the mission alone.
    animation
        Draw an animation, .html, .mp4 or .gif; repeat for more.
    figures
        Write figures (PNG) of the first, the middle and the last instant into this folder.
    """

    output: Output = None
    animation: list[Path] | None = None
    figures: Path | None = None


_CONDITIONS, _FLIGHT, _FILES, _REPLANNED = ConditionOptions(), FlightOptions(), FileOptions(), ReplanOptions()


def fly(
    mission: GivenMission,
    /,
    *,
    scenario: GivenScenario | None = None,
    conditions: ConditionOptions = _CONDITIONS,
    flight: FlightOptions = _FLIGHT,
    files: FileOptions = _FILES,
    replanned: ReplanOptions = _REPLANNED,
    as_json: AsJson = False,
) -> int:
    """Fly a mission in a quadrotor simulator (rotorpy), and judge it as flown; or many times in gusts, or replanned.

    The mission as planned is judged first: where it is not proven, that is told, and it is flown all the same.

    Examples: `skyverse fly out/table-4.8.json`, `skyverse fly out/map1.json --wind 1,0,0 --animation out/map1.mp4`,
    `skyverse fly out/map2.json --wind 6,0,0 --until-safe -o out/map2.flight.json`,
    `skyverse fly out/map3.json --wind-speed 8 --wind-from 270 --gusts --mismatch 20% --runs 1000 --until-safe`,
    `skyverse fly out/map1.json --replan --movers 10 --sensor-range 4 --animation out/map1.html`

    Exit code: 0 when the flight is safe, 1 when not, 2 for bad input, 3 when another vehicle flew than the planned one,
    which says nothing of the mission.

    Parameters
    ----------
    mission
        A mission file.
    scenario
        The scenario that the mission has to answer, a file or a built-in name: a mission that embeds another one is
        refused.
    as_json
        Print what was found as JSON.
    """
    import skyverse as sky
    from skyverse.numerics.cores import cores

    refuse_mixed(replanned, flight)
    written = _refused_files(mission, flight, files)
    given = sky.read_mission(mission)
    told = conditions.made(given)
    tell_not_proven(mission, given, scenario)
    if replanned.replan:
        flown = fly_replanned(given, told, flight, replanned)
        _write(flown, files, written)
        report_replanned(flown, written, as_json)
        return _code(flown.flight)
    how: dict[str, Any] = {"rng": flight.seed, "workers": cores() if flight.jobs is None else flight.jobs}
    if flight.rounds is not None:
        how["rounds"] = flight.rounds
    verb: Any = sky.fly_until_safe if flight.until_safe else sky.fly
    if flight.runs is not None:
        with count_bar("flying", "runs") as on_progress:
            many = verb(given, told, runs=flight.runs, **how, on_progress=on_progress)
        if files.output is not None:
            sky.write(many.mission, files.output)
        report_runs(many, written, as_json)
        return _code(many)
    with count_bar("flying", "UAVs") as on_progress:
        once = verb(given, told, margin=flight.margin, **how, on_progress=on_progress)
    _write(once, files, written)
    _report(once, written, as_json)
    return _code(once)


def _refused_files(mission: str, flight: FlightOptions, files: FileOptions) -> list[Path]:
    """Refuse files that cannot be written, and options that do not go together; return the files to be written."""
    if files.output is not None and files.output.suffix.lower() != ".json":
        raise InputError(f"--output: {files.output}: a flight is written as .json")
    for path in files.animation or []:
        if path.suffix.lower() not in ANIMATIONS:
            raise InputError(f"--animation: expected a file ending in {', '.join(ANIMATIONS)}, found {str(path)!r}")
    written = [*([files.output] if files.output else []), *(files.animation or [])]
    for path in written:
        refuse_output(path, mission)
    if files.figures is not None:
        make_folder(files.figures)
    if flight.rounds is not None and not flight.until_safe:
        raise InputError("--rounds: expected --until-safe with it, found it alone")
    alone = (("--margin", flight.margin), ("--animation", files.animation), ("--figures", files.figures))
    for option, value in alone:
        if flight.runs is not None and value is not None:
            raise InputError(f"{option}: expected a single flight, found --runs with it")
    return written


def _code(flown: "Flight | FlightRuns") -> int:
    return NO_VERDICT if flown.stands_in else 0 if flown.safe else FOUND_WRONG


def _write(flight: "Flight | ReplannedFlight", files: FileOptions, written: list[Path]) -> None:
    """Write a flight, its animations and its figures, and add the names of the latter to what is written."""
    import skyverse as sky

    if files.output is not None:
        sky.write(flight, files.output)
    for path in files.animation or []:
        sky.write_animation(flight, path)
    if files.figures is not None:
        written += sky.write_instants(flight, files.figures)


def _report(flight: "Flight", written: list[Path], as_json: bool) -> None:
    """Print how each UAV flew, which came closest, the verdict, and where the files are."""
    names = [uav.name for uav in flight.mission.scenario.uavs]
    rows: list[dict[str, Any]] = [
        {
            "uav": names[flown.uav],
            "seconds": flown.times[-1] - flown.times[0],
            **{title: getattr(flown, name) for title, (name, _) in _MEASURES.items()},
            "clearance": flown.clearance if flown.clearance < float("inf") else None,
        }
        for flown in flight.flown
        if flown is not None
    ]
    pairs = [asdict(passing) | {"uavs": [names[i] for i in passing.uavs]} for passing in flight.passings]
    if as_json:
        summary = {
            "safe": None if flight.stands_in else flight.safe,
            "verdict": flight.sentence,
            "within_tracking_error": flight.held,
            "simulated": flight.vehicle_sentence,
            **{name: getattr(flight, name) for name in ("seed", "margin", "rounds", "refusal")},
            **vars(flight.conditions),
            "makespan": flight.mission.makespan,
            "uavs": rows,
            "pairs": pairs,
            "visits": [asdict(visit) for visit in flight.visits],
            "violations": [violation_data(violation) for violation in flight.violations],
            "files": [str(path) for path in written],
        }
        print(json_text(summary), end="")
        return
    print(flight.vehicle_sentence)
    forms: dict[str, Callable[[Any], str]] = {
        "uav": str,
        "seconds": "{:.1f}".format,
        **{title: form for title, (_, form) in _MEASURES.items()},
    }
    known = {title: form for title, form in forms.items() if any(row[title] is not None for row in rows)}
    cells = [["-" if row[title] is None else form(row[title]) for title, form in known.items()] for row in rows]
    table(list(known), cells)
    _tell_visits(flight)
    if pairs:
        closest = min(pairs, key=lambda pair: pair["nearness"])
        print(
            f"Closest: {' and '.join(closest['uavs'])}, {closest['distance']:.2f} m apart at {closest['time']:.2f} s, "
            f"{closest['nearness']:.2f} of their separation ({closest['planned']:.2f} as planned)"
        )
    say(flight.conditions.told(flight.seed), *flight.rounds, *flight_violations(flight))
    say(flight.tube_sentence, flight.sentence, *written)


def _tell_visits(flight: "Flight") -> None:
    """Print each visit of a tour as it was flown, and nothing without tours."""
    scenario = flight.mission.scenario
    rows = [
        [
            scenario.uavs[one.uav].name,
            scenario.targets[one.target].name,
            f"{one.arrival:.1f} s",
            f"{one.departure:.1f} s",
            f"{one.farthest:.3f} m",
            "yes" if one.kept else "no",
        ]
        for one in flight.visits
    ]
    if rows:
        table(["uav", "visits", "from", "until", "off at most", "kept"], rows)


_MEASURES: dict[str, tuple[str, Callable[[Any], str]]] = {
    "rms error": ("rms", "{:.3f} m".format),
    "largest error": ("largest", "{:.3f} m".format),
    "clearance": ("clearance", told_metres),
    "above ground": ("above_ground", told_metres),
    "mean thrust": ("mean_thrust", "{:.0%}".format),
    "peak thrust": ("peak_thrust", "{:.0%}".format),
    "peak tilt": ("peak_tilt", "{:.0f}°".format),
    "energy": ("energy", "{:.0f} J".format),
}
"""What is told of each UAV, by title: the field of `Flown`, and how its values are written."""
