"""By which scenario a mission is judged, and what is told of a mission that is flown although it is not proven."""

import sys
from typing import TYPE_CHECKING

from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario


def judging_scenario(mission: "Mission", source: str | None) -> "tuple[Scenario, str]":
    """Return the scenario that a mission has to answer, and a sentence that names it and says where it is from."""
    import skyverse as sky
    from skyverse.model.digest import short

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
