"""Flights on the command line, as files and as pictures."""

import json
import subprocess

import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.draw import animation, flight_scene, instants

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg", reason='pip install "skyverse[flight]"')


@pytest.fixture(scope="module")
def flight():
    flights = straight((0, 0, 2), (0.5, 0, 2), 0.7), straight((0, 2, 2), (0.5, 3, 2), 0.9)
    return sky.fly(mission(*flights, boxes=[((3, -2, 0), (4, 2, 3))]), sky.Conditions(wind=(1, 0, 0)), rng=3)


def test_a_flight_comes_back_from_its_file_as_it_was(flight, tmp_path, refuses):
    sky.write(flight, tmp_path / "flight.json")
    assert sky.read_flight(tmp_path / "flight.json") == flight
    assert sky.read_mission(tmp_path / "flight.json") == flight.mission
    with refuses():
        sky.write(flight, tmp_path / "flight.csv")


def test_what_is_no_flight_is_refused(flight, tmp_path, refuses):
    sky.write(flight.mission, tmp_path / "mission.json")
    with refuses():
        sky.read_flight(tmp_path / "mission.json")
    sky.write(flight, tmp_path / "flight.json")
    data = json.loads((tmp_path / "flight.json").read_text())
    (tmp_path / "wrong.json").write_text(json.dumps(data | {"vehicle": 3}))
    with refuses():
        sky.read_flight(tmp_path / "wrong.json")


def test_a_film_shows_twenty_instants_a_second(flight):
    times, speed = instants(flight_scene(flight))
    assert speed == 1
    assert times == pytest.approx([*np.arange(0, 1.9, 0.05), 1.9])


def test_films_open_elsewhere_and_have_a_frame_for_every_instant(flight, tmp_path, monkeypatch):
    image = pytest.importorskip("PIL.Image")
    times = [0.0, 0.5, 0.9, 1.9]
    monkeypatch.setattr(animation, "instants", lambda drawn: (times, 1))
    sky.write_animation(flight, tmp_path / "film.gif")
    with image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == len(times)
        assert film.info["duration"] == 50
        first = np.asarray(film.convert("RGB"), dtype=int)
        film.seek(film.n_frames - 1)
        last = np.asarray(film.convert("RGB"), dtype=int)
    moved = (np.abs(first - last).max(axis=2) > 60).mean()
    assert 0.0001 < moved < 0.2  # the UAVs moved, the map did not
    sky.write_animation(flight, tmp_path / "film.mp4")
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    told = subprocess.run([ffmpeg, "-i", str(tmp_path / "film.mp4")], capture_output=True, text=True).stderr
    assert f" {first.shape[1]}x{first.shape[0]}" in told
    assert " 20 fps" in told
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([ffmpeg, "-i", str(tmp_path / "film.mp4"), *raw], capture_output=True, check=True)
    shown = np.frombuffer(done.stdout, np.uint8).reshape(-1, *first.shape)
    assert len(shown) == len(times)
    assert np.abs(shown[0].astype(int) - first).mean() < 6


def test_long_flights_are_shown_faster(flight):
    from dataclasses import replace

    drawn = flight_scene(flight)
    longer = replace(drawn, tracks=tuple(replace(track, arrival=100.0) for track in drawn.tracks))
    times, speed = instants(longer)
    assert speed == 10
    assert times[-1] == 100.0
    assert len(times) == 201


def test_the_page_tells_the_verdict_and_shows_planned_and_flown(flight, tmp_path, refuses):
    sky.write_animation(flight, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text()
    assert "This flight is safe." in text
    data = json.loads(text.split('id="mission">')[1].split("</script>")[0])
    assert data["tracks"][0]["positions"][0][-1] == pytest.approx(flight.flown[0].positions[-1, 0], abs=1e-3)
    roles = [trace["meta"]["role"] for trace in data["space"]]
    assert roles.count("path") == roles.count("trajectory") == 2
    worst = max(y for trace in data["search"] for y in trace["y"])
    assert worst == pytest.approx(flight.largest, rel=0.1)
    with refuses():
        sky.write_animation(flight, tmp_path / "page.avi")


def test_figures_have_known_suffixes(flight, tmp_path, refuses):
    with refuses(ValueError):
        sky.write_instants(flight, tmp_path, suffix="jpg")
