"""A small mission of tours: two UAVs, six stays, batteries that are changed, and a target inside an obstacle."""

from functools import cache

import skyverse as sky


@cache
def rounds():
    """Return the mission, judged; nobody can reach its last target, and one battery does not give the rest."""
    vehicle = {"end": "home", "hover_power": 100.0, "mass": 1.0, "battery": 0.9, "swap": 10.0}
    places = [(18, 2 + 3 * k, 2 + k % 3) for k in range(6)]
    return sky.plan_mission(
        sky.Scenario(
            name="rounds",
            bounds={"min": (0, 0, 0), "max": (20, 20, 10)},
            obstacles=[{"min": (8, 4, 0), "max": (12, 12, 6)}],
            clearance=0.3,
            uavs=[{"name": name, "start": (1, y, 1), **vehicle} for name, y in (("ada", 1), ("ben", 18))],
            targets=[
                *({"name": f"mast-{k}", "position": place, "stay": 3.0} for k, place in enumerate(places[1:], 2)),
                {"name": "mast-1", "position": places[0], "stay": 3.0, "window": (0, 1000)},
                {"name": "<shut>", "position": (10, 8, 3)},
            ],
        ),
        sky.Taut(),
        rng=1,
    )
