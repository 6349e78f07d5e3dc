"""Whole numbers, planners and their settings, as a user writes them."""

import ast
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cyclopts import Token

from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.planners.base import Planner


def given(function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call a function with what a user gave; what it complains of becomes bad input."""
    try:
        return function(*args, **kwargs)
    except InputError:
        raise
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from error


def whole_number(_: object, tokens: Sequence[Token]) -> int:
    """Read a whole number from 1 on, or from 0 on for a seed; cyclopts itself would cut 1.5 to 1."""
    text, option = tokens[0].value, tokens[0].keyword
    if not re.fullmatch(r"\+?\d+", text) or (int(text) == 0 and option != "--seed"):
        least = 0 if option == "--seed" else 1
        raise InputError(f"{option}: expected a whole number from {least} on, found {text!r}")
    return int(text)


def planner_of(name: str, settings: list[str]) -> "Planner":
    """Make the planner of that name with settings given as ``name=value``."""
    from skyverse.planners import make_planner

    made: Planner = given(make_planner, name, **values_of(settings))
    return made


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
