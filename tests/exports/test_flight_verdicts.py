"""The line of each exported flight tells what is proven of it, and no more."""

import re
from html import unescape

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin
from skyverse.errors import in_words
from skyverse.exports import Apart, verdict_table
from skyverse.exports.verdicts import HEADS

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=46.8, longitude=9.8, altitude=1500.0, geoid=52.0)
EAST = handmade.along([(-100, 0, 50), (100, 0, 50)], 40)
BESIDE = handmade.along([(-100, 100, 50), (100, 100, 50)], 40)
ACROSS = handmade.along([(0, -100, 55), (0, 60, 55)], 40)
WALL = ((0.0, -300.0, 0.0), (1.0, 300.0, 300.0))


def certificate(mission, folder, suffix="plan", **how):
    return handmade.exported(mission, folder, suffix, **how).certificate


def test_a_single_uav_has_one_line_and_nothing_is_said_of_others(tmp_path):
    head, rows = verdict_table(certificate(handmade.mission([EAST], origin=ORIGIN), tmp_path).flights)
    assert head == HEADS[:4]
    assert rows == [("uav-1", "proven", "stays at its target", "at every instant, 30 m up")]


def test_a_fleet_apart_in_space_has_a_line_for_each_and_one_for_all(tmp_path):
    head, rows = verdict_table(certificate(handmade.mission([EAST, BESIDE], origin=ORIGIN), tmp_path).flights)
    assert head == HEADS
    assert [row[0] for row in rows] == ["uav-1", "uav-2", "fleet"]
    assert {row[2:3] + row[4:] for row in rows} == {("stays at its target", "in space")}
    assert [row[3][:15] for row in rows] == ["at every instant"[:15]] * 3


def test_flights_that_depend_on_the_schedule_name_each_other(tmp_path):
    level = handmade.along([(0, -100, 50), (0, 100, 50)], 40, 40.0)
    proof = certificate(handmade.mission([EAST, level, BESIDE], origin=ORIGIN), tmp_path, allow_close=True)
    (kind,) = {kind for kind in proof.apart.pairs.values() if kind is not Apart.SPACE}
    told = {flight.uav: (flight.apart, flight.depends_on) for flight in proof.flights}
    for uav, (weakest, others) in told.items():
        met = [pair for pair in proof.apart.of(kind) if f"uav-{pair[0] + 1}" == uav or f"uav-{pair[1] + 1}" == uav]
        assert weakest is (kind if met else Apart.SPACE)
        assert len(others) == len(met)


def test_gaps_of_the_way_home_are_told_from_when_to_when(tmp_path):
    corners = [(-100, 0, 50), (-100, 310, 50), (100, 310, 50), (100, 0, 50)]
    mission = handmade.mission(
        [handmade.along(corners, 60)], origin=ORIGIN, boxes=[WALL], low=(-400, -400, 0), high=(400, 400, 290)
    )
    proof = certificate(mission, tmp_path)
    (flight,), (back,) = proof.flights, proof.returns
    assert not flight.has_way_home
    assert flight.gaps == tuple((gap.begin, gap.end) for gap in back.gaps)
    begin, end = flight.gaps[0]
    assert (found := re.fullmatch(r"NOT from ([\d.]+) to ([\d.]+) s.*, [\d.]+ m up", flight.row[3]))
    assert [float(found[1]), float(found[2])] == pytest.approx([begin, end], abs=0.06)


@pytest.mark.parametrize(
    ("suffix", "radius", "known"),
    [("plan", 2.0, False), ("waypoints", 2.0, True), ("waypoints", 1.0, True), ("waypoints", 0.5, False)],
)
def test_of_an_aeroplane_it_is_told_where_its_autopilot_does_not_turn_at_the_radius(tmp_path, suffix, radius, known):
    wing = sky.FixedWing(speed=15.0, turn_radius=30.0, climb=15.0)
    bent = handmade.along([(-300, 0, 50), (0, 0, 50), (200, 200, 50)], 40)
    for one, proven in ((wing, known), (None, True)):
        (flight,) = certificate(
            handmade.mission([bent], origin=ORIGIN, wing=one), tmp_path, suffix, radius=radius
        ).flights
        assert flight.legs_proven == proven


