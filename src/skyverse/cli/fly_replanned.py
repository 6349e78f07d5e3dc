"""What the verb ``fly`` does with a mission that is replanned in flight: the truth, the sensor, and what is printed."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyverse.cli.report import json_text, print_flight_violations, table, violation_data
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.replanned_flight import ReplannedFlight
    from skyverse.model.scenario import Scenario
    from skyverse.model.sensor import Sensor

OPTIONS = (
    "truth",
    "movers",
    "mover_kind",
    "mover_speed",
    "sensor_range",
    "sensor_rate",
    "sensor_delay",
    "sensor_error",
    "lead",
    "horizon",
    "longest",
)
"""The parameters of the verb that are of use with ``--replan`` only."""
ELSEWHERE = ("runs", "until_safe", "rounds", "jobs")
"""Those that are of no use with it."""


def refuse_mixed(replan: bool, given: dict[str, Any]) -> None:
    """Refuse options that do not go together, by the values of all of the verb's parameters."""

    def first(names: tuple[str, ...]) -> str | None:
        found = next((name for name in names if given[name] not in (None, False)), None)
        return None if found is None else f"--{found.replace('_', '-')}"

    if replan:
        option = first(ELSEWHERE)
        if option is not None:
            raise InputError(f"{option}: expected a flight that is not replanned, found --replan with it")
    else:
        option = first(OPTIONS)
        if option is not None:
            raise InputError(f"{option}: expected --replan with it, found it alone")
    option = first(("mover_kind", "mover_speed"))
    if option is not None and given["movers"] is None:
        raise InputError(f"{option}: expected --movers with it, found it alone")


def truth_of(mission: "Mission", given: dict[str, Any]) -> "Scenario":
    """Return the scenario with what the mission does not know of: that of ``--truth``, and random movers."""
    import skyverse as sky

    truth = mission.scenario if given["truth"] is None else sky.read_scenario(given["truth"])
    if given["movers"] is None:
        return truth
    speed = 0.5 if given["mover_speed"] is None else given["mover_speed"]
    kind: Any = given["mover_kind"] or "spinners"
    seed = given["seed"] or 0
    made = sky.random_movers(mission.scenario, given["movers"], kind=kind, speed=speed, seed=seed)
    new = made.movers[len(mission.scenario.movers) :]
    return truth.model_copy(update={"movers": (*truth.movers, *new)})


def sensor_of(given: dict[str, Any]) -> "Sensor":
    """Return the sensor that the options describe."""
    import skyverse as sky

    fields = {name: given[f"sensor_{name}"] for name in ("range", "rate", "delay", "error")}
    try:
        return sky.Sensor(**{name: value for name, value in fields.items() if value is not None})
    except InputError as error:
        raise InputError(f"--sensor-{error.sentence.field}: {error.sentence.text}") from None


def report_replanned(flight: "ReplannedFlight", written: list[Path], as_json: bool) -> None:
    """Print how often each UAV was replanned, what is proven, how near it came to movers, and the verdict."""
    from skyverse.model.disturbances import told_weather
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
            **{name: getattr(flown, name) for name in ("vehicle", "wind", "noise", "seed", "margin")},
            **vars(flown.disturbances),
            "sensor": dict(flight.sensor),
            "observations": len(flight.steps),
            "uavs": rows,
            "approaches": [vars(one) for one in flight.approaches],
            "violations": [violation_data(violation) for violation in flight.violations],
            "files": [str(path) for path in written],
        }
        print(json_text(summary), end="")
        return
    print(flight.flight.vehicle_sentence)
    print(flight.sensor.sentence)
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
    print(told_weather(flown.wind, flown.noise, flown.disturbances, flown.seed))
    print(flight.replans_sentence)
    print(flight.proof_sentence)
    print_flight_violations(flown)
    print(flight.sentence)
    for path in written:
        print(path)


def _row(flight: "ReplannedFlight", uav: int) -> dict[str, Any]:
    """Return what is told of a UAV."""
    answers = [step.answers[uav] for step in flight.steps]
    flown = flight.flown[uav]
    assert flown is not None
    near = [one.distance for one in flight.approaches if one.uav == uav]
    return {
        "uav": flight.truth.uavs[uav].name,
        "arrival": flight.arrivals[uav],
        "replanned": sum(not answer.kept for answer in answers),
        "without way out": sum(not answer.proven for answer in answers),
        "largest error": flown.largest,
        "to obstacles": flown.clearance if flown.clearance < float("inf") else None,
        "to movers": min(near, default=None),
    }
