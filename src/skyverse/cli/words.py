"""What a user's words mean, or what is wrong with them."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.planners.base import Planner
    from skyverse.scenario import Scenario


def given(function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call what judges a user's words; its complaint becomes bad input."""
    try:
        return function(*args, **kwargs)
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from error


def with_more(scenario: "Scenario", uavs: list[str] | None, targets: list[str] | None) -> "Scenario":
    """Add UAVs and targets to a scenario, and refuse one that is left without any."""
    from skyverse.files.scenarios import scenario_from_data

    data = scenario.model_dump()
    data["uavs"] = [*data["uavs"], *({"start": _point("--uav", text)} for text in uavs or [])]
    data["targets"] = [*data["targets"], *({"position": _point("--target", text)} for text in targets or [])]
    for kind in ("uavs", "targets"):
        if not data[kind]:
            raise InputError(f"{scenario.name}: {kind}: there are none; give some with --{kind[:-1]} x,y,z")
    return scenario_from_data(scenario.name, data)


def _point(option: str, text: str) -> tuple[float, ...]:
    try:
        point = tuple(float(word) for word in text.split(","))
    except ValueError:
        point = ()
    if len(point) != 3:
        raise InputError(f"{option}: expected x,y,z in metres, as in 0,-4,1, found {text!r}")
    return point


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
    import ast

    from skyverse.planners import make_planner

    values: dict[str, object] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"--set: expected name=value, as in universes=50, found {setting!r}")
        try:
            values[key.strip()] = ast.literal_eval(text.capitalize() if text in ("true", "false") else text)
        except (ValueError, SyntaxError):
            values[key.strip()] = text
    made: Planner = given(make_planner, name, **values)
    return made


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, where they are not there yet."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None


def refuse_output(path: Path) -> None:
    """Find out before a long run, not after it, that its result cannot be kept."""
    import os

    make_folder(path.parent)
    if path.is_dir():
        raise InputError(f"{path}: expected a file, found a folder")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: the folder is read-only")
