"""The numbers of a page: tiles with those of the fleet, and a table of costs with one row for each UAV."""

import math
from collections.abc import Iterable
from html import escape

from skyverse.draw.page_parts import MINUS, NO_VALUE, number, table, tiles, uav_row
from skyverse.draw.profile import Profile
from skyverse.draw.scene import MissionScene, TableRow
from skyverse.model.result import Status


def percent(value: float | None) -> str:
    """Return a gap in per cent, with its sign unless it is zero."""
    if value is None or not math.isfinite(value):
        return NO_VALUE
    if abs(value) < 0.005:
        return "0 %"
    return f"{value:+.{1 if abs(value) >= 0.1 else 2}f} %".replace("-", MINUS)


def decimals(values: Iterable[float | None]) -> int:
    """Return 0 where all values are whole, otherwise 2."""
    finite = [value for value in values if value is not None and math.isfinite(value)]
    return 0 if all(abs(value - round(value)) < 1e-9 for value in finite) else 2


def seconds(value: float | None) -> str:
    """Return a duration in seconds, or in milliseconds where it is short."""
    if value is None:
        return NO_VALUE
    if value < 0.01:
        return f"{1000 * value:.1f} ms"
    return f"{value:.2f} s" if value < 100 else f"{value:,.0f} s"


def fleet_tiles(scene: MissionScene) -> str:
    """Return the tiles with the numbers of the fleet."""
    totals = scene.totals
    places = decimals([*totals.costs.values(), totals.optimum])
    solved = all(math.isfinite(cost) for cost in totals.costs.values())
    cost = NO_VALUE
    if not solved:
        under = "not every UAV has a path"
    elif len(totals.costs) > 1:
        cost = ", ".join(f"{number(sum_, places)} {unit}" for unit, sum_ in totals.costs.items())
        under = "nodes and metres do not add up"
    else:
        cost = number(sum(totals.costs.values()), places)
        under = "optimum unknown"
    if totals.optimum is not None and solved:
        under = f"{scene.bound.removeprefix('exact ')} {number(totals.optimum, places)}"
    search = "1 path" if totals.generated_paths == 1 else f"{totals.generated_paths:,} paths"
    shown = [
        ("Total cost", cost, under),
        ("Gap", percent(totals.gap), f"above the {scene.bound}"),
        ("Makespan", NO_VALUE if totals.makespan is None else f"{totals.makespan:.2f} s", "last arrival"),
        (
            "Paths found",
            f"{totals.reached} of {totals.targeted}",
            "1 UAV" if totals.uavs == 1 else f"{totals.uavs} UAVs",
        ),
        ("Search", seconds(totals.seconds), f"{search} generated"),
    ]
    return tiles(shown)


_SOFT_TERMS = ("altitude", "risk", "climb")
_TERM_TITLES = {"altitude": "Outside band", "risk": "Risk", "climb": "Steepness"}


def _caption(scene: MissionScene, terms: list[str]) -> str:
    weights = scene.scenario.objective
    units = (
        " or ".join(scene.totals.costs) or weights.unit
    )  # paths off the lattice are in metres whatever the objective
    said = [
        f"{weights.fuel:g} &times; fuel ({units})",
        f"{weights.divergence:g} &times; turns",
        f"{weights.end:g} &times; metres short of the target",
    ]
    if weights.altitude is not None and "altitude" in terms:
        band = weights.altitude
        said.append(f"{band.weight:g} &times; metres outside {band.low:g} to {band.high:g} m, a metre flown")
    if "risk" in terms:
        said.append(f"{weights.risk:g} &times; the zones' risk, a metre flown inside")
    if weights.climb is not None and "climb" in terms:
        said.append(f"{weights.climb.weight:g} &times; radians above {weights.climb.angle:g}&deg;, a metre flown")
    return f"Cost = {' + '.join(said)}"


def cost_table(scene: MissionScene) -> str:
    """Return the table of costs and gaps; soft terms have a column only where a row has them."""
    rows = scene.rows
    terms = ["fuel", "divergence", "end", *(term for term in _SOFT_TERMS if any(term in row.terms for row in rows))]
    shares = {term: [row.terms.get(term) for row in rows] for term in terms}
    costs, optima = [row.cost for row in rows], [row.optimum for row in rows]
    places = decimals([*costs, *optima, *(share for column in shares.values() for share in column)])
    optimum = ("Optimum", "exact, on the same lattice")
    if scene.bound == "lower bound":
        optimum = ("Bound", "no path costs less; it may be far below the best one")
    heights = "least and greatest height of the flight above the terrain, at the profile's points"
    if scene.scenario.terrain is not None and scene.scenario.terrain.lowest is not None:
        heights = "least height of the flight above the raised terrain, greatest above its lowest heights"
    columns = [
        ("Cost", " + ".join(terms), [number(cost, places) for cost in costs]),
        (*optimum, [number(cost, places) for cost in optima]),
        ("Gap", f"cost above the {optimum[0].lower()}", [percent(row.gap) for row in rows]),
        *(
            (_TERM_TITLES.get(term, term.capitalize()), "weighted share", [number(share, places) for share in column])
            for term, column in shares.items()
        ),
        ("Above ground", heights, [_height(profile) for profile in scene.profiles]),
        ("Path", "length of the path, metres", [_written("{:,.1f} m", row.length) for row in rows]),
        ("Flight", "duration of the trajectory, seconds", [_written("{:,.2f} s", row.duration) for row in rows]),
        ("Paths", "generated by the search", [_written("{:,}", row.generated_paths) for row in rows]),
        ("Search", "wall-clock time", [seconds(row.seconds) for row in rows]),
    ]
    if scene.scenario.terrain is None:
        columns = [column for column in columns if column[0] != "Above ground"]
    heads = [*(("UAV", ""), ("Target", ""), ("Status", "")), *(column[:2] for column in columns)]
    lines = []
    for shown, *cells in zip(rows, *(column[2] for column in columns), strict=True):
        target = NO_VALUE if shown.target is None else escape(shown.target)
        lines.append(uav_row(shown.uav, shown.colour, (target, _status(shown)), cells))
    return table(_caption(scene, terms), heads, lines, text_columns=3)


def _height(profile: Profile) -> str:
    """Return the least height of a path above the terrain, and the greatest above what a ceiling is counted from."""
    if profile.ground is None or not len(profile.distance):
        return NO_VALUE
    z, lowest = profile.points[:, 2], profile.ground if profile.lowest is None else profile.lowest
    return f"{number((z - profile.ground).min(), 1)} to {number((z - lowest).max(), 1)} m"


def _written(form: str, value: float | None) -> str:
    return NO_VALUE if value is None else form.format(value)


def _status(row: TableRow) -> str:
    if row.status is None:
        return f'<span class="pill">{"no target" if row.target is None else "not planned"}</span>'
    tone = "good" if row.status.reached else "warn" if row.status is Status.INCOMPLETE else "bad"
    return f'<span class="pill {tone}" title="{escape(row.status.sentence)}">{row.status.value}</span>'