@pytest.mark.parametrize(("altitude", "told"), [(120.0, 0), (121.0, 1)])
def test_a_return_altitude_of_more_than_120_m_is_told_in_one_line(tmp_path, altitude, told):
    mission = handmade.mission([EAST, BESIDE], origin=ORIGIN, from_home=True, high=(300, 300, 400))
    notes = handmade.exported(mission, tmp_path, return_altitude=altitude).notes
    assert sum("more than 120 m above home" in note for note in notes) == told


def test_an_aeroplane_has_no_proven_way_home(tmp_path):
    wing = sky.FixedWing(speed=15, turn_radius=30, climb=15)
    (flight,) = certificate(handmade.mission([EAST], origin=ORIGIN, wing=wing), tmp_path).flights
    circles = "circles within 60 m of its target (NOT proven)"
    assert flight.row == ("uav-1", "proven", circles, "NOT proven")  # it flies straight on: there are no corners
    bent = handmade.along([(-300, 0, 50), (0, 0, 50), (200, 200, 50)], 40)
    (flight,) = certificate(handmade.mission([bent], origin=ORIGIN, wing=wing), tmp_path).flights
    assert flight.row == ("uav-1", "NOT proven at corners", circles, "NOT proven")


def test_returns_that_undo_what_was_apart_in_space_are_warned_of(tmp_path, capsys, refuses):
    """One UAV returns through the path of the other."""
    from skyverse.cli.export import WaypointOptions, export

    mission = handmade.mission([EAST, ACROSS], origin=ORIGIN, from_home=True)
    notes = []
    sky.export(mission, tmp_path / "stays.plan", on_note=notes.append)
    assert not any("WARNING" in note for note in notes)
    rtl = {"end": "rtl", "allow_close": True, "return_altitude": 5.0}
    sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(**rtl), on_note=notes.append, page=tmp_path / "m.html")
    (warning,) = [note for note in notes if note.startswith("WARNING")]
    assert warning == (
        "WARNING: apart in space up to their last waypoints, but NOT on the returns that end the mission: uav-1 and "
        "uav-2; give end='land' to land below the last waypoints or end='loiter' to stay there"
    )
    told = in_words(warning)
    assert told.endswith("; give end 'land' to land below the last waypoints or end 'loiter' to stay there")
    page = unescape((tmp_path / "m.html").read_text("utf-8"))
    assert page.index("Apart in flight") < page.index(f"<li>{told}</li>") < page.index("straight legs proven")
    sky.write(mission, tmp_path / "m.json")
    export(
        str(tmp_path / "m.json"),
        tmp_path / "m.plan",
        waypoints=WaypointOptions(end="rtl", return_altitude=5.0),
        allow_close=True,
    )
    said = capsys.readouterr().err.splitlines()
    assert [line.split()[0] for line in said[:4]] == ["UAV", "uav-1", "uav-2", "fleet"]
    assert said[4].startswith("WARNING: apart in space up to")
    assert said[4].endswith("give --end land to land below the last waypoints or --end loiter to stay there")
    with refuses():
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="rtl", return_altitude=5.0, apart_in_space=True))


def test_return_altitudes_of_a_fleet_are_a_separation_apart_where_there_is_room(tmp_path):
    error = sky.TrackingError(horizontal=1.0, vertical=0.5)
    flights = [handmade.along([(-100, y, 20), (100, y, 20)], 40) for y in (-60, -30, 0, 30)]
    for high, apart in ((150.0, True), (25.0, False)):
        mission = handmade.mission(flights, origin=ORIGIN, error=error, from_home=True, high=(300, 300, high))
        proof, notes, _ = handmade.exported(mission, tmp_path)
        assert all(back.everywhere for back in proof.returns)
        levels = np.sort([back.level for back in proof.returns])
        keep = mission.scenario.uavs[0].ellipsoid[1] + 2 * error.vertical
        assert (np.diff(levels).min() >= keep) == apart
        assert any("return altitudes are less than a separation apart" in note for note in notes) != apart
