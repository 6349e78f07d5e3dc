"""What a user's words mean, or what is wrong with them."""

import itertools
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import Token

from skyverse.cli.places import point_of
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.lab.study import Study
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario
    from skyverse.planners.base import Planner

_BUDGETS = ("paths", "nodes", "evaluations", "iterations", "seconds")


def given(function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call what judges a user's words; its complaint becomes bad input."""
    try:
        return function(*args, **kwargs)
    except InputError:
        raise
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from error


def file_name(name: str) -> str:
    """Return what a file may be called after a scenario, wherever that came from."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._")[:100] or "mission"


def whole_number(_: object, tokens: Sequence[Token]) -> int:
    """Read a whole number from 1 on, or from 0 on for a seed; cyclopts itself would cut 1.5 to 1."""
    text, option = tokens[0].value, tokens[0].keyword
    if not re.fullmatch(r"\+?\d+", text) or (int(text) == 0 and option != "--seed"):
        least = 0 if option == "--seed" else 1
        raise InputError(f"{option}: expected a whole number from {least} on, found {text!r}")
    return int(text)


def with_more(source: str, scenario: "Scenario", uavs: list[str] | None, targets: list[str] | None) -> "Scenario":
    """Add UAVs and targets to a scenario, and refuse one that is left without any."""
    from skyverse.files.scenarios import scenario_from_data

    data = {name: getattr(scenario, name) for name in type(scenario).model_fields}
    for kind, field, words in (("uav", "start", uavs), ("target", "position", targets)):
        things = data[f"{kind}s"] = list(data[f"{kind}s"])
        names = {thing.name for thing in things}
        free = (name for number in itertools.count(len(things) + 1) if (name := f"{kind}-{number}") not in names)
        things += [{"name": next(free), field: point_of(f"--{kind}", text)} for text in words or []]
        if not things:
            raise InputError(f"{source}: {kind}s: there are none; give some with --{kind} x,y,z")
    return scenario_from_data(source, data)


def tell_unsought(scenario: "Scenario", planner: "Planner") -> None:
    """Say on standard error which terms of the objective a planner does not seek to lower."""
    from skyverse.cost import soft_terms
    from skyverse.planners.taut import Taut
    from skyverse.planners.theta_star import ThetaStar

    terms = soft_terms(scenario)
    if terms and isinstance(planner, Taut | ThetaStar):
        said = f"{type(planner).__name__} seeks length alone; priced, but not sought: {', '.join(terms)}"
        print(f"{said} (astar and hybrid-mvo seek them).", file=sys.stderr)


def tell_unknown(scenario: "Scenario", chosen: str | None) -> None:
    """Say on standard error what an OctoMap's unknown space was taken for, where nobody has chosen it."""
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


def refuse_unsafe(source: str, scenario: "Scenario") -> None:
    """Refuse a scenario with a start or target in a wall or out of bounds, before anything is planned."""
    from skyverse.space.world import World

    world = World(scenario)
    places = [(f"uavs[{i}].start", u.name, u.start) for i, u in enumerate(scenario.uavs)]
    places += [(f"targets[{i}].position", t.name, t.position) for i, t in enumerate(scenario.targets)]
    for field, name, point in places:
        why = world.why_unsafe(point)
        if why is not None:
            raise InputError(f"{source}: {field} ({name}): expected a safe point, found {point}, which {why}")


def planner_of(name: str, settings: list[str]) -> "Planner":
    """Make the planner of that name with settings given as ``name=value``."""
    from skyverse.planners import make_planner

    made: Planner = given(make_planner, name, **values_of(settings))
    return made


def values_of(settings: list[str]) -> dict[str, object]:
    """Read settings given as ``name=value``."""
    import ast

    values: dict[str, object] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"--set: expected name=value, as in universes=50, found {setting!r}")
        try:
            values[key.strip()] = ast.literal_eval(text.capitalize() if text in ("true", "false") else text)
        except (ValueError, SyntaxError):
            values[key.strip()] = text
    return values


def study_of(sources: list[str], flags: dict[str, Any]) -> "Study":
    """Return the study of a file, or of scenarios and flags."""
    from skyverse.files.document import parse, read_text
    from skyverse.lab.study import study_from_data

    for source in map(Path, sources):
        if source.suffix.lower() not in (".yaml", ".yml", ".json") or not source.is_file():
            continue
        data = parse(source, read_text(source))
        if not isinstance(data, dict) or not {"scenarios", "planners"} & data.keys():
            continue
        if len(sources) > 1:
            raise InputError(f"{source}: expected one study file or scenarios, found both in {' '.join(sources)}")
        given = [f"--{name}" for name, value in flags.items() if value is not None]
        if given:
            raise InputError(f"{given[0]}: expected a study file or flags, found both; {source} says all of the study")
        return study_from_data(source, data if "name" in data else {**data, "name": source.stem}, source.parent)
    budget = {name: flags[name] for name in _BUDGETS if flags[name] is not None}
    if len(budget) > 1:
        raise InputError(f"{' '.join('--' + name for name in budget)}: expected one budget; a study file can list more")
    first = flags["seed"] or 0
    data = {
        "name": "compare",
        "scenarios": sources,
        "planners": _planners(flags["planner"] or ["mvo", "random-restart"], flags["set"] or []),
        "seeds": list(range(first, first + _few(flags["runs"] or 30))),
        "budget": budget or {"paths": 1000},
        "assignment": flags["assignment"] or "path-cost",
    }
    return study_from_data("compare", data)


def _planners(names: list[str], settings: list[str]) -> list[dict[str, Any]]:
    """Give settings to all planners, or, where one is named before a dot, to that one."""
    planners: list[dict[str, Any]] = [{"planner": name} for name in names]
    for setting, value in values_of(settings).items():
        owner, dot, name = setting.rpartition(".")
        if dot and owner not in names:
            raise InputError(f"--set: {setting}: expected a planner that is compared, found {owner!r}")
        for planner in planners:
            if owner in ("", planner["planner"]):
                planner[name] = value
    return planners


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, where they are not there yet."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None


def refuse_output(path: Path, *read: str | Path) -> None:
    """Find out before a long run, not after it, that its result cannot be kept, or would replace what is read."""
    import os

    make_folder(path.parent)
    if path.exists() and any(Path(one).exists() and path.samefile(one) for one in read):
        raise InputError(f"{path}: expected another file than what is read, which would be replaced")
    if path.is_dir():
        raise InputError(f"{path}: expected a file, found a folder")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: the folder is read-only")


def _few(runs: int) -> int:
    from skyverse.lab.study import MAX_SEEDS

    if runs > MAX_SEEDS:
        raise InputError(f"--runs: expected at most {MAX_SEEDS:,}, found {runs:,}")
    return runs
