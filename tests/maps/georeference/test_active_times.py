"""When zones are active, by the calendar of Python, instant by instant."""

import json
import re
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

import skyverse as sky
from of_maps import of_maps
from skyverse.maps.georeference.active_times import active_times

BEGIN = datetime(2026, 11, 26, 10, tzinfo=timezone(timedelta(hours=1)))  # a Thursday, 09:00 UTC
DAYS = ("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN")
RING = [[10.004, 49.996], [10.006, 49.996], [10.006, 50.004], [10.004, 50.004], [10.004, 49.996]]


def in_force(spans, second):
    if spans is None:
        return True
    return any((a is None or a <= second) and (b is None or second <= b) for a, b in spans)


def daily(day, start, end):
    return {"day": day, "startTime": start, "endTime": end}


@pytest.mark.parametrize(
    ("said", "spans"),
    [
        ({"startDateTime": "2026-11-26T09:30:00Z"}, ((1800.0, None),)),
        ({"endDateTime": "2026-11-26T09:30:00Z"}, ((None, 1800.0),)),
        (
            {"startDateTime": "2026-11-26T10:30:00+01:00", "endDateTime": "2026-11-26T12:00:00+02:00"},
            ((1800.0, 3600.0),),
        ),
        ({"endDateTime": "2026-11-26T08:59:59Z"}, ()),
        ({"startDateTime": "2026-11-27T09:00:01Z"}, ()),
        ({"validFrom": "2026-11-01T00:00:00Z", "validTo": "2026-12-01T00:00:00Z"}, None),
        ({"applicability": [{"permanent": "YES"}, {"permanent": "NO", "endDateTime": "2000-01-01T00:00:00Z"}]}, None),
        (
            {"applicability": [{"permanent": "NO", "schedule": [daily(["THU"], "08:00Z", "16:00Z")]}]},
            ((None, 25200.0),),
        ),
        ({"applicability": [{"schedule": [daily(["WED"], "20:00Z", "09:30Z")]}]}, ((None, 1800.0),)),
        ({"applicability": [{"schedule": [daily(["THU"], "20:00Z", "06:00Z")]}]}, ((39600.0, 75600.0),)),
        ({"applicability": [{"schedule": [daily(["FRI"], "00:30+02:00", "01:00+02:00")]}]}, ((48600.0, 50400.0),)),
        ({"applicability": [{"schedule": [daily(["SAT"], "08:00Z", "16:00Z")]}]}, ()),
        ({"applicability": [{"schedule": [daily(["ANY"], "00:00:00.00Z", "00:00:00.00Z")]}]}, None),
        ({"applicability": [{"schedule": [daily(["ANY"], "00:00:00Z", "23:59:59Z")]}]}, None),
        (
            {
                "limitedApplicability": [
                    {"startDateTime": "2026-11-26T11:00:00Z", "schedule": [daily(["ANY"], "10:00Z", "12:00Z")]},
                    {"startDateTime": "2026-11-26T11:30:00Z", "endDateTime": "2026-11-26T13:00:00Z"},
                ]
            },
            ((7200.0, 14400.0),),
        ),
        ({"TimeSpan": [{"begin": "2026-11-26T09:01:00Z", "end": "2026-11-26T09:02:00Z"}]}, ((60.0, 120.0),)),
    ],
)
def test_times_are_seconds_after_the_mission_begins(said, spans):
    assert active_times(said, "z", BEGIN) == spans


quarters = st.integers(0, 95).map(lambda k: f"{k // 4:02d}:{k % 4 * 15:02d}")
zones = st.sampled_from(["Z", "+01:00", "-03:30", "+12:45", "-11:00"])
periods = (
    st.fixed_dictionaries(
        {},
        optional={
            "startDateTime": st.integers(-200, 200),
            "endDateTime": st.integers(-200, 200),
            "schedule": st.lists(
                st.tuples(st.sets(st.sampled_from((*DAYS, "ANY")), min_size=1), quarters, quarters, zones),
                min_size=1,
                max_size=3,
            ),
        },
    )
    .filter(bool)
    .filter(lambda one: one.get("startDateTime", -999) < one.get("endDateTime", 999))
)


@given(
    some=st.lists(periods, min_size=1, max_size=3),
    seconds=st.lists(st.integers(0, 86400), min_size=20, max_size=60),
    place=st.sampled_from(["UTC", "Asia/Kathmandu", "Pacific/Auckland", "America/Denver"]),
)
def test_a_zone_is_active_when_the_calendar_says_so(some, seconds, place):
    begin = datetime(2026, 11, 26, 10, tzinfo=ZoneInfo(place))

    def written(one):
        said = {
            name: (begin + timedelta(minutes=value * 10)).astimezone(UTC).isoformat()
            for name, value in one.items()
            if name != "schedule"
        }
        if "schedule" in one:
            said["schedule"] = [
                daily(sorted(days), start + zone, end + zone) for days, start, end, zone in one["schedule"]
            ]
        return said

    def holds(one, at):
        if "startDateTime" in one and at < begin + timedelta(minutes=10 * one["startDateTime"]):
            return False
        if "endDateTime" in one and at > begin + timedelta(minutes=10 * one["endDateTime"]):
            return False
        for days, start, end, zone in one.get("schedule", ()):
            local = at.astimezone(datetime.fromisoformat("2026-01-01T00:00" + zone).tzinfo)
            clock, today = local.strftime("%H:%M:%S"), DAYS[local.weekday()]
            yesterday, start, end = DAYS[local.weekday() - 1], start + ":00", end + ":00"
            if start < end:
                if days & {today, "ANY"} and start <= clock <= end:
                    return True
            elif (days & {today, "ANY"} and clock >= start) or (days & {yesterday, "ANY"} and clock <= end):
                return True
        return "schedule" not in one

    spans = active_times({"limitedApplicability": [written(one) for one in some]}, "z", begin)
    for second in seconds:
        at = begin.astimezone(UTC) + timedelta(seconds=second)
        assert in_force(spans, second) == any(holds(one, at) for one in some), (second, spans)


