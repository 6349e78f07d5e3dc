"""Without an extra, whatever needs it ends in one sentence with the line that installs it, and all else works."""

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import skyverse as sky
from skyverse import extras
from skyverse.extras import EXTRAS, missing_at_once, require_libraries

ROOT = Path(__file__).parents[2]
MAPS, OPTIMISERS, FLIGHT, PARQUET, DASK, TOURS = "maps", "optimisers", "flight", "parquet", "dask", "tours"
DEM = "--terrain dem.asc --terrain-crs EPSG:4326"
STUDY = "--iterations 2 --runs 2 --workers 1 --no-report"
SEEN = "--camera mavic-3e --gsd '6 cm' --no-page"
VERBS = ("plan", "survey", "check", "repair", "show", "export", "fly", "live", "compare", "reproduce", "cache")
COMMANDS = {
    **{f"{verb} --help": () for verb in (*VERBS, "scenarios", "scenario build")},
    "": (),
    "--help": (),
    "scenarios --schema": (),
    "scenarios map1 -o mine.yaml": (),
    "cache --json": (),
    "plan room.yaml --seed 1 -o m.json": (),
    "plan round.yaml --no-page -o round.json": (TOURS,),
    "plan room.yaml --planner astar --seed 1 --no-page -o a.json": (),
    "plan room.yaml --planner mfo --iterations 20 --seed 1 --no-page -o c.json": (),
    "plan room.yaml --planner cma-es --iterations 9 --no-page -o c.json": (OPTIMISERS,),
    "plan room.yaml --planner de --iterations 9 --no-page -o c.json": (OPTIMISERS,),
    "plan room.yaml --planner gwo --iterations 9 --no-page -o c.json": (OPTIMISERS,),
    "check m.json": (),
    "check m.json --scenario room.yaml": (),
    "show m.json": (),
    "export m.json m.plan --altitude home": (),
    "export m.json m.wpml.kmz --altitude home": (),
    "export m.json m.kml": (),
    "export m.json m.csv": (),
    "export m.json m.geojson --geoid 50": (),
    "check m.plan": (MAPS,),
    f"check m.plan {DEM} --zones field.geojson": (MAPS,),
    "repair m.plan --ground '0 m amsl' -o fixed.plan": (MAPS,),
    f"repair m.plan {DEM} -o fixed.plan": (MAPS,),
    f"survey field.geojson --ground '1500 m amsl' {SEEN} -o s.json": (MAPS,),
    f"survey field.geojson {DEM} {SEEN} -o s.json": (MAPS,),
    f"scenario build {DEM} --uav '46.801,9.851,60 m agl' --target '46.802,9.852,60 m agl' -o b.yaml": (MAPS,),
    "fly m.json --runs 2 --seed 1": (),
    "fly m.json": (FLIGHT,),
    "fly m.json --vehicle hummingbird": (FLIGHT,),
    "fly m.json --animation f.mp4": (FLIGHT,),
    f"compare map1 --planner random-restart {STUDY} -o c --export rows.csv": (),
    f"compare map1 --planner random-restart {STUDY} -o p --export rows.parquet": (PARQUET,),
    f"compare map1 --planner cma-es --planner de --planner woa {STUDY} -o d": (OPTIMISERS,),
    f"compare map1 --planner random-restart {STUDY} -o e --dask none": (DASK,),
    f"compare map1 --planner de {STUDY} -o f --dask none --export r.parquet": (OPTIMISERS, PARQUET, DASK),
}
"""Command lines, and the extras that they need."""
RUN = """
import contextlib, io, json, sys
blocked, lines = json.load(sys.stdin)
sys.modules.update(dict.fromkeys(blocked))
from skyverse.cli import main
told = []
for words in lines:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as err:
        try:
            main(words)
        except SystemExit as ended:
            code = ended.code or 0
        except Exception as error:
            code = repr(error)
    told.append((code, err.getvalue()))
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a field, heights, a scenario, and one of twelve targets."""
    folder = tmp_path_factory.mktemp("given")
    corners = [[9.850, 46.800], [9.853, 46.800], [9.853, 46.803], [9.850, 46.803], [9.850, 46.800]]
    field = {"type": "Polygon", "coordinates": [corners]}
    (folder / "field.geojson").write_text(json.dumps(field))
    head = "ncols 40\nnrows 40\nxllcorner 9.845\nyllcorner 46.795\ncellsize 0.0005\n"
    (folder / "dem.asc").write_text(head + 40 * (40 * " 1500" + "\n"))
    room = sky.Scenario(
        name="room",
        frame=sky.Frame(origin=sky.Origin(latitude=46.8, longitude=9.85, altitude=0)),
        bounds=sky.Bounds(min=(0, 0, 0), max=(60, 40, 20)),
        obstacles=(sky.Box(min=(20, 0, 0), max=(24, 30, 20)),),
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5)),
        uavs=(sky.UAV(start=(5, 5, 5)),),
        targets=(sky.Target(position=(50, 20, 5)),),
    )
    sky.write(room, folder / "room.yaml")
    targets = tuple(sky.Target(position=(30 + 4 * k % 28, 5 + 2 * k, 5)) for k in range(12))
    sky.write(room.model_copy(update={"targets": targets}), folder / "round.yaml")
    return folder


