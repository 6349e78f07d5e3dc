"""The objective's terms of lattice paths, given as nodes (thesis, equations 3.2 to 3.4), and of straight legs."""

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Objective, Scenario
from skyverse.model.shapes import Cylinder, Prism, Zone
from skyverse.numerics.kernel import by_reference, inner, inner_query, kernel, query, writable
from skyverse.numerics.norm import distance, norm
from skyverse.numerics.tolerances import COLLINEAR, OPTIMALITY_GAP, STATED_COST
from skyverse.space import band, chord
from skyverse.space.ground import Ground, make_ground
from skyverse.space.lattice import Grid, position
from skyverse.space.solids import Solids, make_solids
from skyverse.space.voxels import parts_of


@by_reference
class Rates(NamedTuple):
    """An objective compiled for straight legs; every price includes its weight.

    Attributes
    ----------
    metre, turn, end
        The prices of a metre flown, of a joint at which the path turns, of a metre between the path's end and the goal.
    soft
        Whether anything that follows has a price.
    altitude, low, high, above
        The price of a metre flown a metre outside the altitude band, the band's limits in metres, and whether they are
        counted from the ground.
    climb, steepest
        The price of a metre flown a radian too steeply, and the angle, radians, above which it is too steep.
    zones, risks
        The zones that may be flown through at a risk, in the order of their index; (n,) the price of a metre inside.
    frames
        The rectangles around the edges of the zones; see `chord.frames_around`.
    order
        (n,) the numbers of the zones sorted by kind: cylinders first, then prisms, then others.
    ground
        The terrain, if the band is counted from it.
    """

    metre: float
    turn: float
    end: float
    soft: bool
    altitude: float
    low: float
    high: float
    above: bool
    climb: float
    steepest: float
    zones: Solids
    risks: Floats
    frames: Floats
    order: Ints
    ground: Ground


def make_rates(scenario: Scenario) -> Rates:
    """Compile a scenario's objective and zones for straight legs."""
    objective = scenario.objective
    limits, limit = objective.altitude, objective.climb
    above = limits is not None and limits.above == "ground"
    zones = sorted(scenario.risky_zones, key=_rank)
    solids = [solid for zone in zones for solid in parts_of(zone)]
    compiled, order = make_solids(solids)
    risks = np.array([objective.risk * (solid.risk or 0.0) for solid in solids], dtype=np.float64)
    return Rates(
        metre=objective.fuel,
        turn=objective.divergence,
        end=objective.end,
        soft=bool(soft_terms(scenario)),
        altitude=0.0 if limits is None else limits.weight,
        low=0.0 if limits is None else limits.low,
        high=0.0 if limits is None else limits.high,
        above=above,
        climb=0.0 if limit is None else limit.weight,
        steepest=0.0 if limit is None else math.radians(limit.angle),
        zones=compiled,
        risks=risks[order],
        frames=chord.frames_around(compiled.edges),
        order=np.argsort(order),
        ground=make_ground(scenario.terrain if above else None),
    )


def _rank(zone: Zone) -> int:
    """Return the number by which zones are sorted by kind."""
    return 0 if isinstance(zone, Cylinder) else 1 if isinstance(zone, Prism) else 2


@cache
def _unpriced() -> Rates:
    return Rates(
        *(0.0, 0.0, 0.0, False, 0.0, 0.0, 0.0, False, 0.0, 0.0),
        *(make_solids([])[0], np.zeros(0), np.zeros((0, 4)), np.zeros(0, np.int64), make_ground(None)),
    )


def soft_terms(scenario: Scenario) -> tuple[str, ...]:
    """Return those of ``altitude``, ``risk`` and ``climb`` that a scenario prices."""
    objective = scenario.objective
    priced = (objective.altitude is not None, bool(scenario.risky_zones), objective.climb is not None)
    return tuple(name for name, on in zip(("altitude", "risk", "climb"), priced, strict=True) if on)


def prices_length_alone(scenario: Scenario) -> bool:
    """Tell whether straight legs are priced by their length alone: neither turns nor altitude, risk or climb."""
    return scenario.objective.divergence == 0 and not soft_terms(scenario)


@by_reference
class Pricing(NamedTuple):
    """An objective compiled for one lattice; every price includes its weight.

    Attributes
    ----------
    steps
        (8,) the price of a move, indexed by the axes that it changes: ``ex + 2 ey + 4 ez``.
    first
        The price of the path's first node.
    turn, end
        The prices of a turn, and of a metre between the path's end and the goal.
    rates
        The prices of straight legs, for the soft terms of moves.
    """

    steps: Floats
    first: float
    turn: float
    end: float
    rates: Rates


