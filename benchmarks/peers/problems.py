"""The problems: the three maps of the thesis and two random cities, each from start to target."""

import math
from typing import NamedTuple

import numpy as np

import skyverse as sky
from skyverse.numerics.kernel import Stopwatch

KNOWN = {"map1": 22.4106, "map2": 26.5205, "map3": 22.6379}
"""Metres: the shortest known lengths, found by other means; for cities the reference is the best of the current run."""

CITIES = {"city-0": 0, "city-1": 1}
NAMES = (*KNOWN, *CITIES)


class Case(NamedTuple):
    """A problem: its name, what is given, the shortest length known, metres, where one is."""

    name: str
    scenario: sky.Scenario
    known: float | None

    @property
    def straight(self) -> float:
        """Metres from start to target."""
        return math.dist(self.scenario.uavs[0].start, self.scenario.targets[0].position)


def case(name: str) -> Case:
    """Return a problem by its name; its objective is length in metres, and nothing else has a price."""
    scenario = sky.random_city(2000, seed=CITIES[name]) if name in CITIES else sky.read_scenario(name)
    objective = sky.Objective(unit="metres", end=1e6)  # so that an incomplete path never looks short
    return Case(name, scenario.model_copy(update={"objective": objective}), KNOWN.get(name))


def on_lattice(scenario: sky.Scenario, connectivity: int, step: float | None = None) -> sky.Scenario:
    """Return the scenario with another connectivity of its lattice, and another step, metres."""
    steps = scenario.lattice.step if step is None else (step, step, step)
    return scenario.model_copy(update={"lattice": sky.Lattice(step=steps, connectivity=connectivity)})


def compiled(scenario: sky.Scenario) -> tuple[sky.Problem, float]:
    """Return the problem with its world compiled, and the seconds that took, kernels loaded."""
    sky.World(scenario)
    clock = Stopwatch()
    problem = sky.Problem(scenario)
    return problem, clock.seconds


def between_ends(problem: sky.Problem, path: np.ndarray) -> np.ndarray:
    """Return a lattice path with the UAV's true start before it and the true target behind it."""
    return np.vstack([problem.start, path, problem.end])


def length(path: np.ndarray) -> float:
    """Return a path's metres."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
