"""Judges claims that only another search can: that no path is cheaper, and that there is none."""

import math
from itertools import product

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import require_kind
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Certificate, Verdict
from skyverse.referee.column import columns_of
from skyverse.referee.lattice import (
    RefereeLattice,
    can_be_judged,
    cheapest_path,
    judged_lattice,
    lattice_shape,
    reachable_nodes,
)
from skyverse.referee.path import costs_agree
from skyverse.referee.result import judge_result
from skyverse.referee.soft_terms import altitude_term, climb_term, risk_term
from skyverse.referee.tolerances import LATTICE_MARGIN
from skyverse.referee.untrusted import entry, finite_point, number, target_index
from skyverse.referee.world import RefereeWorld, RefereeWorlds, referee_world

MAX_LATTICE_STATES = 400_000
"""States of a lattice that are searched; the thesis's maps have 330,000."""
MAX_PRICED_STATES = 20_000
"""The same where altitude, risk or climb has a price, which takes a millisecond a move."""
AS_CLAIMED = "as claimed by the planner"


def check_optimality(
    scenario: Scenario, mission: Mission, max_states: int = MAX_LATTICE_STATES
) -> tuple[Certificate | None, ...]:
    """Judge for each UAV whether its path is the cheapest, or whether there is none, where its result says so.

    A path on the lattice is compared with the optimum that a search of the referee's own finds: Dijkstra's algorithm
    over all nodes (and moves, where turns have a price). A path of any angle is compared with the straight line, which
    no path beats.

    Parameters
    ----------
    scenario
        What was given.
    mission
        What is judged. However malformed it is, nothing is raised.
    max_states
        States of the lattice that are searched. Where there are more, or where altitude, risk or climb has a price and
        there are more than 20,000, claims stay claims.

    Returns
    -------
    tuple of Certificate or None
        In the scenario's order: proven, or refuted (by a path that costs less), or undecided, which means that the
        claim is the planner's alone. ``None`` for a UAV whose result claims nothing of the kind.
    """
    require_kind(mission, Mission, "mission")
    with np.errstate(all="ignore"):
        judge = _Judge(scenario, max_states)
        found: list[Certificate | None] = []
        for uav in range(len(scenario.uavs)):
            result, target = entry(mission.results, uav), target_index(scenario, entry(mission.assignment, uav))
            judged = None
            if isinstance(result, Result) and target is not None:
                judged = judge.judge(uav, target, result)
            found.append(judged)
        return tuple(found)


