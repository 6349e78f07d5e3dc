import pytest

import skyverse as sky


@pytest.fixture(scope="session")
def mission():
    return sky.plan_mission(sky.read_scenario("table-4.9-2"), sky.MVO(), stop=sky.MaxIterations(3), rng=1)
