"""The planners: frozen parameters with one verb, ``plan(problem, *, stop, rng, on_iteration) -> Result``."""

import dataclasses
import importlib
import inspect
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from skyverse.errors import InputError, did_you_mean, shown

if TYPE_CHECKING:
    from skyverse.planners.base import Planner

_CLASSES = {
    "auto": "auto.Auto",
    "mvo": "mvo.MVO",
    "hybrid-mvo": "hybrid.HybridMVO",
    "gso": "gso.GSO",
    "bbo": "bbo.BBO",
    "random-restart": "restart.RandomRestart",
    "astar": "astar.AStar",
    "taut": "taut.Taut",
    "theta-star": "theta_star.ThetaStar",
    "cheapest": "cheapest.Cheapest",
    **{f"waypoint-{name}": f"waypoint_own.Waypoint{name.upper()}" for name in ("mvo", "gso", "bbo")},
    **{name: f"waypoint_own.{name.upper()}" for name in ("woa", "mfo", "da")},
    **{name: f"waypoint_packages.{name.upper()}" for name in ("pso", "ga", "de", "gwo")},
    "cma-es": "waypoint_packages.CMAES",
    "l-shade": "waypoint_packages.LSHADE",
}

PLANNER_NAMES = tuple(_CLASSES)
"""The names of the planners on the command line and in files."""


def make_planner(name: str, **settings: object) -> "Planner":
    """Return the planner of that name, or of an own class given as ``"module:Class"``, with these settings.

    Raises
    ------
    InputError
        If there is no such planner or setting, or a setting has a value that it cannot have.
    """
    if ":" in name:
        from skyverse.planners.base import Planner

        own: Planner = make_own(name, Planner, settings)
        return own
    if name not in _CLASSES:
        near = did_you_mean(name, PLANNER_NAMES) or f"; there are {', '.join(PLANNER_NAMES)}"
        raise InputError(f"there is no planner {name!r}{near}")
    module, _, cls = _CLASSES[name].partition(".")
    made: Planner = _with_settings(getattr(importlib.import_module(f"{__name__}.{module}"), cls), settings)
    return made


def name_of(planner: object) -> str:
    """Return the name by which `make_planner`, or `make_own`, finds the class of a planner or of an objective."""
    cls = type(planner)
    known = {f"{__name__}.{path}": name for name, path in _CLASSES.items()}
    return known.get(f"{cls.__module__}.{cls.__name__}", f"{cls.__module__}:{cls.__qualname__}")


def make_own(name: str, kind: Any, settings: Mapping[str, object]) -> Any:
    """Return one of a class of one's own of this kind, given as ``"module:Class"``, or raise `InputError`."""
    module, _, attribute = name.partition(":")
    asked = f"expected a {kind.__name__} as module:Class"
    try:
        found = getattr(importlib.import_module(module), attribute, None)
    except (ImportError, ValueError) as error:
        raise InputError(f"{asked}, but {module!r} cannot be imported: {error}") from error
    if not (isinstance(found, type) and issubclass(found, kind)) or inspect.isabstract(found):
        raise InputError(f"{asked}, found {name!r}, which is {shown(found)}")
    return _with_settings(found, settings)


def _with_settings(kind: Any, settings: Mapping[str, object]) -> Any:
    """Return one of a frozen dataclass with these settings; a misspelt one is refused with a list of them."""
    known = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else [*settings]
    unknown = [name for name in settings if name not in known]
    if unknown:
        there_are = ", ".join(known) or "none"
        raise InputError(f"{kind.__name__} has no setting {', '.join(map(repr, unknown))}; it has {there_are}")
    return kind(**settings)


def planner_of(given: "Planner | str | None") -> "Planner":
    """Return a planner that is given as such or by its name; `Auto` where none is given.

    Raises
    ------
    InputError
        If it is neither a planner nor the name of one.
    """
    if given is None or isinstance(given, str):
        return make_planner(given or "auto")
    if isinstance(given, type) or not callable(getattr(given, "plan", None)):
        one = f"; {given.__name__}() is one" if isinstance(given, type) and hasattr(given, "plan") else ""
        said = f"expected a planner, such as Taut(), or its name, such as 'taut', found {shown(given)}{one}"
        raise InputError(said, field="planner")
    return given