def test_without_extras_what_needs_them_names_them_and_all_else_works(folder):
    missing = [module for modules in EXTRAS.values() for module in modules]
    run = subprocess.run(
        [sys.executable, "-c", RUN],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        input=json.dumps([missing, [*map(shlex.split, COMMANDS)]]),
        capture_output=True,
        text=True,
        check=True,
    )
    for (line, needs), (code, said) in zip(COMMANDS.items(), json.loads(run.stdout), strict=True):
        refusal = rf'skyverse: .* needs? .*, not installed here: \S*pip install .*\[{",".join(needs)}\]"\n'
        assert (code, bool(re.fullmatch(refusal, said))) == ((2, True) if needs else (0, False)), (line, said)


def test_extras_are_those_of_the_package_and_all_stands_for_each():
    named = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for extra, modules in EXTRAS.items():
        given = re.sub(r"[-_.]", "", " ".join(named[extra]).lower())
        assert all(module.replace("_", "") in given for module in modules)
    (whole,) = named["all"]
    run_time = {*named} - {"all", "test", "lint", "docs", "bench"}
    assert {*re.fullmatch(r"skyverse\[(.*)\]", whole)[1].split(",")} == run_time >= {*EXTRAS}


def test_all_that_is_missing_is_named_at_once(monkeypatch, refuses):
    for name in ("cma", "pymoo", "pyarrow"):
        monkeypatch.setitem(sys.modules, name, None)
    with refuses(), missing_at_once():
        require_libraries("CMAES", "cma")
        require_libraries("DE", "pymoo")
        require_libraries("rows.parquet", "pyarrow")
    with refuses(), missing_at_once():
        import cma  # noqa: F401
    with pytest.raises(ModuleNotFoundError), missing_at_once():
        import no_such_module  # noqa: F401
    with pytest.raises(sky.InputError, match="another"), missing_at_once():
        raise sky.InputError("another fault")


def test_a_public_name_that_needs_an_extra_says_so():
    code = "import sys; sys.modules['pyproj'] = None\nimport skyverse as sky\ntry: sky.read_area\n"
    code += "except sky.InputError as error: print(error)"
    told = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert "pyproj" in told.stdout


@pytest.mark.parametrize("place", ["clone", "elsewhere"])
@pytest.mark.parametrize("made", ["in it", "by the user"])
def test_in_a_clone_the_line_installs_into_it_and_elsewhere_the_package(tmp_path, monkeypatch, place, made):
    clone = tmp_path / "clone"
    (clone / "src" / "skyverse").mkdir(parents=True)
    (clone / "run.py").touch()
    environment = clone / ".venv" if made == "in it" else tmp_path / "own"
    monkeypatch.setattr(sys, "prefix", str(environment))
    monkeypatch.setattr(extras, "_HERE", clone / "src" / "skyverse" / "extras.py")
    pip = Path("bin" if os.name == "posix" else "Scripts") / "pip"
    monkeypatch.chdir(clone if place == "clone" else tmp_path)
    near = {"in it": Path(".venv") / pip, "by the user": environment / pip}[made]
    at = {"clone": f'{near} install -e ".[maps,tours]"',
          "elsewhere": f'{environment / pip} install -e "{clone}[maps,tours]"'}  # fmt: skip
    assert extras.install_line(["maps", "tours"]) == at[place]
    monkeypatch.setattr(extras, "_HERE", tmp_path / "site" / "a" / "skyverse" / "extras.py")
    if made == "by the user":
        assert extras.install_line(["maps", "tours"]) == 'pip install "skyverse[maps,tours]"'
    else:
        assert extras.install_line(["maps", "tours"]) == at[place]  # a copy that was installed into the clone's own
