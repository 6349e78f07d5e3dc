"""The verb ``fly``: a mission in a simulator."""

import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from skyverse.cli.exit_codes import FOUND_WRONG, NO_VERDICT
from skyverse.cli.fly_replanned import refuse_mixed, report_replanned, sensor_of, truth_of
from skyverse.cli.fly_runs import report_runs
from skyverse.cli.judgement import tell_not_proven
from skyverse.cli.option_types import FLAG, SIGNED, WHOLE, AsJson, GivenMission, GivenScenario, Output, Whole
from skyverse.cli.outputs import make_folder, refuse_output
from skyverse.cli.places import share_of, wind_of
from skyverse.cli.report import json_text, print_flight_violations, table, violation_data
from skyverse.cli.watch import count_bar
from skyverse.errors import InputError
from skyverse.model.short_lines import told_metres

if TYPE_CHECKING:
    from skyverse.model.flight_record import Flight
    from skyverse.model.flight_runs import FlightRuns
    from skyverse.model.replanned_flight import ReplannedFlight

ANIMATIONS = (".html", ".mp4", ".gif")


def fly(
    mission: GivenMission,
    /,
    *,
    scenario: GivenScenario | None = None,
    vehicle: Literal["thesis", "camera", "crazyflie", "hummingbird"] | None = None,
    wind: Annotated[str, SIGNED] = "0,0,0",
    wind_speed: float | None = None,
    wind_from: float | None = None,
    gusts: Annotated[bool, FLAG] = False,
    mismatch: Annotated[str, SIGNED] = "0",
    noise: float = 0.0,
    position_noise: float = 0.0,
    delay: float = 0.0,
    runs: Whole = None,
    margin: float | None = None,
    seed: Whole = None,
    until_safe: Annotated[bool, FLAG] = False,
    rounds: Whole = None,
    output: Output = None,
    animation: list[Path] | None = None,
    figures: Path | None = None,
    replan: Annotated[bool, FLAG] = False,
    truth: GivenScenario | None = None,
    movers: Whole = None,
    mover_kind: Literal["spinners", "patrols", "knots", "traffic"] | None = None,
    mover_speed: float | None = None,
    sensor_range: float | None = None,
    sensor_rate: float | None = None,
    sensor_delay: float | None = None,
    sensor_error: float | None = None,
    lead: float | None = None,
    horizon: float | None = None,
    longest: float | None = None,
    jobs: Annotated[int | None, Parameter(name=["--jobs", "-j"]), WHOLE] = None,
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
    vehicle
        The quadrotor that flies in place of every multirotor of the mission; when left out, the vehicle that the
        mission was planned for where that can be simulated (thesis, indoor, camera), and otherwise thesis.
    wind
        The wind's velocity towards east, north and up, m/s; or its speed and the direction that it blows to, degrees
        from east towards north.
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
    output
        Write the flight to this file, .json; with --until-safe it holds the mission as it was last flown. With --runs
        this is the mission alone.
    animation
        Draw an animation, .html, .mp4 or .gif; repeat for more.
    figures
        Write figures (PNG) of the first, the middle and the last instant into this folder.
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
    jobs
        How many processes share the work; as many as there are cores when left out.
    as_json
        Print what was found as JSON.
    """
    asked = dict(locals())
    import skyverse as sky
    from skyverse.numerics.cores import cores

    refuse_mixed(replan, asked)
    if output is not None and output.suffix.lower() != ".json":
        raise InputError(f"--output: {output}: a flight is written as .json")
    for path in animation or []:
        if path.suffix.lower() not in ANIMATIONS:
            raise InputError(f"--animation: expected a file ending in {', '.join(ANIMATIONS)}, found {str(path)!r}")
    written = [*([output] if output else []), *(animation or [])]
    for path in written:
        refuse_output(path, mission)
    if figures is not None:
        make_folder(figures)
    if rounds is not None and not until_safe:
        raise InputError("--rounds: expected --until-safe with it, found it alone")
    for option, value in (("--margin", margin), ("--animation", animation), ("--figures", figures)):
        if runs is not None and value is not None:
            raise InputError(f"{option}: expected a single flight, found --runs with it")
    blown, share = wind_of(wind, wind_speed, wind_from), share_of("--mismatch", mismatch)
    if len(blown) == 2:
        meant = f"{blown[0]:g} m/s towards {blown[1]:g} degrees, counted from east towards north"
        print(f"--wind {wind} is {meant}; a vector has three numbers, as in {wind},0.", file=sys.stderr)
    given = sky.read_mission(mission)
    tell_not_proven(mission, given, scenario)
    options: dict[str, Any] = {
        "vehicle": vehicle,
        "wind": blown,
        "noise": noise,
        "disturbances": sky.Disturbances(gusts, share, position_noise, delay),
        "rng": seed,
    }
    if replan:
        settings: dict[str, Any] = {
            name: value for name, value in (("lead", lead), ("horizon", horizon)) if value is not None
        }
        replanner, there, sensor = sky.Replanner(given, **settings), truth_of(given, asked), sensor_of(asked)
        options |= {"margin": margin, "longest": longest}
        with count_bar("flying", "seconds at most") as on_progress:
            replanned = sky.fly_replanned(replanner, there, sensor, **options, on_progress=on_progress)
        _write(replanned, output, animation, figures, written)
        report_replanned(replanned, written, as_json)
        return _code(replanned.flight)
    options["workers"] = cores() if jobs is None else jobs
    if rounds is not None:
        options["rounds"] = rounds
    if runs is not None:
        with count_bar("flying", "runs") as on_progress:
            many = sky.fly_many_until_safe if until_safe else sky.fly_many
            flown = many(given, runs=runs, **options, on_progress=on_progress)
        if output is not None:
            sky.write(flown.mission, output)
        report_runs(flown, [output] if output else [], as_json)
        return _code(flown)
    options["margin"] = margin
    with count_bar("flying", "UAVs") as on_progress:
        flight = (sky.fly_until_safe if until_safe else sky.fly)(given, **options, on_progress=on_progress)
    _write(flight, output, animation, figures, written)
    _report(flight, written, as_json)
    return _code(flight)


def _code(flown: "Flight | FlightRuns") -> int:
    return NO_VERDICT if flown.stands_in else 0 if flown.safe else FOUND_WRONG


def _write(
    flight: "Flight | ReplannedFlight",
    output: Path | None,
    animation: list[Path] | None,
    figures: Path | None,
    written: list[Path],
) -> None:
    """Write a flight, its animations and its figures, and add the names of the latter to what is written."""
    import skyverse as sky

    if output is not None:
        sky.write(flight, output)
    for path in animation or []:
        sky.write_animation(flight, path)
    if figures is not None:
        written += sky.write_instants(flight, figures)


def _report(flight: "Flight", written: list[Path], as_json: bool) -> None:
    """Print how each UAV flew, which came closest, the verdict, and where the files are."""
    from skyverse.model.disturbances import told_weather

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
            **{name: getattr(flight, name) for name in ("vehicle", "wind", "noise", "seed", "margin", "rounds")},
            **vars(flight.disturbances),
            "makespan": flight.mission.makespan,
            "uavs": rows,
            "pairs": pairs,
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
    if pairs:
        closest = min(pairs, key=lambda pair: pair["nearness"])
        print(
            f"Closest: {' and '.join(closest['uavs'])}, {closest['distance']:.2f} m apart at {closest['time']:.2f} s, "
            f"{closest['nearness']:.2f} of their separation ({closest['planned']:.2f} as planned)"
        )
    print(told_weather(flight.wind, flight.noise, flight.disturbances, flight.seed))
    for sentence in flight.rounds:
        print(sentence)
    print_flight_violations(flight)
    print(flight.tube_sentence)
    print(flight.sentence)
    for path in written:
        print(path)


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
