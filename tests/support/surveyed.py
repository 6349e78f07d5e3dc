"""A mission made by hand that photographs sloping ground."""

import numpy as np

import skyverse as sky

EAST, NORTH, LEVEL = 0.3, 0.1, 50.0
"""The ground rises by these shares to the east and north, from this height at the zero."""
CAMERA = sky.Camera(name="test", sensor=(12.0, 9.0), image=(4000, 3000), focal=10.0, min_interval=1.0)
GAP = sky.CoverageGap(0, ((10.0, 10.0), (20.0, 10.0), (20.0, 20.0)), 50.0, "behind <b>a</b> wall")
COVERAGE = sky.Coverage(
    0, sky.Verdict.REFUTED, "Survey <field>: 98.7 % is seen.", 21, 12_346.0, (0.98765, 0.9), 0.0191, 0.018, 0.0223,
    (71.26, np.nan), 20, 3, (GAP,),
)  # fmt: skip


def surveyed(heights=None, **survey):
    """One UAV flies level to the east, over sloping ground, and takes a photo every 5 m."""
    x = np.arange(-300.0, 301.0, 25.0)
    slope = LEVEL + EAST * x[:, None] + NORTH * x
    field = {"area": [(-40, -30), (40, -30), (40, 30), (-40, 30)], "camera": CAMERA, "gsd": 0.03} | survey
    scenario = sky.Scenario(
        name="slope",
        clearance=1.0,
        bounds=sky.Bounds(min=(-300, -300, -100), max=(300, 300, 400)),
        terrain=sky.Terrain(origin=(-300, -300), step=(25, 25), heights=slope if heights is None else heights),
        uavs=(sky.UAV(name="ada", start=(-50, 0, 120), end="home"),),
        surveys=(sky.Survey(**field),),
    )
    way = np.zeros((1, 2, 3))
    way[0] = [(-50, 0, 120), (10, 0, 0)]
    strip = sky.Strip(0, 0.0, 10.0, 5.0, scenario.surveys[0].pitch)
    made = sky.Provenance("0.1.0", "by hand", "none", 1, "test")
    flown = (sky.Trajectory(np.array([0.0, 10.0]), way),)
    sorties = ((sky.Sortie(0.0, 10.0, (), (strip,)),),)
    return sky.Mission(scenario, (None,), (None,), flown, (), made, coverage=(COVERAGE,), sorties=sorties)
