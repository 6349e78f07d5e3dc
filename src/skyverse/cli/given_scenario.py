"""Scenarios that a verb is given, or judges by, with other UAVs, targets and limits; what is refused or told first."""

import math
import sys
from typing import TYPE_CHECKING

from skyverse.cli.places import ends_of, height_above_ground, numbers_of
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario
    from skyverse.model.vehicle_profiles import FleetLimits
    from skyverse.planners.base import Planner


MAX_NAMED_POINTS = 50
"""Starts and targets at most that one message names."""


def with_ends(source: str, scenario: "Scenario", uavs: list[str] | None, targets: list[str] | None) -> "Scenario":
    """Return a scenario with other UAVs and targets where some are given, and refuse one that is left without any.

    A UAV has the limits of the one that it replaces, or of the last one.
    """
    from skyverse.files.scenarios import scenario_from_data

    data = {name: getattr(scenario, name) for name in type(scenario).model_fields}
    for kind, field, words in (("uav", "start", uavs), ("target", "position", targets)):
        old = data[f"{kind}s"]
        if words:
            data[f"{kind}s"] = things = []
            for number, (name, point) in enumerate(ends_of(f"--{kind}", words, scenario)):
                like = old[min(number, len(old) - 1)] if old else None
                own = {} if like is None else {one: getattr(like, one) for one in type(like).model_fields}
                kept = like.name if like is not None and number < len(old) else f"{kind}-{number + 1}"
                things.append(own | {"name": name or kept, field: point} | ({"home": None} if "home" in own else {}))
        if not data[f"{kind}s"]:
            raise InputError(f"{source}: {kind}s: there are none; give some with --{kind} x,y,z")
    return scenario_from_data(source, data)


def with_lattice(scenario: "Scenario", step: str | None) -> "Scenario":
    """Return a scenario with the lattice's step that is given, or else one that fits below its ceiling above ground."""
    from skyverse.files.scenarios import scenario_from_data
    from skyverse.model.scenario import with_fitting_lattice

    if step is None:
        return with_fitting_lattice(scenario)
    expected = "metres, as in 20, or along x, y and z, as in 50,50,10"
    numbers = numbers_of("--lattice-step", expected, step)
    if len(numbers) not in (1, 3) or not all(0 < number < math.inf for number in numbers):
        raise InputError(f"--lattice-step: expected {expected}, found {step!r}")
    data = {name: getattr(scenario, name) for name in type(scenario).model_fields}
    steps = numbers * 3 if len(numbers) == 1 else numbers
    data["lattice"] = {"step": steps, "connectivity": scenario.lattice.connectivity}
    return scenario_from_data("--lattice-step", data)


def with_ceiling(source: str, scenario: "Scenario", max_height: str | None) -> "Scenario":
    """Return a scenario with a ceiling above its ground, written as in ``120 m agl``, if there is one."""
    if max_height is None:
        return scenario
    most = height_above_ground("--max-height", max_height).metres
    if scenario.terrain is None:
        raise InputError(f"--max-height: is counted from the ground, but {source} has no terrain")
    if most <= scenario.ground_clearance:
        least = f"{scenario.ground_clearance:g} m"
        raise InputError(f"--max-height: expected more than the clearance from the ground, {least}, found {most:g} m")
    return scenario.model_copy(update={"max_height": most})


def with_wind(scenario: "Scenario", velocity: tuple[float, float, float] | None, gust: float | None) -> "Scenario":
    """Return a scenario in another wind, in which each UAV can fly, and with other gusts, m/s, as far as given."""
    from skyverse.model.wind import Wind, refuse_wind

    if velocity is not None:
        blows = Wind(velocity=velocity, gust=gust or 0.0)
        scenario = scenario.model_copy(update={"wind": blows if any(velocity) or gust else None})
    elif gust is not None:
        blows = scenario.wind or Wind(velocity=(0.0, 0.0, 0.0))
        scenario = scenario.model_copy(update={"wind": blows.model_copy(update={"gust": gust})})
    for uav in scenario.uavs:
        refuse_wind(uav, scenario.winds)
    return scenario


def with_work(scenario: "Scenario", end: str | None, stay: float | None) -> "Scenario":
    """Return a scenario whose UAVs all end at their last target or at home, and stay so long at each, s, if given."""
    ends = {} if end is None else {"end": end}
    stays = {} if stay is None else {"stay": stay}
    return scenario.model_copy(
        update={
            "uavs": tuple(uav.model_copy(update=ends) for uav in scenario.uavs),
            "targets": tuple(target.model_copy(update=stays) for target in scenario.targets),
        }
    )


def limited(scenario: "Scenario", limits: "FleetLimits") -> "Scenario":
    """Return a scenario all of whose UAVs have these limits."""
    from skyverse.model.uav import with_limits

    if limits.battery is not None and limits.vehicle is None:
        unknown = [uav.name for uav in scenario.uavs if uav.mass is None or uav.power_model is None]
        if unknown:
            why = (
                f"the mass or power of {unknown[0]} is not known; --vehicle camera gives them, or mass and hover_power"
            )
            raise InputError(f"--battery: {why} in the scenario")
    return scenario.model_copy(update={"uavs": tuple(with_limits(uav, limits) for uav in scenario.uavs)})