class _Judge:
    """Judges the claims of the results of one mission; the lattice is judged once, when it is first needed."""

    def __init__(self, scenario: Scenario, max_states: int) -> None:
        self.worlds = RefereeWorlds(scenario)
        self.scenario, self.digest = scenario, scenario.digest
        self._lattices: dict[tuple[TrackingError, bool], tuple[RefereeWorld, RefereeLattice]] = {}
        world = self.worlds.nominal
        states = int(np.prod(lattice_shape(world), dtype=float))
        if scenario.objective.divergence > 0:
            states *= scenario.lattice.connectivity // 2
        soft = scenario.objective.altitude is not None or scenario.objective.climb is not None or scenario.risky_zones
        most = min(max_states, MAX_PRICED_STATES) if soft else max_states
        self.beyond = f"its lattice has {states:,} states, above {most:,}" if states > most else ""
        if not can_be_judged(world):
            self.beyond = "the diagonal moves of its lattice are judged only among boxes, cylinders and spheres"

    def lattice(self, uav: int, strict: bool) -> tuple[RefereeWorld, RefereeLattice]:
        """Return a UAV's world and its lattice; a strict one holds only moves that every planner has to use."""
        key = self.scenario.uavs[uav].tracking_error, strict
        if key not in self._lattices:
            world = referee_world(_farther(self.scenario), key[0]) if strict else self.worlds.of(uav)
            self._lattices[key] = world, judged_lattice(world, strict=strict)
        return self._lattices[key]

    def judge(self, uav: int, target: int, result: Result) -> Certificate | None:
        """Judge what one result claims, or return ``None`` if it claims nothing."""
        name = self.scenario.uavs[uav].name
        if result.status in (Status.NO_PATH, Status.NO_PATH_EXISTS, Status.START_SHUT_IN):
            return self._judge_absence(name, uav, target)
        if not isinstance(result.status, Status) or not result.status.reached or result.bound is None:
            return None
        claim = f"{name}'s path is optimal" if result.status is Status.OPTIMAL else f"{name}'s bound holds"
        bound = number(result.bound)
        if result.any_angle:
            return self._judge_any_angle(claim, uav, target, result, bound)
        if self.beyond:
            return self._undecided(f"{claim}, {AS_CLAIMED}: {self.beyond}.")
        start, goal = finite_point(result.start), finite_point(result.goal)
        if start is None or goal is None:
            return self._undecided(f"{claim}, {AS_CLAIMED}: it has no start or goal node.")
        optimum, _ = self._search(uav, start, goal, strict=False)
        if bound <= optimum or costs_agree(bound, optimum):
            gap = "" if costs_agree(bound, optimum) else f"; the optimum is {self._told(optimum)}"
            why = f"{claim}: no path on the lattice costs less than {self._told(bound)}{gap}."
            return self._proven(claim, why, uav, target, result)
        cheaper, _ = self._search(uav, start, goal, strict=True)
        if cheaper < bound and not costs_agree(bound, cheaper):
            told = f"no path costs less than {self._told(bound)}, but one costs {self._told(cheaper)}"
            sentence = f"{name} claims that {told}."
            return self._certificate(Verdict.REFUTED, sentence)
        why = f"a path of {self._told(optimum)} keeps clear by less than {LATTICE_MARGIN:g} m more than it must"
        return self._undecided(f"{claim}, {AS_CLAIMED}: {why}.")

    def _judge_any_angle(self, claim: str, uav: int, target: int, result: Result, bound: float) -> Certificate:
        """Compare the bound of a path of any angle with the straight line."""
        way = np.subtract(self.scenario.targets[target].position, self.scenario.uavs[uav].start)
        line = self.scenario.objective.fuel * math.hypot(*way)
        if bound <= line or costs_agree(bound, line):
            return self._proven(claim, f"{claim}: the straight line alone costs {line:.9g} m.", uav, target, result)
        return self._undecided(f"{claim}, {AS_CLAIMED}: its result carries no witness of its bound, {bound:.9g} m.")

    def _judge_absence(self, name: str, uav: int, target: int) -> Certificate:
        """Judge the claim that no path joins a UAV's start and its target."""
        claim = f"{name} has no path"
        if self.beyond:
            return self._undecided(f"{claim}, {AS_CLAIMED}: {self.beyond}.")
        world, lattice = self.lattice(uav, strict=False)
        ends = [np.array(self.scenario.uavs[uav].start), np.array(self.scenario.targets[target].position)]
        for place, column in zip(ends, columns_of(world, uav, target), strict=True):
            place[2] = place[2] if column is None else column.top
        corners = [[lattice.node(node) for node in _cell_corners(lattice, place)] for place in ends]
        starts, goals = ({node for node in nodes if node is not None} for nodes in corners)
        if not reachable_nodes(lattice, starts) & goals:
            sentence = f"{claim} on the lattice, which joins no nodes next to its start and its target."
            return self._certificate(Verdict.PROVEN, sentence)
        sentence = f"{claim}, {AS_CLAIMED}: a path on the lattice joins nodes next to its start and its target."
        return self._undecided(sentence)

    def _search(self, uav: int, start: Floats, goal: Floats, strict: bool) -> tuple[float, list[int]]:
        """Return the price of the cheapest path between two nodes, in the objective's unit, and its nodes."""
        objective = self.scenario.objective
        world, lattice = self.lattice(uav, strict)
        first, last = lattice.node(start), lattice.node(goal)
        if first is None or last is None:
            return np.inf, []
        lengths = np.linalg.norm(lattice.moves * lattice.step, axis=1)
        by_nodes = objective.unit == "nodes"
        fuel = objective.fuel * (np.ones(len(lengths)) if by_nodes else lengths)
        head = objective.fuel if by_nodes else 0.0

        def price(a: int, b: int) -> float:
            return _soft_price(world, np.stack([lattice.position(a), lattice.position(b)]), by_nodes, strict)

        soft = objective.altitude is not None or objective.climb is not None or bool(self.scenario.risky_zones)
        cost, nodes = cheapest_path(lattice, first, last, price if soft else fuel, objective.divergence)
        return cost + head, nodes

    def _proven(self, claim: str, sentence: str, uav: int, target: int, result: Result) -> Certificate:
        """Return that a claim is proven, if the result that makes it is right in everything else."""
        wrong = next(judge_result(self.worlds.of(uav), uav, target, result, None), None)
        if wrong is not None:
            return self._undecided(f"{claim}, {AS_CLAIMED}: its result is wrong elsewhere. {wrong.message}")
        return self._certificate(Verdict.PROVEN, sentence)

    def _told(self, cost: float) -> str:
        """Return the cost of a path on the lattice with its unit."""
        return f"{cost:.9g} {'nodes' if self.scenario.objective.unit == 'nodes' else 'm'}"

    def _undecided(self, sentence: str) -> Certificate:
        return self._certificate(Verdict.UNDECIDED, sentence)

    def _certificate(self, verdict: Verdict, sentence: str) -> Certificate:
        return Certificate(verdict, sentence, scenario=self.digest)


def _soft_price(world: RefereeWorld, leg: Floats, by_nodes: bool, strict: bool) -> float:
    """Return what a leg (2, 3) costs with its soft terms; of risks along a surface the least, or if strict the most."""
    objective = world.scenario.objective
    total = objective.fuel * (1.0 if by_nodes else math.dist(leg[1], leg[0]))
    if objective.altitude is not None:
        total += objective.altitude.weight * altitude_term(objective.altitude, leg, world.ground)
    if objective.climb is not None:
        total += objective.climb.weight * climb_term(objective.climb, leg)
    if world.scenario.risky_zones:
        _, least, most = risk_term(world.scenario, leg)
        total += objective.risk * (most if strict else least)
    return total


def _farther(scenario: Scenario) -> Scenario:
    """Return a scenario in which everything must be kept farther away by `LATTICE_MARGIN`."""
    changes: dict[str, object] = {"clearance": scenario.clearance + LATTICE_MARGIN}
    if scenario.terrain is not None and scenario.terrain.clearance is not None:
        clearance = scenario.terrain.clearance + LATTICE_MARGIN
        changes["terrain"] = derived(scenario.terrain, clearance=clearance)
    if scenario.max_height is not None:
        changes["max_height"] = scenario.max_height - LATTICE_MARGIN
    return derived(scenario, **changes)


def _cell_corners(lattice: RefereeLattice, place: Floats) -> list[Floats]:
    """Return the nodes of a lattice at the corners of the cell that holds a place (3,), metres."""
    share = (place - lattice.low) / lattice.step
    corners = np.unique(list(product(*zip(np.floor(share), np.ceil(share), strict=True))), axis=0)
    return [lattice.low + corner * lattice.step for corner in corners if (corner < lattice.shape).all()]
