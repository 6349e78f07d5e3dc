"""The study that the verb ``compare`` runs: from a file, or from scenarios and options."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyverse.cli.settings import values_of
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.lab.study import Study

_BUDGET_OPTIONS = ("paths", "nodes", "evaluations", "iterations", "seconds")


def study_of(sources: list[str], asked: dict[str, Any]) -> "Study":
    """Return the study of a file, or of scenarios and options.

    Parameters
    ----------
    sources
        One study file, or scenarios by name or file.
    asked
        The options by name, ``None`` where one is not given.
    """
    from skyverse.files.document import parse, read_text
    from skyverse.lab.study import study_from_data

    for source in map(Path, sources):
        if source.suffix.lower() not in (".yaml", ".yml", ".json") or not source.is_file():
            continue
        data = parse(source, read_text(source))
        if not isinstance(data, dict) or not {"scenarios", "planners", "policies"} & data.keys():
            continue
        if len(sources) > 1:
            raise InputError(f"{source}: expected one study file or scenarios, found both in {' '.join(sources)}")
        given = [f"--{name}" for name, value in asked.items() if value is not None]
        if given:
            raise InputError(
                f"{given[0]}: expected a study file or options, found both; {source} says all of the study"
            )
        own = [str(source.parent.resolve()), str(Path.cwd())]  # modules beside the study's file, then those here
        sys.path[:] = [*(folder for folder in sys.path if folder not in own and folder), *own]
        named = data if "name" in data else {**data, "name": source.stem}
        return study_from_data(source, named, source.parent)
    budget = {name: asked[name] for name in _BUDGET_OPTIONS if asked[name] is not None}
    if len(budget) > 1:
        raise InputError(f"{' '.join('--' + name for name in budget)}: expected one budget; a study file can list more")
    first = asked["seed"] or 0
    data = {
        "name": "compare",
        "scenarios": sources,
        "planners": _planners(asked["planner"] or ["mvo", "random-restart"], asked["set"] or []),
        "seeds": list(range(first, first + _run_count(asked["runs"] or 30))),
        "budget": budget or {"paths": 1000},
        "assignment": asked["assignment"] or "path-cost",
    }
    return study_from_data("compare", data)


def _planners(names: list[str], settings: list[str]) -> list[dict[str, Any]]:
    """Return the planners with their settings: those of all, and those of one, which is named before a dot."""
    planners: list[dict[str, Any]] = [{"planner": name} for name in names]
    for setting, value in values_of(settings).items():
        owner, dot, name = setting.rpartition(".")
        if dot and owner not in names:
            raise InputError(f"--set: {setting}: expected a planner that is compared, found {owner!r}")
        for planner in planners:
            if owner in ("", planner["planner"]):
                planner[name] = value
    return planners


def _run_count(runs: int) -> int:
    """Return how many runs are asked for, or refuse too many."""
    from skyverse.lab.study_parts import MAX_SEEDS

    if runs > MAX_SEEDS:
        raise InputError(f"--runs: expected at most {MAX_SEEDS:,}, found {runs:,}")
    return runs
