"""Tours in flight."""

import pytest

import skyverse as sky

NEAR = sky.Scenario(
    name="near",
    bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 4)),
    obstacles=(sky.Box(min=(7, 0, 0), max=(8, 6, 4)),),
    clearance=0.5,
    uavs=(sky.UAV(start=(3, 3, 2), end="home"),),
    targets=(sky.Target(position=(14, 3, 2), stay=2.0), sky.Target(position=(3, 14, 2), stay=1.0)),
)


@pytest.fixture(scope="module")
def tour():
    return sky.plan_mission(NEAR)


def test_tours_are_refused(tour, refuses):
    with refuses() as refused:
        sky.Replanner(tour)
    assert refused.value.sentence.field == "mission"
