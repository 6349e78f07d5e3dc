"""Figures 4.1 to 4.9, 4.26 and 4.27: paths, trajectories and instants of flights, planned again by MVO."""

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING

from skyverse.draw.figures import instant, paths, trajectories
from skyverse.draw.scene import MissionScene, scene
from skyverse.lab.report import Block, Figure
from skyverse.mission.plan_mission import Assignment, MissionOptions, plan_mission
from skyverse.model.mission import Mission
from skyverse.reproduction.cell_runs import CellRuns, ThesisPart, case, no_jobs, planner
from skyverse.reproduction.published import CASES, THESIS_MAPS
from skyverse.stop import MaxIterations

if TYPE_CHECKING:
    from matplotlib import figure


Draw = Callable[[MissionScene], "figure.Figure"]
POPULATION, ITERATIONS = CASES[1]
FIGURE_SEED = 0
INSTANTS = (("initial", 0.0), ("middle", 0.5), ("final", 1.0))


def parts() -> list[ThesisPart]:
    """Return the figures of this page of the thesis."""
    figures: list[tuple[str, str, Draw]] = [
        *((f"path on Map {k}", name, paths) for k, name in enumerate(THESIS_MAPS, 1)),
        *((f"trajectory on Map {k}", name, trajectories) for k, name in enumerate(THESIS_MAPS, 1)),
        *((f"{when} instant of the flight on Map 2", "map2", partial(_at, share)) for when, share in INSTANTS),
    ]
    return [
        ThesisPart(f"fig-4.{k}", no_jobs, partial(_blocks, f"fig-4.{k}", *figure))
        for k, figure in enumerate(figures, 1)
    ]


def fleet_trajectories(name: str, assignment: Assignment) -> Figure:
    """Return the figure of Table 4.8's fleet, with or without coordination."""
    mission = _planned("table-4.8", assignment)
    how = "without coordination" if assignment == "identity" else "with Munkres"
    text = (
        f"**Figure {name.removeprefix('fig-')}**: trajectories of five UAVs on Map 3, {how}: total cost "
        f"{mission.cost:g}, makespan {mission.makespan:.1f} s (MVO as described, seed {FIGURE_SEED})."
    )
    return Figure(name, text, lambda: trajectories(scene(mission)))


def _blocks(name: str, what: str, scenario: str, draw: Draw, cells: CellRuns) -> Sequence[Block]:
    result = _planned(scenario).results[0]
    assert result is not None
    text = (
        f"**Figure {name.removeprefix('fig-')}**: {what}: MVO as described, {POPULATION} x {ITERATIONS}, "
        f"seed {FIGURE_SEED}; cost {result.cost:g}, optimum {result.bound:g}."
    )
    return [Figure(name, text, lambda: draw(scene(_planned(scenario))))]


def _at(share: float, drawn: MissionScene) -> "figure.Figure":
    return instant(drawn, share * (drawn.makespan or 0.0))


@cache
def _planned(scenario: str, assignment: Assignment = "path-cost") -> Mission:
    return plan_mission(
        case(scenario, assignment).scenario,
        planner("MVO", "as described", POPULATION),
        stop=MaxIterations(ITERATIONS),
        rng=FIGURE_SEED,
        assignment=assignment,
        options=MissionOptions(shape="stop-and-go", keep_apart=False),  # as in the thesis
    )