def from_the_ground(scenario: "Scenario") -> "Scenario":
    """Return a scenario whose UAVs that stand on the ground start above it, and say on standard error how high."""
    from skyverse.space.ground_starts import risen, standing

    uavs = standing(scenario)
    return risen(scenario, uavs, lambda said: print(f"{said}.", file=sys.stderr)) if uavs else scenario


def refuse_unsafe(source: str, scenario: "Scenario") -> None:
    """Refuse a scenario before anything is planned, and name every start and target of it that is not safe."""
    from skyverse.space.unsafe_points import unsafe_points

    found = unsafe_points(scenario)
    if len(found) == 1:
        raise InputError(f"{source}: {found[0].sentence}")
    if found:
        more = [f"... and {len(found) - MAX_NAMED_POINTS} more"] if len(found) > MAX_NAMED_POINTS else []
        lines = [*(point.sentence for point in found[:MAX_NAMED_POINTS]), *more]
        raise InputError("\n  ".join([f"{source}: {len(found)} starts and targets are not safe:", *lines]))


def tell_unsought(scenario: "Scenario", planner: "Planner") -> None:
    """Say on standard error which terms of the objective a planner does not minimise."""
    from skyverse.cost import soft_terms
    from skyverse.planners.taut import Taut
    from skyverse.planners.theta_star import ThetaStar

    terms = soft_terms(scenario)
    if terms and isinstance(planner, Taut | ThetaStar):
        said = f"{type(planner).__name__} seeks length alone; priced, but not sought: {', '.join(terms)}"
        print(f"{said} (cheapest, astar and hybrid-mvo seek them).", file=sys.stderr)


def tell_unspent(planner: "Planner", budget: dict[str, float | None]) -> None:
    """Say on standard error which options of a budget, by name, have no effect on a planner that ends by itself."""
    from skyverse.planners.base import DirectPlanner

    options = [name for name, amount in budget.items() if amount is not None]
    if options and isinstance(planner, DirectPlanner):
        said = f"{type(planner).__name__} ends by itself; without effect: {', '.join(options)}"
        print(f"{said} (mvo and other metaheuristics follow a budget).", file=sys.stderr)


def tell_unknown(scenario: "Scenario", chosen: str | None) -> None:
    """Say on standard error what an OctoMap's unknown space was taken for, where the user has not said it."""
    from skyverse.maps.readers.voxel_grid import KIND_OF_UNKNOWN

    kinds = {shape.kind for shape in scenario.obstacles}
    taken = next((word for word, kind in KIND_OF_UNKNOWN.items() if kind in kinds), None)
    if taken is not None and chosen is None:
        other = next(word for word in KIND_OF_UNKNOWN if word != taken)
        print(f"Unknown space counts as {taken}; --unknown {other} takes it as {other}.", file=sys.stderr)


def without_way(mission: "Mission") -> str:
    """Say which UAVs of a mission have no way to a target."""
    names = [
        uav.name
        for uav, target, trajectory in zip(mission.scenario.uavs, mission.assignment, mission.trajectories, strict=True)
        if target is not None and trajectory is None
    ]
    cut = "It was interrupted. " if mission.interrupted else ""
    return f"{cut}The mission is not complete: {', '.join(names) or 'a target'} has no way."


def judging_scenario(mission: "Mission", source: str | None) -> "tuple[Scenario, str]":
    """Return the scenario that a mission has to answer, and a sentence that names it and says where it is from."""
    import skyverse as sky
    from skyverse.model.quantities import short

    scenario = mission.scenario if source is None else sky.read_scenario(source)
    origin = f"from {source}" if source is not None else "as the mission embeds it; --scenario tells its source"
    return scenario, f"Judged by scenario {scenario.name!r} ({short(scenario.digest)}), {origin}."


def tell_not_proven(name: str, mission: "Mission", source: str | None) -> None:
    """Say on standard error what the referee finds wrong with a mission before it is flown in a simulator.

    Raises
    ------
    InputError
        If the mission embeds another scenario than the one that it has to answer: whether a flight in it is safe says
        nothing of the right one.
    """
    import skyverse as sky

    scenario, judged_by = judging_scenario(mission, source)
    violations = sky.check(scenario, mission)
    for violation in violations:
        if violation.fault is sky.Fault.SCENARIO:
            raise InputError(f"{name}: {violation.message}")
    refuted = [violation for violation in violations if violation.fault is not sky.Fault.UNDECIDED]
    if violations:
        first = (refuted or violations)[0]
        more = f" ({len(violations) - 1} more: skyverse check {name})" if len(violations) > 1 else ""
        verdict = "refutes this mission" if refuted else "cannot decide whether this mission is safe"
        print(f"The referee {verdict}, which is flown all the same: {first.message}{more}", file=sys.stderr)
    if violations or source is not None:
        print(judged_by, file=sys.stderr)