def make_pricing(objective: Objective, step: Floats, rates: Rates | None = None) -> Pricing:
    """Compile an objective for a lattice with these metres per step, (3,); without rates there are no soft terms."""
    axes = [(e & 1, (e >> 1) & 1, e >> 2) for e in range(8)]
    lengths = [math.hypot(*(a * s for a, s in zip(used, step, strict=True))) for used in axes]
    by_nodes = objective.unit == "nodes"
    steps = np.array([objective.fuel * (1.0 if by_nodes else length) for length in lengths])
    steps[0] = 0.0
    return Pricing(
        steps, objective.fuel if by_nodes else 0.0, objective.divergence, objective.end, rates or _unpriced()
    )


@inner_query
def _moved(grid: Grid, a: int, b: int) -> tuple[int, int, int]:
    """Return by how many nodes node b lies from node a along each axis."""
    ny, nz = grid.shape[1], grid.shape[2]
    return b // (ny * nz) - a // (ny * nz), (b // nz) % ny - (a // nz) % ny, b % nz - a % nz


@query
def fuel(grid: Grid, pricing: Pricing, nodes: Ints) -> float:
    """Return alpha_1 C_fuel, equation 3.2: for the number of the path's nodes, start included, or for its length."""
    if pricing.steps[1] == pricing.steps[7] and pricing.first > 0.0:
        return pricing.first * len(nodes)
    total = pricing.first
    for i in range(1, len(nodes)):
        dx, dy, dz = _moved(grid, nodes[i - 1], nodes[i])
        total += pricing.steps[abs(dx) + 2 * abs(dy) + 4 * abs(dz)]
    return total


@query
def divergence(grid: Grid, pricing: Pricing, nodes: Ints) -> float:
    """Return alpha_2 C_divergence: for the number of non-zero cross products of consecutive steps."""
    turns = 0
    if pricing.turn > 0.0 and len(nodes) > 2:
        ax, ay, az = _moved(grid, nodes[0], nodes[1])
        for i in range(2, len(nodes)):
            bx, by, bz = _moved(grid, nodes[i - 1], nodes[i])
            if ay * bz != az * by or az * bx != ax * bz or ax * by != ay * bx:
                turns += 1
            ax, ay, az = bx, by, bz
    return pricing.turn * turns


@kernel
def end(grid: Grid, pricing: Pricing, nodes: Ints, goal: int) -> float:
    """Return alpha_3 C_end, equation 3.3: for the Euclidean distance from the path's end to the goal, metres."""
    last = nodes[-1]
    if last == goal:
        return 0.0
    a, b = position(grid, last), position(grid, goal)
    return pricing.end * math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@kernel
def soft(grid: Grid, pricing: Pricing, nodes: Ints) -> Floats:
    """Return the weighted shares of altitude, risk and climb, (3,), move by move."""
    shares = np.zeros(3)
    if pricing.rates.soft and len(nodes):
        a = position(grid, nodes[0])
        for i in range(1, len(nodes)):
            b = position(grid, nodes[i])
            add_soft(pricing.rates, a, b, shares)
            a = b
    return shares


@kernel
def total(grid: Grid, pricing: Pricing, nodes: Ints, goal: int) -> float:
    """Return C, equation 3.4, plus the soft terms."""
    price = fuel(grid, pricing, nodes) + divergence(grid, pricing, nodes) + end(grid, pricing, nodes, goal)
    if pricing.rates.soft:
        price += soft(grid, pricing, nodes).sum()
    return price


@inner
def add_soft(rates: Rates, a: Floats, b: Floats, shares: Floats) -> None:
    """Add the weighted shares of altitude, risk and climb, (3,), of a straight leg a-b."""
    across = math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2)
    rise = abs(b[2] - a[2])
    size = math.sqrt(across * across + rise * rise)
    if size == 0.0:
        return
    if rates.above:
        shares[0] += rates.altitude * size * band.outside(rates.ground, rates.low, rates.high, a, b)
    elif rates.altitude > 0.0:
        bottom, top = min(a[2], b[2]), max(a[2], b[2])
        shares[0] += rates.altitude * size * (_mean_above(rates.low - top, rates.low - bottom))
        shares[0] += rates.altitude * size * (_mean_above(bottom - rates.high, top - rates.high))
    if len(rates.risks):
        shares[1] += size * chord.priced(rates.zones, rates.frames, rates.risks, a, b)
    if rates.climb > 0.0:
        shares[2] += rates.climb * size * max(0.0, math.atan2(rise, across) - rates.steepest)


@inner
def _mean_above(least: float, most: float) -> float:
    """Return the mean of max(0, v) for v distributed evenly between the least and the most."""
    if least >= 0.0:
        return (least + most) / 2
    if most <= 0.0:
        return 0.0
    return most / (most - least) * most / 2


@inner
def leg_price(rates: Rates, a: Floats, b: Floats, shares: Floats) -> float:
    """Return the price of a straight leg a-b without turns; `shares`, (3,), is memory that is overwritten."""
    price = rates.metre * distance(a, b)
    if rates.soft:
        shares[:] = 0.0
        add_soft(rates, a, b, shares)
        price += shares[0] + shares[1] + shares[2]
    return price


