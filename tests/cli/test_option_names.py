"""Parameters of the library, and the options that stand for them on the command line."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import skyverse
import skyverse as sky
from skyverse.cli import app
from skyverse.cli.option_names import OPTIONS, PLACEHOLDERS, for_command_line, option_of, running
from skyverse.errors import InputError, Remedy, Sentence

HERE = Path(__file__).parent
ROOT = Path(skyverse.__file__).parent
LIBRARY = [path for path in sorted(ROOT.rglob("*.py")) if "cli" not in path.relative_to(ROOT).parts]


def options(verbs=app):
    """Return the names of all options of all verbs."""
    found = (
        {name for one in verbs.assemble_argument_collection() for name in one.names} if verbs.default_command else set()
    )
    return found.union(*(options(verbs[name]) for name in verbs if not name.startswith("-")))


def fields():
    """Return the parameters that errors and notes of the library name."""
    found = set()
    for path in LIBRARY:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "field" and isinstance(node.value, ast.Constant):
                found |= {node.value.value} - {None}
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Remedy":
                found.add(node.args[0].value)
    return found


def test_every_parameter_that_a_message_names_has_an_option():
    known = options()
    named = fields() | set(OPTIONS) | set(PLACEHOLDERS)
    assert {"ceiling", "Raster.nodata", "allow_close"} <= named
    # no verb gives the readers of voxels a size, a track's gap stands in its scenario, no verb makes a Replanner, and
    # none begins a search with a population
    without = {"size", "gap", "candidates", "deadline_ms", "mission", "states", "t", "legs", "population"}
    without |= {"departs", "kind", "objective", "on_note", "path", "policy", "problem", "room", "stop", "suffix"}
    without |= {"vehicles", "window", "line", "strips", "free", "photos", "position_error"}  # of Python alone
    assert {field for field in named if option_of(field) not in known} <= without


@pytest.mark.parametrize("verb", ["plan", "check", "show", "export", "live", "scenario build"])
def test_an_option_of_another_verb_stands_behind_that_verb(verb):
    public = {line.partition(":")[0] for line in (HERE.parent / "public_options.txt").read_text().splitlines()}
    with running(app, [*verb.split(), "x"]):
        told = {field: for_command_line(Sentence("no", give=[Remedy(field)])) for field in fields()}
    for field, said in told.items():
        option = option_of(field)
        before = said.removeprefix("no; give ").partition(option)[0].strip()
        if any(f"{one} {option}" in public for one in (verb, "plan", "scenario build")):
            assert f"{before or verb} {option}" in public, said
    own = verb in ("check", "scenario build")
    assert told["Raster.unit"] == f"no; give {'' if own else 'scenario build '}--terrain-unit UNIT"
    assert told["max_height"].startswith("no; give --max" if own or verb == "plan" else "no; give plan --")


def test_a_plan_names_the_options_with_which_the_scenario_is_built(skyverse, tmp_path):
    ground = sky.Terrain(origin=(0, 0), step=(10, 10), heights=np.zeros((3, 3)))
    scenario = sky.Scenario(
        name="shut",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 10)),
        obstacles=[sky.Box(min=(9, 0, 0), max=(11, 20, 10))],
        terrain=ground,
        clearance=1,
        uavs=[sky.UAV(start=(3, 10, 5))],
        targets=[sky.Target(position=(17, 10, 5))],
    )
    sky.write(scenario, tmp_path / "shut.yaml")
    code, out, _ = skyverse("plan", "shut.yaml", "--no-page", "-o", "shut.json")
    assert code == 1
    given = set(re.findall(r"(\S+ \S+) (--(?:margin|ceiling|clearance))", out))
    assert given == {("scenario build", "--margin"), ("scenario build", "--ceiling")}


def test_the_library_does_not_speak_of_options():
    option = re.compile(r"(?<![\w-])--[a-z]{2,}")
    spoken = [
        f"{path.relative_to(ROOT)}: {node.value!r:.80}"
        for path in LIBRARY
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and option.search(node.value)
    ]
    # the command that a report of the reproduction was made by, and a variable of a style sheet
    assert [line for line in spoken if not line.startswith(("reproduction/", "draw/"))] == []


@pytest.mark.parametrize(
    ("sentence", "in_python", "on_the_command_line"),
    [
        (Sentence("found home", field="ceiling"), "ceiling: found home", "--ceiling: found home"),
        (
            Sentence("a.las: no system", give=[Remedy("Reading.crs", "EPSG:4326")]),
            "a.las: no system; give Reading(crs='EPSG:4326')",
            "a.las: no system; give --crs EPSG:4326",
        ),
        (
            Sentence("no ground", give=[Remedy("terrain"), Remedy("ground")]),
            "no ground; give terrain or ground",
            "no ground; give --terrain FILE or --ground '0 m amsl'",
        ),
        (
            Sentence("holds -9999", give=[Remedy("Raster.nodata", -9999.0, "if it stands for no data")]),
            "holds -9999; give Raster(nodata=-9999) if it stands for no data",
            "holds -9999; give --nodata -9999 if it stands for no data",
        ),
        (
            Sentence("too close", give=[Remedy("allow_close", True)]),
            "too close; give allow_close=True",
            "too close; give --allow-close",
        ),
        (Sentence("a sentence"), "a sentence", "a sentence"),
    ],
)
def test_a_sentence_names_parameters_in_python_and_options_on_the_command_line(
    sentence, in_python, on_the_command_line
):
    assert str(sentence) == str(InputError(sentence)) == in_python
    assert for_command_line(sentence) == for_command_line(InputError(sentence)) == on_the_command_line


def test_an_error_keeps_its_parameters_on_its_way_to_another_process():
    import pickle

    error = InputError("found home", field="ceiling", give=[Remedy("ground")])
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)
    assert for_command_line(again) == "--ceiling: found home; give --ground '0 m amsl'"


def test_every_option_of_scenario_build_has_the_documentation_of_its_parameter():
    build = app["scenario"]["build"]
    helped = [one.names[0] for one in build.assemble_argument_collection() if one.parameter.help]
    assert len(helped) == 50
