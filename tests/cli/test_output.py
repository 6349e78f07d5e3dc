"""What the verbs print, wherever it is printed: whole, in any encoding, and without a word to the terminal itself."""

import json
import re
import sys

import pytest

import skyverse as sky
from skyverse import cli
from terminals import on_a_terminal

NAMED = "Ż°\udcff \x1b[2J[/red]\u202e"
"""A name that needs more than ASCII, clears a terminal, looks like rich's markup and turns what stands behind it."""
FILE = "Ż°"
JUDGED = ("--ground", "400 m amsl", "--vehicle", "camera")
FLOWN = ("plan", f"{FILE}.yaml", "--planner", "astar", "--no-page", "-o", f"{FILE}-2.json")
COMMANDS = [
    (),
    ("--help",),
    ("--version",),
    *((*verb, "--help") for verb in (("plan",), ("survey",), ("compare",), ("live",), ("scenario", "build"))),
    ("scenarios",),
    ("scenarios", f"{FILE}.yaml", "--json"),
    ("scenarios", "none"),
    FLOWN,
    (*FLOWN, "--json"),
    ("plan", f"{FILE}.none"),
    ("check", f"{FILE}.json"),
    ("check", f"{FILE}.plan", *JUDGED),
    ("repair", f"{FILE}.plan", "-o", f"{FILE}-2.plan", *JUDGED),
    ("show", f"{FILE}.json"),
    ("export", f"{FILE}.json", f"{FILE}-3.plan", "--altitude", "home"),
    ("fly", f"{FILE}.json"),
    ("live", "--schema"),
    ("compare", f"{FILE}.yaml", "--planner", "astar", "--no-report"),
    ("scenario", "build", "--zones", f"{FILE}.geojson", "-o", f"{FILE}-2.yaml"),
    ("cache",),
]
COMMANDED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]")
STYLED = re.compile(r"\x1b\[(?:[01]m|\?25[lh]|1A|2K)|\r")
"""What rich itself sends to a terminal without colours."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a small scenario, its mission, that as a file for PX4, and a zone."""
    folder = tmp_path_factory.mktemp("output")
    scenario = sky.Scenario(
        name=NAMED.replace("\udcff", ""),
        bounds=sky.Bounds(min=(0, 0, 0), max=(8, 4, 4)),
        obstacles=[sky.Box(min=(3, 0, 0), max=(4, 2, 4), name="wall")],
        clearance=0.25,
        uavs=[sky.UAV(start=(1, 1, 2), name=NAMED.replace("\udcff", ""))],
        targets=[sky.Target(position=(6, 1, 2))],
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5)),
        frame=sky.Frame(origin=sky.Origin(latitude=46, longitude=8, altitude=400)),
    )
    sky.write(scenario, folder / f"{FILE}.yaml")
    mission = sky.plan_mission(scenario, sky.AStar())
    sky.write(mission, folder / f"{FILE}.json")
    sky.export(mission, folder / f"{FILE}.plan", sky.ExportOptions(altitude="home"))
    corners = [[8, 46], [8.001, 46], [8.001, 46.001], [8, 46]]
    zone = {"type": "Feature", "properties": {"name": NAMED}, "geometry": {"type": "Polygon", "coordinates": [corners]}}
    (folder / f"{FILE}.geojson").write_text(json.dumps(zone))
    return folder


def code_of(words):
    """Return the exit code of a command line."""
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    return ended.value.code or 0


def words_of(said):
    """Return the words that were said but times, which differ from run to run."""
    return {*re.sub(r"\d[\d:.,]* ?m?s?\b", "", said).split()}


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_verb_says_the_same_on_a_narrow_terminal_without_unicode(words, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    code = code_of(words)
    said = capsys.readouterr()
    assert code in (0, 1, 2)
    assert not COMMANDED.search(said.out + said.err)
    with on_a_terminal(60, "ascii") as terminal:
        assert code_of(words) == code
    sent = STYLED.sub("", terminal.sent)
    assert not COMMANDED.search(sent)
    if "--help" not in words:  # which is laid out by the width
        assert words_of(said.out.encode("ascii", "backslashreplace").decode()) <= words_of(sent)


@pytest.mark.parametrize("words", [(), ("scenarios",), ("check", f"{FILE}.json"), ("plan", "none")], ids=" ".join)
def test_a_closed_output_changes_no_exit_code(words, folder, monkeypatch):
    monkeypatch.chdir(folder)
    code = code_of(words)
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    assert code_of(words) == code


def test_messages_on_a_closed_input_are_refused(folder, refused, monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    refused("live", folder / f"{FILE}.json")
