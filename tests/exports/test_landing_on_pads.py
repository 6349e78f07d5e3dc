"""In exported columns the tracking error counts for walls beside, not for the ground and roofs below."""

import numpy as np
import pytest

import skyverse as sky
from skyverse import Terrain
from skyverse.exports import LegChecker, LegSpace
from skyverse.exports.leg_space import Segments
from skyverse.exports.way_home_space import Lines, ReturnSpace, proven

ERROR = sky.TrackingError(horizontal=1.5, vertical=2.0)
START, TARGET = (9.0, 12.0, 5.5), (45.0, 12.0, 12.0)
ROOF = sky.Box(min=(6, 9, 0), max=(12, 15, 5))


def wall(away, high, place=START):
    """Return a wall so far east of a place."""
    x, y, _ = place
    return sky.Box(min=(x + away, y - 4, 0), max=(x + away + 1, y + 4, high))


def scenario(*obstacles, **changes):
    given = {
        "name": "column",
        "bounds": {"min": (0, 0, 0), "max": (60, 36, 60)},
        "clearance": 0.5,
        "lattice": {"step": (3, 3, 3), "connectivity": 26},
        "objective": {"unit": "metres"},
        "obstacles": (ROOF, *obstacles),
        "uavs": ({"start": START, "tracking_error": ERROR},),
        "targets": ({"position": TARGET},),
        "frame": {"origin": {"latitude": 47, "longitude": 8, "altitude": 400}},
        "terrain": Terrain(origin=(0, 0), step=(60, 36), heights=np.zeros((2, 2))),
    }
    return sky.Scenario.model_validate(given | changes)


WALLS = [(None, 0.0, True), (1.0, 5.0, True), (1.0, 6.0, False), (1.0, 30.0, False), (2.05, 30.0, True)]


@pytest.mark.parametrize(("away", "high", "clear"), WALLS)
@pytest.mark.parametrize("altitude", ["amsl", "agl"])
def test_a_leg_in_a_column_keeps_the_error_from_walls_but_not_from_roofs_below(away, high, clear, altitude):
    given = scenario(*([] if away is None else [wall(away, high)]))
    foot = np.array(START)
    top = foot + np.array([0, 0, ERROR.vertical + 1e-3])
    legs = LegChecker(LegSpace(given, altitude), ERROR, ((foot, top),))
    checked = legs.leg(foot, top)
    assert (checked.fault is None) == clear
    judged_in = legs.space.referee(Segments(foot, top, 0.01, ERROR, START))
    assert all(kind.obstacle.tolist() in ([], [1], [-2]) for kind in (judged_in.boxes, *judged_in.others))
    if not clear:
        assert legs.space.sentence(checked.fault).startswith("it, with its tracking error, is 0.5 m inside obstacle 1")


@pytest.mark.parametrize(("away", "high", "clear"), WALLS)
def test_a_return_that_lands_in_a_column_keeps_the_error_from_walls_but_not_from_roofs_below(away, high, clear):
    space = ReturnSpace(scenario(*([] if away is None else [wall(away - 0.25, high)])))  # half the clearance is kept
    top, foot = np.array([[*START[:2], 7.5]]), np.array([START])
    line = Lines(space.obstacles, Segments(top, foot, 0.01, ERROR, START), np.array([0]))
    assert line.free().tolist() == [clear]
    assert proven([line]) == clear
    everywhere = line._replace(segments=line.segments._replace(pad=None))
    assert not everywhere.free().any()


@pytest.mark.parametrize(("away", "lands"), [(1.0, False), (3.05, True)])
def test_a_landing_keeps_the_error_from_a_wall_beside_it(tmp_path, away, lands, refuses):
    """The roof of what is beside the target is below the target, but not below where the UAV lands."""
    mission = sky.plan_mission(scenario(wall(away, 11.5, TARGET)), sky.Taut())
    assert mission.violations == ()
    if lands:
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))
        assert (tmp_path / "m.plan").exists()
    else:
        with refuses():
            sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))


def test_an_export_of_a_roof_start_says_on_which_pad_the_error_does_not_count(tmp_path):
    mission = sky.plan_mission(scenario(), sky.Taut())
    notes = []
    sky.export(mission, tmp_path / "m.plan", on_note=notes.append)
    said = " ".join(notes)
    assert mission.certificates[0].sentence.count("up to z = 7.51 m") == said.count("up to z = 7.51 m") == 1
    assert "its way home is proven at every instant" in said
