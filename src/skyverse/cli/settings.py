"""Planners and their settings, as a user writes them."""

import ast
from typing import TYPE_CHECKING, Any

from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.scenario import Scenario
    from skyverse.planners.base import Planner


def given(function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call a function with what a user gave; what it complains of becomes bad input."""
    try:
        return function(*args, **kwargs)
    except InputError:
        raise
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from error


def planner_of(name: str, settings: list[str], scenario: "Scenario") -> "Planner":
    """Make the planner of that name with settings given as ``name=value``; ``auto`` is the one for the scenario."""
    from skyverse.planners import make_planner
    from skyverse.planners.auto import Auto

    values = values_of(settings)
    if name == "auto" and values:
        raise InputError("--set: expected --planner with it, as in --planner mvo --set universes=50")
    try:
        planner: Planner = given(make_planner, name, **values)
    except InputError as error:
        raise InputError(f"--set {error}" if error.sentence.field in values else error.sentence) from error
    return planner.choose(scenario) if isinstance(planner, Auto) else planner


def values_of(settings: list[str]) -> dict[str, object]:
    """Read settings given as ``name=value``."""
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
