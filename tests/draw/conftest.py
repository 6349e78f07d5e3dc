"""Missions made by hand, and a browser."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from browser import new_tab
from patience import PATIENCE_S
from skyverse.model.result import no_history

JUDGED = sky.Certificate(sky.Verdict.UNDECIDED, "There is no telling.")
"""What a mission has that the referee judged, here without a proof."""
PROVENANCE = sky.Provenance("0.1.0", "MVO(universes=25)", "MaxIterations(4)", 1, "test")


def quintics(points, seconds, start=0.0):
    """Rest to rest along straight pieces: p0 + (p1 - p0) * (10 s^3 - 15 s^4 + 6 s^5)."""
    points = np.array(points, dtype=float)
    coefficients = np.zeros((len(points) - 1, 6, 3))
    coefficients[:, 0] = points[:-1]
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[:, power] = factor * np.diff(points, axis=0) / seconds**power
    return sky.Trajectory(start + seconds * np.arange(len(points)), coefficients)


def answered(path, cost, bound, costs=(), status=sky.Status.COMPLETE):
    path = np.array(path, dtype=float).reshape(-1, 3)
    history = no_history()
    if len(costs):
        paths = 25 * np.arange(1, len(costs) + 1)
        history = sky.History(costs, paths, 80 * paths, paths)
    terms = {"fuel": cost, "divergence": 0.0, "end": 0.0} if len(path) else {}
    start, goal = (path[0], path[-1]) if len(path) else (np.zeros(3), np.zeros(3))
    effort = sky.Effort(25 * max(len(costs), 1), 2000, 25)
    return sky.Result(status, path, cost, terms, bound, start, goal, effort, 0.25, history, "finished", PROVENANCE)


def a_scenario(uavs, targets, name="walls"):
    boxes = (
        sky.Box(min=(0, 2, 0), max=(10, 2.5, 1.5)),
        sky.Box(min=(0, 2, 4.5), max=(10, 2.5, 6)),
        sky.Box(min=(3, 0, 2.4), max=(7, 0.5, 4.5)),
        sky.Box(min=(0, 15, 0), max=(10, 20, 1)),
    )
    return sky.Scenario(
        name=name,
        description="Walls with windows.",
        bounds=sky.Bounds(min=(0, -5, 0), max=(10, 20, 6)),
        obstacles=boxes,
        clearance=0.2,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        uavs=uavs,
        targets=targets,
    )


@pytest.fixture
def mission():
    """Two UAVs cross: the first arrives at 8 s, the second, which sets out at 1 s, at 5 s; one target is spare."""
    scenario = a_scenario(
        (sky.UAV(name="ada", start=(5, -4, 3)), sky.UAV(name="ben", start=(2, 19, 3))),
        (
            sky.Target(name="north", position=(5, 9, 3)),
            sky.Target(name="south", position=(2, 12, 4)),
            sky.Target(name="spare", position=(8, 8, 2)),
        ),
    )
    first = [(5, -4, 3), (2, -4, 3), (2, 9, 3), (5, 9, 3)]
    second = [(2, 19, 3), (2, 19, 4), (2, 12, 4)]
    return sky.Mission(
        scenario=scenario,
        assignment=(0, 1),
        results=(
            answered(first, 44.0, 40.0, costs=[90.0, 60.0, 50.0, 44.0]),
            answered(second, 17.0, 17.0, status=sky.Status.OPTIMAL),
        ),
        trajectories=(
            quintics([first[0], (2, 2.5, 3), first[-1]], 4.0),
            quintics([second[0], second[-1]], 4.0, start=1.0),
        ),
        violations=(),
        provenance=PROVENANCE,
        apart=JUDGED,
    )


@pytest.fixture
def troubled():
    """Names that bite, faults of both kinds, a UAV without path, one not planned, one without target; interrupted."""
    biting = "</script><script>alert(1)</script>"
    scenario = a_scenario(
        (
            sky.UAV(name=biting, start=(5, -4, 3)),
            sky.UAV(name="$b$ {{css}}", start=(2, 19, 3)),
            sky.UAV(name="_c & <b>d</b>", start=(8, 0, 1)),
            sky.UAV(name="idle", start=(9, 0, 1)),
        ),
        tuple(sky.Target(name=f"<i>{k}</i>", position=(5, 9 + k, 3)) for k in range(3)),
        name='<script>alert("name")</script>',
    )
    path = [(5, -4, 3), (5, 9, 3)]
    return sky.Mission(
        scenario=scenario,
        assignment=(0, 1, 2, None),
        results=(
            answered(path, 27.0, None, costs=[np.inf, 40.0, 27.0]),
            answered([], np.inf, None, status=sky.Status.NO_PATH),
            None,
            None,
        ),
        trajectories=(quintics(path, 6.0), None, None, None),
        violations=(
            sky.Violation(sky.Fault.SEPARATION, (0, 1), "0.31 m apart, 0.50 m asked for.", 3.25, (5.0, 2.0, 3.0)),
            sky.Violation(sky.Fault.STATUS, (), "The cost is <27>."),
        ),
        provenance=PROVENANCE,
        interrupted=True,
    )


@pytest.fixture
def grounded():
    """One UAV, a path, no trajectory, no history."""
    scenario = a_scenario((sky.UAV(start=(5, -4, 3)),), (sky.Target(position=(5, 1.5, 3)),))
    result = answered([(5, -4, 3), (5, 1.5, 3)], 12.0, 12.0, status=sky.Status.OPTIMAL)
    return sky.Mission(scenario, (0,), (result,), (None,), (), PROVENANCE, apart=JUDGED)


@pytest.fixture
def swarm():
    """Thirty UAVs in line, each with the same flight beside the last one's."""
    places = [(0.3 * k, -4.0, 3.0) for k in range(30)]
    goals = [(0.3 * k, 1.0, 3.0) for k in range(30)]
    scenario = a_scenario(
        tuple(sky.UAV(start=place) for place in places), tuple(sky.Target(position=goal) for goal in goals)
    )
    pairs = list(zip(places, goals, strict=True))
    return sky.Mission(
        scenario,
        tuple(range(30)),
        tuple(answered(pair, 11.0, 11.0, costs=[20.0, 11.0]) for pair in pairs),
        tuple(quintics(pair, 5.0) for pair in pairs),
        (),
        PROVENANCE,
    )


CHROMIUM = next((p for p in ("/usr/bin/chromium", shutil.which("chromium")) if p and Path(p).exists()), None)
SWITCHES = """--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader"""


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("no chromium to look at the page with")
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES.split(), timeout=1000 * PATIENCE_S)
        yield browser
        browser.close()


@pytest.fixture
def tab(browser):
    with new_tab(browser) as tab:
        yield tab