@inner
def turn_price(rates: Rates, a: Floats, v: Floats, b: Floats) -> float:
    """Return the price of the joint v between the legs a-v and v-b: that of a turn, or 0 where they are in line."""
    if rates.turn == 0.0:
        return 0.0
    px, py, pz = v[0] - a[0], v[1] - a[1], v[2] - a[2]
    qx, qy, qz = b[0] - v[0], b[1] - v[1], b[2] - v[2]
    across = norm(py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx)
    return rates.turn if across > COLLINEAR * norm(px, py, pz) * norm(qx, qy, qz) else 0.0


@kernel
def legs(rates: Rates, path: Floats, goal: Floats) -> Floats:
    """Return the weighted shares of a path (n, 3) of straight legs, metres: (6,) in the order of `terms_of_legs`.

    Fuel is paid for its length, whatever the objective's unit.
    """
    shares = np.zeros(6)
    soft_shares = shares[3:]
    before = path[0]
    for i in range(1, len(path)):
        a, b = path[i - 1], path[i]
        size = distance(a, b)
        if size == 0.0:  # a place twice in a row hides no turn
            continue
        shares[0] += rates.metre * size
        shares[1] += turn_price(rates, before, a, b)
        if rates.soft:
            add_soft(rates, a, b, soft_shares)
        before = a
    last = path[-1]
    shares[2] = rates.end * distance(last, goal)
    return shares


def terms_of_nodes(scenario: Scenario, grid: Grid, pricing: Pricing, nodes: Ints, goal: int) -> dict[str, float]:
    """Return the terms of a lattice path by name; they add up to `total`."""
    shares = [fuel(grid, pricing, nodes), divergence(grid, pricing, nodes), end(grid, pricing, nodes, goal)]
    return _named(scenario, [*shares, *soft(grid, pricing, nodes).tolist()])


def terms_of_legs(scenario: Scenario, rates: Rates, path: Floats, goal: Floats) -> dict[str, float]:
    """Return the terms of a path (n, 3) of straight legs by name; they add up to its cost."""
    return _named(scenario, legs(rates, writable(path), goal).tolist())


def terms_of_path(scenario: Scenario, rates: Rates, path: Floats, goal: Floats, *, any_angle: bool) -> dict[str, float]:
    """Return the terms of a path (n, 3), whose nodes are counted where that is its unit and it is on the lattice."""
    terms = terms_of_legs(scenario, rates, path, goal)
    if scenario.objective.unit == "nodes" and not any_angle:
        terms["fuel"] = scenario.objective.fuel * len(path)
    return terms


def _named(scenario: Scenario, shares: Sequence[float]) -> dict[str, float]:
    """Return the shares of those terms that the scenario prices, by name."""
    names = ("fuel", "divergence", "end", "altitude", "risk", "climb")
    priced = {*names[:3], *soft_terms(scenario)}
    return {name: share for name, share in zip(names, shares, strict=True) if name in priced}


def wrong_figures(scenario: Scenario, rates: Rates, result: Result) -> str:
    """Say what is wrong with the cost, terms, bound or history that a result states for its path; empty if nothing is.

    By an objective of one's own, nobody else can tell what a path costs.
    """
    if not len(result.path):
        return (
            "" if result.cost == math.inf else f"there is no path, so that the cost is infinite, not {result.cost:.9g}"
        )
    history = result.history.cost
    falls = (history[1:] <= history[:-1]).all() and all(_agree(last, result.cost) for last in history[-1:])
    uneven = "" if falls else f"the history of costs does not fall to the cost, {result.cost:.9g}"
    if result.objective:
        return uneven
    true = terms_of_path(scenario, rates, result.path, result.goal, any_angle=result.any_angle)
    price, bound = sum(true.values()), result.bound
    same = result.terms.keys() == true.keys() and all(_agree(result.terms[name], true[name]) for name in true)
    if not (same and _agree(result.cost, price)):
        return f"it states {_bill(result.terms, result.cost)}, but its path makes {_bill(true, price)}"
    if result.status is Status.OPTIMAL and (bound is None or not _agree(bound, price)):
        return f"the path is called optimal at cost {price:.9g}, but its bound is {bound}"
    if result.status.reached and bound is not None and not price >= bound * (1 - OPTIMALITY_GAP):
        return f"the path costs {price:.9g}, less than the bound {bound:.9g} that no path can beat"
    return uneven


def _agree(stated: float, true: float) -> bool:
    return abs(stated - true) <= STATED_COST * max(1.0, abs(true))


def _bill(terms: dict[str, float], price: float) -> str:
    return ", ".join(f"{name} {share:.9g}" for name, share in terms.items()) + f" and cost {price:.9g}"
