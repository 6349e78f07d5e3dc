"""The planners: frozen parameters with one verb, ``plan(problem, *, stop, rng, on_iteration) -> Result``."""

import importlib
from typing import TYPE_CHECKING

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
    **{
        name: f"waypoint_methods.{name.replace('-', '').upper()}"
        for name in ("cma-es", "pso", "ga", "de", "l-shade", "woa", "mfo", "gwo", "da")
    },
}

PLANNER_NAMES = tuple(_CLASSES)
"""The names of the planners on the command line and in files."""


def make_planner(name: str, **settings: object) -> "Planner":
    """Return the planner of that name with these settings.

    Raises
    ------
    ValueError
        If there is no such planner, or a setting has a value that it cannot have.
    TypeError
        If there is no such setting.
    """
    if name not in _CLASSES:
        raise ValueError(f"there is no planner {name!r}; there are {', '.join(PLANNER_NAMES)}")
    module, _, cls = _CLASSES[name].partition(".")
    return getattr(importlib.import_module(f"{__name__}.{module}"), cls)(**settings)
