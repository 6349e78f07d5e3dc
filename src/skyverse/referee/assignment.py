"""Judges which scenario a mission answers, who is sent where, and which results and trajectories there are."""

from collections.abc import Iterator
from typing import TypeGuard

import numpy as np
from pydantic import BaseModel

from skyverse.errors import InputError
from skyverse.model.mission import Mission
from skyverse.model.quantities import short
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.sorties import judge_visits, makes_tours, sound_sorties
from skyverse.referee.untrusted import target_index
from skyverse.referee.world import require_sound


def judge_assignment(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Return what is wrong with who is sent where, and with which results and trajectories there are."""
    found = []
    count = len(scenario.uavs)
    fleet = counted(count, "UAV")
    if mission.scenario != scenario:
        found.append(Violation(Fault.SCENARIO, (), alteration(scenario, mission.scenario)))
    columns = {noun: getattr(mission, noun) for noun in ("assignment", "results", "trajectories")}
    for noun, values in columns.items():
        if len(values) != count:
            message = f"The mission has {counted(len(values), 'entry', 'entries')} of {noun} for {fleet}."
            found.append(Violation(Fault.ASSIGNMENT, (), message))
    takers: dict[int, int] = {}
    for uav in range(min(count, *(len(values) for values in columns.values()))):
        name = scenario.uavs[uav].name
        given, result, trajectory = mission.assignment[uav], mission.results[uav], mission.trajectories[uav]
        target = target_index(scenario, given)
        complaints = []
        if given is not None and target is None:
            complaints.append(f"is sent to target {given!r}, but targets are numbered 0 to {len(scenario.targets) - 1}")
        if target is not None and target in takers:
            other = scenario.uavs[takers[target]].name
            complaints.append(f"is sent to {scenario.targets[target].name}, which {other} already has")
        if target is not None:
            takers.setdefault(target, uav)
        for value, kind in ((result, Result), (trajectory, Trajectory)):
            if value is not None and not isinstance(value, kind):
                complaints.append(f"has a {type(value).__name__} in place of a {kind.__name__.lower()}")
        if given is not None and result is None:
            complaints.append("has a target but no result")
        for value, noun in ((result, "result"), (trajectory, "trajectory")):
            if given is None and value is not None and not any(one.strips for one in sound_sorties(mission, uav)):
                complaints.append(f"has a {noun} but no target")
        found += [Violation(Fault.ASSIGNMENT, (uav,), f"{name} {complaint}.") for complaint in complaints]
    if makes_tours(scenario, mission):
        return [*found, *judge_visits(scenario, mission)]
    wanted = min(count, len(scenario.targets))
    if len(takers) < wanted and not found:
        targets = len(scenario.targets)
        message = f"{len(takers)} of {fleet} have a target, but with {counted(targets, 'target')} {wanted} must."
        found.append(Violation(Fault.ASSIGNMENT, (), message))
    return found


MAX_NAMED = 6
"""Fields that a message names; it counts the others."""
MAX_VALUE_CHARACTERS = 40
"""Characters of a value in a message."""


def alteration(scenario: Scenario, embedded: object) -> str:
    """Say in which fields the scenario that a mission embeds differs from the scenario that it is judged by."""
    if not isinstance(embedded, Scenario):
        return "The mission embeds no scenario."
    try:
        require_sound(embedded)
    except InputError as error:
        return f"The mission embeds a scenario that is none: {error}."
    found = list(_differences("", scenario, embedded))
    named = "; ".join(found[:MAX_NAMED]) + (f"; and {len(found) - MAX_NAMED} more" if len(found) > MAX_NAMED else "")
    return (
        f"The mission embeds another scenario ({short(embedded.digest)}) than {scenario.name!r} "
        f"({short(scenario.digest)}), by which it is judged: {named or 'they are of different kinds'}."
    )


def _differences(place: str, ours: object, theirs: object) -> Iterator[str]:
    """Yield the fields below a place that differ, each with the value that is right and the one in the mission."""
    if isinstance(ours, BaseModel) and type(ours) is type(theirs):
        if ours != theirs:
            for name in type(ours).model_fields:
                inner = f"{place}.{name}" if place else name
                yield from _differences(inner, getattr(ours, name), getattr(theirs, name))
    elif isinstance(ours, np.ndarray) and isinstance(theirs, np.ndarray):
        if ours.shape != theirs.shape:
            yield f"{place} has shape {theirs.shape} in the mission, not {ours.shape}"
        elif not np.array_equal(ours, theirs):
            yield f"{place} differs in {np.count_nonzero(ours != theirs):,} of {ours.size:,} numbers"
    elif _has_models(ours) and _has_models(theirs):
        if len(ours) != len(theirs):
            yield f"{place} has {counted(len(theirs), 'entry', 'entries')} in the mission, not {len(ours)}"
        for k, (one, other) in enumerate(zip(ours, theirs, strict=False)):
            yield from _differences(f"{place}[{k}]", one, other)
    elif isinstance(ours, np.ndarray) or isinstance(theirs, np.ndarray):
        yield f"{place} is {'missing' if theirs is None else 'given'} in the mission{'' if theirs is None else ' only'}"
    elif ours != theirs:
        yield f"{place} is {_shown(theirs)} in the mission, not {_shown(ours)}"


def _has_models(value: object) -> TypeGuard[tuple[object, ...]]:
    return isinstance(value, tuple) and (not value or isinstance(value[0], BaseModel))


def _shown(value: object) -> str:
    text = f"{value:.9g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= MAX_VALUE_CHARACTERS else f"{text[: MAX_VALUE_CHARACTERS - 3]}..."
