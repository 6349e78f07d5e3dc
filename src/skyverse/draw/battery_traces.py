"""Batteries over the time of a mission, as plotly traces."""

import math
from itertools import pairwise

import numpy as np

from skyverse.draw.plotly_values import Trace, flat, plain, trace
from skyverse.draw.scenes import MissionScene
from skyverse.model.short_lines import told_seconds
from skyverse.tour_table import NumberedSortie

MAX_CURVES = 40
"""Sorties at most whose batteries are drawn, of more those with the least left."""
BELOW = 6.0
"""Per cent by which the words beside a reserve are below it."""
STRIDE = 4
"""One sample of a battery in this many is drawn."""


def of_batteries(scene: MissionScene) -> list[Trace]:
    """Return what is left of batteries in each sortie at least, in per cent, and what must be left."""
    known = sorted((one for one in scene.sorties if one.spare is not None), key=lambda one: one.spare or 0.0)
    drawn = sorted(known[:MAX_CURVES], key=lambda one: (one.uav, one.number))
    if not drawn:
        return []
    ends = [min(one.sortie.begin for one in drawn), max(one.sortie.end for one in drawn)]
    reserves = [_reserve(ends, share) for share in dict.fromkeys(one.vehicle.reserve for one in drawn)]
    return [*reserves, *_swaps(scene, drawn), *(each for one in drawn for each in _course(scene, one))]


def _reserve(ends: list[float], share: float) -> Trace:
    points = {"x": [*flat(ends), None, *flat(ends[:1])], "y": [*flat([100 * share] * 2), None, 100 * share - BELOW]}
    words, role = ["", "", "", f"must be left: {100 * share:g} %"], {"role": "reserve"}
    return trace("scatter", "lines+text", "reserve", points, None, role, text=words, textposition="middle right")


def _swaps(scene: MissionScene, drawn: list[NumberedSortie]) -> list[Trace]:
    """Return dotted lines from the end of a sortie to the begin of the next, while the battery is changed."""
    made = []
    for one, after in pairwise(drawn):
        if one.uav == after.uav and one.battery is not None and after.battery is not None:
            points = {
                "x": flat([one.sortie.end, after.sortie.begin]),
                "y": flat([100 * one.battery.left[-1], 100 * after.battery.left[0]]),
            }
            line, role = {"color": scene.tracks[one.uav].colour, "width": 1, "dash": "dot"}, {"role": "swap"}
            made.append(trace("scatter", "lines", "swap", points, None, role | {"uav": one.uav}, line=line))
    return made


def _course(scene: MissionScene, one: NumberedSortie) -> list[Trace]:
    """Return how the battery of a sortie empties, and its point of no return where that is before its end."""
    battery, track = one.battery, scene.tracks[one.uav]
    assert battery is not None
    name = f"{plain(track.name)}, sortie {one.number}"
    shown = np.unique(np.r_[0 : len(battery.instants) : STRIDE, len(battery.instants) - 1])
    points = {"x": flat(battery.instants[shown]), "y": flat(100 * battery.left[shown])}
    held = flat(battery.left[shown] * (one.vehicle.battery or 0.0))
    hover = "%{fullData.name}<br>t = %{x:.1f} s<br>at least %{y:.1f} %, %{customdata:.4g} Wh left<extra></extra>"
    line, role = {"color": track.colour, "width": 2.5}, {"role": "battery", "uav": one.uav}
    made = [trace("scatter", "lines", name, points, hover, role, line=line, customdata=held)]
    last = battery.no_return
    if last is not None and last < battery.instants[-1]:
        points = {"x": flat([last]), "y": flat([100 * float(np.interp(last, battery.instants, battery.left))])}
        told = f"{name}<br>point of no return, t = {told_seconds(last)}<br>from here on it goes on along the plan"
        marker = {"symbol": "x", "size": 10, "color": track.colour, "line": {"width": 1}}
        sides = ("top right", "bottom left", "top left", "bottom right")
        beside = {"textposition": sides[one.uav % len(sides)], "textfont": {"color": track.colour}}
        more = {"text": [f"no return {told_seconds(math.floor(last))}"], "marker": marker, **beside}
        hover = f"{told}<extra></extra>"
        role = {"role": "no return", "uav": one.uav}
        made.append(trace("scatter", "markers+text", "point of no return", points, hover, role, **more))
    return made