def test_times_that_cannot_be_read_are_refused(refuses):
    period = {"schedule": [daily(["MON"], "08:00Z", "16:00Z")]}
    for said in (
        {"startDateTime": "2026-05-01"},
        {"startDateTime": "2026-05-01T08:00:00"},
        {"valid_until": 20260501},
        {"TIMESOFUSE": "SR-SS"},
        {"hoursOfOperation": {"operatingHours": [{"dayOfWeek": 0, "sunrise": True}]}},
        {"startDateTime": "2026-05-01T08:00:00Z", "endDateTime": "2026-05-01T08:00:00Z"},
        {"startDateTime": "2026-05-01T08:00:00Z", "applicability": [period]},
        {"applicability": [{"permanent": "NO"}]},
        {"applicability": [{"permanent": "PERHAPS"}]},
        {"applicability": ["MON"]},
        {"applicability": [{**period, "holidays": True}]},
        {"applicability": [{"schedule": "MON"}]},
        {"applicability": [{"schedule": [daily(["MON"], "08:00", "16:00Z")]}]},
        {"applicability": [{"schedule": [daily(["MONDAY"], "08:00Z", "16:00Z")]}]},
        {"applicability": [{"schedule": [daily([], "08:00Z", "16:00Z")]}]},
        {"limitedApplicability": [{"schedule": [{"day": ["ANY"], "startEvent": "SR", "endEvent": "SS"}]}]},
        {"TimeSpan": [{"when": "2026"}]},
    ):
        with refuses():
            active_times(said, "zones.geojson: feature 1", BEGIN)
    for date in ("2026-11-26", "2026-11-26T10:00", "tomorrow", 5):
        with refuses():
            sky.Reading(date=date)


def scenario_of(folder, *fields, date="2026-11-26T10:00+01:00", **options):
    made = [
        {
            "type": "Feature",
            "properties": {"name": f"z{k}", **one},
            "geometry": {"type": "Polygon", "coordinates": [RING]},
        }
        for k, one in enumerate(fields)
    ]
    (folder / "zones.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": made}))
    notes = []
    ends = {"uavs": [(50.0, 10.0, sky.AboveGround(60))], "targets": [(50.0, 10.01, sky.AboveGround(60))]}
    reading = sky.Reading(date=date)
    scenario = of_maps(
        "z",
        ground=sky.AboveSea(300),
        zones=[folder / "zones.geojson"],
        reading=reading,
        on_note=notes.append,
        **ends,
        **options,
    )
    return scenario, [note.text for note in notes if note.file]


HOUR = {"startDateTime": "2026-11-26T10:00:00Z", "endDateTime": "2026-11-26T11:00:00Z"}


def test_zones_with_times_are_zones_of_the_scenario(tmp_path):
    past, always = {"endDateTime": "2026-11-25T10:00:00Z"}, {"validFrom": "2020-01-01T00:00:00Z"}
    scenario, notes = scenario_of(tmp_path, HOUR, past, always, {"upper": "10 m agl", **HOUR})
    assert [(zone.name, zone.active) for zone in scenario.zones] == [
        ("z0", ((3600.0, 7200.0),)),
        ("z3", ((3600.0, 7200.0),)),
    ]
    assert [shape.name for shape in scenario.obstacles] == ["z2"]
    assert [
        sum(word in note for note in notes) for word in ("active at times", "left out", "active on all of the day")
    ] == [1, 1, 1]
    assert scenario.zones[1].high < scenario.bounds.max[2]
    shut, _ = scenario_of(tmp_path, {"upper": "10 m agl", **HOUR}, zones_closed_above=True)
    assert shut.zones[0].high > shut.bounds.max[2]
    closed, notes = scenario_of(tmp_path, HOUR, date=None)
    assert (len(closed.obstacles), closed.zones) == (1, ())
    assert any("ignored: active at all times" in note for note in notes)


def test_a_file_of_zones_that_are_never_active_leaves_nothing(tmp_path):
    scenario, notes = scenario_of(tmp_path, {"endDateTime": "2026-11-25T10:00:00Z"})
    assert (scenario.obstacles, scenario.zones) == ((), ())
    assert any("left out" in note for note in notes)


def test_the_example_of_the_documentation_runs(tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "maps.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text.split("### Zones with times")[1].split("### ")[0], re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "docs/maps.md", "exec"), {})


def test_flights_cross_a_zone_only_while_the_file_lets_them(tmp_path):
    said = ("2026-11-26T10:00:20+01:00", "2026-11-26T10:01:30+01:00")
    for begin, end in (said, (None, said[1])):
        scenario, _ = scenario_of(tmp_path, {"startDateTime": begin, "endDateTime": end})
        mission = sky.plan_mission(scenario)
        assert sky.check(scenario, mission) == []
        (flight,) = mission.trajectories
        times = np.linspace(flight.start, flight.end, 5000)
        latitude, longitude, _ = sky.to_wgs84(scenario.frame.origin, flight.at(times).position).T
        inside = (np.abs(longitude - 10.005) < 0.001) & (np.abs(latitude - 50.0) < 0.004)
        assert inside.any()
        for second in times[inside].tolist():
            at = BEGIN + timedelta(seconds=second)
            assert at > datetime.fromisoformat(end) or (begin and at < datetime.fromisoformat(begin))
