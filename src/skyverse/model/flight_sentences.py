"""Sentences beside the table of flights: who planned the paths, and what a missing gap means."""

from collections import Counter

from skyverse.model.mission import Mission
from skyverse.model.planned_flights import planned_flights
from skyverse.model.result import Result
from skyverse.model.short_lines import counted
from skyverse.model.temporary_zones import temporary_zones


def planners_sentence(mission: Mission) -> str:
    """Return which planners found the paths, and which led some around others; nothing where there is no result."""
    done = mission.deconfliction
    led = set() if done is None else {one.uav for one in done.actions if one.kind in ("detour", "wait")}
    found = [(uav, _planner(result)) for uav, result in enumerate(mission.results) if result is not None]
    if not found:
        return ""
    own = dict.fromkeys(name for uav, name in found if uav not in led) or dict.fromkeys(name for _, name in found)
    others = Counter(name for uav, name in found if name not in own)
    around = "others or zones" if temporary_zones(mission.scenario) else "others"
    more = "".join(f"; {counted(many, 'path')} led around {around} by {name}" for name, many in others.items())
    return f"planned by {' and '.join(own)}{more}"


def unknown_gaps_sentence(mission: Mission) -> str:
    """Return why complete paths have no gap in the table; nothing where each has one."""
    found = [one.result for one in planned_flights(mission) if one.result is not None]
    if all(result.bound is not None for result in found if result.status.reached):
        return ""
    return 'Where the gap is "-", what the best possible path costs at least was not computed.'


def _planner(result: Result) -> str:
    return result.provenance.planner.partition("(")[0].removesuffix(", led around others")
