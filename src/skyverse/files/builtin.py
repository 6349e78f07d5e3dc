"""Built-in scenarios: the thesis's maps (Tables 3.1, 3.2, misprints corrected) and fleets (4.1, 4.8 to 4.13), hills."""

from typing import Literal, get_args

from skyverse.model.scenario import Bounds, Lattice, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.uav import UAV

Corner = tuple[float, float, float]

THESIS_CLEARANCE = 0.25
THESIS_LATTICE = Lattice(step=(0.1, 0.1, 0.5))

_LONG_BOUNDS = ((0, -5, 0), (10, 20, 6))
_MAP1_BOXES = (
    ((0, 2, 0), (10, 2.5, 1.5)),
    ((0, 2, 4.5), (10, 2.5, 6)),
    ((0, 2, 1.5), (3, 2.5, 4.5)),
    ((7, 2, 1.5), (10, 2.5, 4.5)),
    ((3, 0, 2.4), (7, 0.5, 4.5)),
    ((0, 15, 0), (10, 20, 1)),
    ((0, 15, 1), (10, 16, 3.5)),
    ((0, 18, 4.5), (10, 19, 6)),
)
_BUILTIN_MAPS: dict[int, tuple[tuple[Corner, Corner], tuple[tuple[Corner, Corner], ...]]] = {
    1: (_LONG_BOUNDS, _MAP1_BOXES),
    2: (
        ((0, 0, 0), (20, 5, 6)),
        (
            ((3.1, 0, 2.1), (3.9, 5, 6)),
            ((9.1, 0, 2.1), (9.9, 5, 6)),
            ((15.1, 0, 2.1), (15.9, 5, 6)),
            ((0.1, 0, 0), (0.9, 5, 3.9)),
            ((6.1, 0, 0), (6.9, 5, 3.9)),
            ((12.1, 0, 0), (12.9, 5, 3.9)),
            ((18.1, 0, 0), (18.9, 5, 3.9)),
        ),
    ),
    3: (
        _LONG_BOUNDS,
        (
            *_MAP1_BOXES,
            ((0, -2, 0), (10, -1.5, 1.5)),
            ((0, -2, 3), (10, -1.5, 5.5)),
            ((0, 7, 0), (10, 7.5, 0.5)),
            ((0, 7, 2), (10, 7.5, 5.5)),
            ((0, 11, 0), (10, 11.5, 2.5)),
            ((0, 11, 4), (10, 11.5, 5.5)),
        ),
    ),
}

# by name: the number of the map, a description, starts, targets
_BUILTIN_FLEETS: dict[str, tuple[int, str, tuple[Corner, ...], tuple[Corner, ...]]] = {
    "map1": (1, "One UAV on Map 1 (Table 4.1)", ((0, -4, 1),), ((2, 17, 3),)),
    "map2": (2, "One UAV on Map 2 (Table 4.1)", ((0, 1, 5),), ((19, 1, 5),)),
    "map3": (3, "One UAV on Map 3 (Table 4.1)", ((0, -4, 1),), ((2, 17, 3),)),
    "table-4.8": (
        3,
        "Five UAVs on Map 3, with and without coordination (Table 4.8)",
        ((5, -4.9, 3), (2, 19.5, 3.2), (5, 10, 5.8), (5, 0, 1), (5.1, -4, 4)),
        ((5, 9, 3), (6, 10, 4), (5, 19.5, 4), (5, 19, 3), (5, 9, 5)),
    ),
    "table-4.9-2": (
        2,
        "Two UAVs on Map 2 (Table 4.9)",
        ((11.6, 2.8, 5.8), (11.2, 4.5, 5)),
        ((19.8, 4.5, 5.6), (1.8, 4, 4)),
    ),
    "table-4.9-3": (
        2,
        "Three UAVs on Map 2 (Table 4.9)",
        ((11.6, 2.8, 5.8), (14.1, 2, 5), (11.2, 4.5, 5)),
        ((19.8, 2, 5), (19.8, 4.5, 5.6), (1.8, 4, 4)),
    ),
    "table-4.9-4": (
        2,
        "Four UAVs on Map 2 (Table 4.9)",
        ((11.6, 2.8, 5.8), (14.1, 2, 5), (14, 4, 5), (11.2, 4.5, 5)),
        ((19.8, 2, 5), (19.8, 4.5, 5.6), (2, 4, 5.6), (19.8, 3, 5.9)),
    ),
    "table-4.11": (
        1,
        "Five UAVs on Map 1 (Table 4.11)",
        ((5, -4, 3), (6, -4, 3), (5, 2.5, 3), (5, 3, 3), (5, -4, 5.5)),
        ((5, 19, 2), (6, 19.5, 3), (6, 18, 3.2), (5, 15, 5.5), (5, 14, 5.2)),
    ),
    "table-4.12": (
        2,
        "Five UAVs on Map 2 (Table 4.12)",
        ((14.1, 2.8, 5.8), (11.6, 2, 5), (8.1, 3, 5), (14, 4, 5), (11.2, 4.5, 5)),
        ((19.8, 2, 5), (19.8, 4.5, 5.6), (1.8, 4, 5.6), (2, 3, 5.9), (5, 4, 5.2)),
    ),
    "table-4.13": (
        3,
        "Five UAVs on Map 3 (Table 4.13)",
        ((5, -4.9, 3), (6, -4, 4), (5, 0, 1), (5, 0, 5.8), (5.1, -4, 4)),
        ((5, 19, 3), (2, 19.5, 3.2), (5, 14, 3), (5, 14, 4), (5, 15, 5)),
    ),
}

BuiltinName = Literal[
    "map1",
    "map2",
    "map3",
    "table-4.8",
    "table-4.9-2",
    "table-4.9-3",
    "table-4.9-4",
    "table-4.11",
    "table-4.12",
    "table-4.13",
    "jacksboro",
]
"""The names of the built-in scenarios, for type checkers."""
BUILTIN_NAMES: tuple[str, ...] = get_args(BuiltinName)


def builtin(name: str) -> Scenario:
    """Return the built-in scenario of that name, one of `BUILTIN_NAMES`."""
    if name == "jacksboro":
        from skyverse.samples.jacksboro import jacksboro

        return jacksboro()
    number, what, starts, targets = _BUILTIN_FLEETS[name]
    (low, high), boxes = _BUILTIN_MAPS[number]
    return Scenario(
        name=name,
        description=f"{what}.",
        bounds=Bounds(min=low, max=high),
        obstacles=tuple(Box(min=a, max=b) for a, b in boxes),
        clearance=THESIS_CLEARANCE,
        lattice=THESIS_LATTICE,
        uavs=tuple(UAV(start=p) for p in starts),
        targets=tuple(Target(position=p) for p in targets),
    )
