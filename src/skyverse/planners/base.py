"""What every planner is: frozen settings with one verb, ``plan``."""

import dataclasses
import platform
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse._version import __version__
from skyverse.errors import InputError, require_number, shown
from skyverse.model.result import History, Provenance, Result, Status
from skyverse.model.scenario import Scenario
from skyverse.planners.results import refused_result
from skyverse.problem import Airspace, Problem
from skyverse.stop import OnIteration, Stop, require_stop

Seed = int | np.random.Generator | None


class Planner(ABC):
    """A planner is its settings, a frozen dataclass, and one verb."""

    @abstractmethod
    def plan(
        self, problem: Problem, *, stop: Stop | None = None, rng: Seed = None, on_iteration: OnIteration | None = None
    ) -> Result:
        """Plan one UAV's path.

        Parameters
        ----------
        problem
            The UAV, its target and the space between them.
        stop
            When to end; a `DirectPlanner` ends by itself.
        rng
            Seed or generator; ``None`` draws a seed, which the result's provenance records.
        on_iteration
            Called with a `Progress` after every iteration.
        """

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether paths have straight legs off the scenario's lattice, so that they have no nodes to count."""
        del scenario
        return False


class DirectPlanner(Planner):
    """A planner that ends by itself: it needs neither a stop rule nor random numbers, and it has no iterations."""

    def plan(
        self, problem: Problem, *, stop: Stop | None = None, rng: Seed = None, on_iteration: OnIteration | None = None
    ) -> Result:
        """Plan one UAV's path; see `Planner.plan`. `stop`, `rng` and `on_iteration` have no effect."""
        require_problem(problem, stop)
        origin = provenance(repr(self), None, None)
        found = self.find(problem, origin)
        if isinstance(found, Status):
            return refused_result(problem, found, origin)
        counts = (np.array([count]) for count in dataclasses.astuple(found.effort))
        return dataclasses.replace(found, history=History(np.array([found.cost]), *counts))

    @abstractmethod
    def find(self, problem: Problem, origin: Provenance) -> Result | Status:
        """Return the path with what the search for it took, or the status that says why there is no path."""


def require_problem(problem: object, stop: object = None) -> None:
    """Raise `InputError` for what is no problem to plan, or no rule that ends a run."""
    if not isinstance(problem, Problem):
        one = "; Problem(scenario, uav=0, target=0) is one" if isinstance(problem, Scenario | Airspace) else ""
        raise InputError(f"expected a Problem, found {shown(problem)}{one}", field="problem")
    require_stop(stop)


def numbers_of(found: object, shape: tuple[int, ...], what: str, field: str, infinite: bool = False) -> Floats:
    """Return what somebody's code has made as an array of this shape (-1: any length), or raise `InputError`."""
    try:
        numbers = np.ascontiguousarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.empty(())
    fits = numbers.ndim == len(shape) and all(n in (-1, m) for n, m in zip(shape, numbers.shape, strict=True))
    if not (fits and (numbers > -np.inf).all() and (infinite or (numbers < np.inf).all())):
        lengths = ", ".join("any" if n < 0 else str(n) for n in shape)
        seen = f"{shown(found)} of shape {numbers.shape}"
        raise InputError(f"expected {what}, shape ({lengths}), found {seen}", field=field)
    return numbers


def points_of(found: object, field: str) -> Floats:
    """Return the points of a path that somebody gives, (n, 3) metres, at least one, or raise `InputError`."""
    points = numbers_of(found, (-1, 3), "rows of x, y, z in metres", field)
    if not len(points):
        raise InputError("expected rows of x, y, z in metres, found none", field=field)
    return points.copy()


def seeded(rng: Seed) -> tuple[np.random.Generator, int | None]:
    """Return a generator, and the seed that makes the same one again; ``None`` where the caller made the generator."""
    if isinstance(rng, np.random.Generator):
        return rng, None
    if rng is None:
        rng = int(np.random.SeedSequence().generate_state(1)[0])
    if isinstance(rng, bool) or not isinstance(rng, int | np.integer) or rng < 0:
        raise InputError(f"rng takes None, a whole number from 0 on or a numpy Generator, not {rng!r}")
    return np.random.default_rng(int(rng)), int(rng)


def provenance(planner: str, stop: Stop | None, seed: int | None) -> Provenance:
    """Record what made an answer."""
    machine = f"Python {platform.python_version()}, numpy {np.__version__}, {platform.system()} {platform.machine()}"
    return Provenance(__version__, planner, repr(stop), seed, machine)


def require_schedules(settings: Any) -> None:
    """Refuse settings of the Multi-Verse Optimizer's two schedules that make none."""
    require_number(settings.wep_min, "wep_min", least=0, most=1)
    require_number(settings.wep_max, "wep_max", least=settings.wep_min, most=1)
    require_number(settings.p, "p", least=1e-3, most=1e3)


def wep_and_tdr(settings: Any, spent: float) -> tuple[float, float]:
    """Return WEP (equation 3.8) and TDR (3.9) when a share of the budget is spent."""
    wep = settings.wep_min + spent * (settings.wep_max - settings.wep_min)
    return wep, 1.0 - float(spent ** (1.0 / settings.p))
