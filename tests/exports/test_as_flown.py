"""Exported files as autopilots fly them: take-off climbs, turns, stops, and climbs and speeds that are off."""

import itertools

import handmade_exports as handmade
import numpy as np
import pytest
import replayed_autopilot as autopilot
from exported_fleets import ORIGIN, broken_promises, fleet, random_fleet, read_orders

import skyverse as sky
from skyverse.exports import Apart

pytest.importorskip("pyproj", reason="an independent geodesy")


def audited():
    """Two UAVs from different heights whose take-off climbs the schedule once left out."""
    corner = 475.0
    starts, targets = [(-corner, 0.0, 30.0), (0.0, -400.0, 80.0)], [(corner, 0.0, 80.0), (0.0, 400.0, 30.0)]
    return fleet(starts, targets, [0.0, 0.0], separation=0.5)


def tracks_of(files, climb, factor, descent=None):
    return [
        autopilot.fly(autopilot.read_waypoints(file.read_text(), ORIGIN), climb, descent or climb, factor)
        for file in files
    ]


def test_uavs_that_start_at_different_heights_meet_on_schedule_after_their_climbs(tmp_path):
    mission, notes = audited(), []
    files = sky.export(mission, tmp_path / "c.waypoints", sky.ExportOptions(altitude="home"), on_note=notes.append)
    (across, above), told = mission.scenario.uavs[0].ellipsoid, " ".join(notes)
    closest = [
        autopilot.nearness(tracks_of(files, climb, factor), 0, 1, across, above)
        for climb in (1.0, 1.5, 2.5, 3.0, 5.0)
        for factor in (0.9, 1.0, 1.1)
    ]
    assert min(closest) >= 0.99 or "NOT at 1 to 5 m/s" in told
    on_schedule = autopilot.nearness(tracks_of(files, 2.5, 1.0, 1.5), 0, 1, across, above)
    assert on_schedule >= 0.99


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_each_uav_is_above_its_home_when_its_trajectory_begins(tmp_path, suffix):
    mission, notes = audited(), []
    files = sky.export(
        mission, tmp_path / f"c.{suffix}", sky.ExportOptions(altitude="home", allow_close=True), on_note=notes.append
    )
    name = {"plan": "px4", "waypoints": "ardupilot"}[suffix]
    read = {"plan": autopilot.read_plan, "waypoints": autopilot.read_waypoints}[suffix]
    orders = [read(file.read_text(), ORIGIN) for file in files]
    up = [o.delay + handmade.takeoff_seconds(o.places[0][2] - o.home[2], name) for o in orders]
    begin = [flight.start for flight in mission.trajectories]
    assert up[0] - begin[0] == pytest.approx(up[1] - begin[1], abs=0.01)
    (told,) = [note for note in notes if note.startswith("All times are of the exported schedule: ")]
    assert float(told.split(" s later than in the mission")[0].split()[-1]) == pytest.approx(up[0] - begin[0], abs=0.1)
    least = {"plan": 2.0, "waypoints": 0.0}[suffix]  # PX4 spools up meanwhile
    assert min(o.delay for o in orders) == pytest.approx(least, abs=0.01) or min(begin) > 0


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("suffix", ["waypoints", "plan", "wpml.kmz"])
def test_random_fleets_keep_what_the_export_promises(tmp_path, suffix, seed):
    mission, seen = random_fleet(seed), []
    files = sky.export(
        mission, tmp_path / f"m.{suffix}", sky.ExportOptions(allow_close=True), on_certificate=seen.append
    )
    orders = read_orders(mission.scenario, files)
    assert broken_promises(mission, orders, seen[0].apart.pairs, np.random.default_rng(seed + 1000)) == []


@pytest.mark.parametrize("seed", range(4))
def test_fleets_planned_apart_in_space_keep_apart_whatever_the_timing(tmp_path, seed):
    mission, seen = random_fleet(seed, apart_in_space=True), []
    files = sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(apart_in_space=True), on_certificate=seen.append)
    assert set(seen[0].apart.pairs.values()) == {Apart.SPACE}
    assert mission.violations == ()
    orders = read_orders(mission.scenario, files)
    assert broken_promises(mission, orders, seen[0].apart.pairs, np.random.default_rng(seed)) == []


def test_paths_that_cross_are_refused_where_they_are_to_be_apart_in_space(tmp_path, refuses):
    starts, targets = [(-50, 0, 30), (0, -50, 30)], [(50, 0, 30), (0, 50, 30)]
    mission = fleet(starts, targets, [0.0, 0.0])
    with refuses():
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(apart_in_space=True))
    assert list(tmp_path.iterdir()) == []
    with refuses():
        sky.plan_mission(
            mission.scenario, sky.AStar(), options=sky.MissionOptions(keep_apart=False, apart_in_space=True)
        )
    around = fleet(starts, targets, [0.0, 0.0], apart_in_space=True)
    assert [action.kind for action in around.deconfliction.actions] == ["detour"]
    assert around.deconfliction.found
    assert sky.check(around.scenario, around) == []


def test_waypoints_less_apart_than_the_plan_name_the_option_that_keeps_them_so(tmp_path):
    starts, targets = [(-50, 0, 30), (0, -50, 30)], [(50, 0, 30), (0, 50, 30)]

    def named(mission, **how):
        said = []
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(**how), on_note=said.append)
        return [note for note in said if "ONLY apart if they start at the same time" in note]

    timed, around = fleet(starts, targets, [0.0, 0.0]), fleet(starts, targets, [0.0, 0.0], apart_in_space=True)
    (told,) = named(around)
    assert [remedy.field for remedy in told.give] == ["apart_in_space"]
    (told,) = named(timed)
    assert "apart_in_space" not in told
    assert named(around, apart_in_space=True) == []
    with pytest.raises(sky.InputError, match="give apart_in_space=True"):
        sky.export(random_fleet(0, apart_in_space=True), tmp_path / "m.plan")


@pytest.mark.usefixtures("unjudged")
def test_waylines_of_more_than_99_waypoints_are_split_and_each_begins_where_the_last_ended(tmp_path):
    import zipfile

    turns = [(10.0 * k, 8.0 * (k % 2), 50.0) for k in range(-14, 15)]
    corners = [(x, y + 20.0 * row, 50.0 + row) for row in range(8) for x, y, _ in (turns if row % 2 else turns[::-1])]
    mission = handmade.mission([handmade.along(corners, 4)], origin=ORIGIN)
    notes = []
    files = sky.export(mission, tmp_path / "m.wpml.kmz", on_note=notes.append)
    assert [file.name for file in files] == [f"m-part-{k}-of-{len(files)}.wpml.kmz" for k in range(1, len(files) + 1)]
    assert len(files) >= 3
    parts = [autopilot.read_wpml(file, ORIGIN, (0, 0, 0), -ORIGIN.geoid).places for file in files]
    assert all(2 <= len(part) <= 99 for part in parts)
    assert all(np.allclose(a[-1], b[0], atol=0.01) for a, b in itertools.pairwise(parts))
    assert sum(map(len, parts)) - len(parts) + 1 == len(sky.routes(mission, takeoff=0, stops=True)[0].points)
    assert "99 waypoints in a file" in " ".join(notes)
    with zipfile.ZipFile(files[0]) as archive:
        assert "noAction" in archive.read("wpmz/waylines.wpml").decode()
