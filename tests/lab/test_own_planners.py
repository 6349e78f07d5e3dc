"""Planners of one's own in studies: by name, as objects, edited, refused."""

import importlib
import os
import pickle
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from own_planner import MODULE
from skyverse.cli import main
from skyverse.cli.study import StudyOptions, study_of
from skyverse.lab import (
    Rows,
    RunMaker,
    Study,
    code_digest,
    plan_job,
    read_study,
    refuse_edited,
    run_jobs,
    settings_of,
    versions,
    write_study,
)
from skyverse.planners import PLANNER_NAMES, make_planner, name_of
from studies import job


@pytest.fixture
def shake(tmp_path, monkeypatch):
    """A module of its own name for each test, beside which a study can stand."""
    name = f"shake_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield name
    sys.modules.pop(name, None)


def code(command):
    """The exit code of a command."""
    with pytest.raises(SystemExit) as ended:
        main(command)
    return ended.value.code


def test_a_class_is_found_by_its_module_and_an_object_says_the_same(shake, tmp_path):
    own = make_planner(f"{shake}:Shake", size=0.1, waypoints=2)
    assert name_of(own) == f"{shake}:Shake"
    by_name = [f"{shake}:Shake", {"planner": f"{shake}:Shake", "size": 0.1, "waypoints": 2}, "mvo"]
    study = Study(scenarios=["map1"], planners=by_name, seeds=1)
    assert [one.label for one in study.planners] == ["Shake", "Shake size=0.1 waypoints=2", "mvo"]
    said = Study(scenarios=["map1"], planners=[type(own)(), own, sky.MVO()], seeds=1)
    assert [one.make() for one in said.planners] == [one.make() for one in study.planners]
    write_study(said, tmp_path / "study.yaml")
    assert [one.make() for one in read_study(tmp_path / "study.yaml").planners] == [type(own)(), own, sky.MVO()]


def test_every_planner_is_found_by_its_name():
    for name in PLANNER_NAMES:
        with suppress(sky.InputError):  # a package is not installed
            assert name_of(make_planner(name)) == name


def test_edited_code_is_not_taken_for_done(shake, tmp_path, capsys):
    study = f"name: own\nscenarios: [map1]\nplanners: ['{shake}:Shake', mvo]\nseeds: 2\nbudget: {{paths: 60}}\n"
    (tmp_path / "s.yaml").write_text(study)
    command = ["compare", str(tmp_path / "s.yaml"), "-o", str(tmp_path / "out"), "--workers", "1", "--no-report"]
    assert code(command) == 0
    assert code(command) == 0  # nothing is to be done
    file = tmp_path / f"{shake}.py"
    file.write_text(MODULE.replace("<= fitness", "< fitness"))
    capsys.readouterr()
    assert code(command) == 2
    assert "as they were imported, found one edited" in capsys.readouterr().err  # this process has the old code
    sys.modules.pop(shake)
    assert code(command) == 2
    assert "found 2 of others, or made by code that has been edited since" in capsys.readouterr().err


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package with a planner, beside it a module that it imports, and one that it does not."""
    folder = tmp_path / "own_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "search.py").write_text(f"import beside_it\n{MODULE}")
    (folder / "steps.py").write_text("SIZE = 1\n")
    (tmp_path / "beside_it.py").write_text("import further\n\n\ndef price(x):\n    return x\n")
    (tmp_path / "further.py").write_text("SIZE = 1\n")
    (tmp_path / "other.py").write_text("SIZE = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    _forget()


def _forget():
    """Let the package be imported anew."""
    for name in ("own_package.search", "own_package", "beside_it", "further"):
        sys.modules.pop(name, None)
    importlib.invalidate_caches()


def _digest():
    return code_digest(make_planner("own_package.search:Shake"))


@pytest.mark.parametrize("file", ["own_package/steps.py", "own_package/search.py", "beside_it.py", "further.py"])
def test_the_digest_is_of_all_that_was_imported_and_an_edit_is_refused(package, file, refuses):
    own = make_planner("own_package.search:Shake")
    before, plain = _digest(), code_digest(sky.MVO())
    refuse_edited(own)
    with (package / file).open("a") as written:
        written.write("# edited\n")
    assert _digest() == before  # as it is imported
    with refuses():
        refuse_edited(own)
    with refuses():
        run_jobs([job(own)], Rows(":memory:"))
    _forget()
    assert _digest() != before
    assert code_digest(sky.MVO()) == plain != before


def test_every_process_finds_the_same_digest(tmp_path):
    helpers = [f"helper_{k}" for k in range(6)]
    for helper in helpers:
        (tmp_path / f"{helper}.py").write_text(f"NAME = {helper!r}")
    (tmp_path / "own.py").write_text("".join(f"import {helper}\n" for helper in helpers) + MODULE)
    said = "from skyverse.lab import code_digest; import own; print(code_digest(own.Shake()))"
    found = set()
    for seed in ("1", "2", "3"):  # the order of sets of texts follows it
        environment = os.environ | {"PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", said]
        found.add(subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True).stdout)
    assert len(found) == 1


def test_what_is_not_imported_does_not_count(package):
    before = _digest()
    (package / "other.py").write_text("SIZE = 2\n")
    _forget()
    assert _digest() == before


def test_the_digest_follows_the_planners_in_settings(package):
    own = make_planner("own_package.search:Shake")
    assert code_digest(own) == code_digest(replace(own, size=0.3))  # settings are told by the planner
    for held in ((own,), [own], {"one": own}, ([{"one": (own,)}],)):
        assert code_digest(held) == code_digest(own)


def test_versions_of_packages_count(package, monkeypatch):
    before = _digest()
    for name in ("numba", "scipy"):
        with monkeypatch.context() as patched:
            patched.setattr(f"{name}.__version__", "other")
            assert _digest() not in (before, code_digest(sky.MVO()))


def test_a_worker_with_other_code_refuses_the_run(package, refuses):
    here = job(make_planner("own_package.search:Shake"), stop=sky.MaxPaths(60))
    assert RunMaker().row_of(here).success is not None
    sent = replace(here)
    vars(sent)["code"] = "of another process"
    with refuses():
        RunMaker().row_of(pickle.loads(pickle.dumps(sent)))


def test_keys_of_one_planner_cost_no_reading(package, monkeypatch):
    wanted = [job(make_planner("own_package.search:Shake"), seed) for seed in range(20)]
    first = wanted[0].key
    monkeypatch.setattr(Path, "read_bytes", None)
    assert len({first, *(each.key for each in wanted)}) == 20


QUIET = """
from dataclasses import dataclass, field
from typing import Any

import skyverse as sky


@dataclass(frozen=True, kw_only=True)
class Quiet(sky.MVO):
    size: Any = field(default=0.2, repr=False)


def move(x):
    return x
"""


@pytest.fixture
def quiet(tmp_path, monkeypatch):
    """The class of a planner with a setting that its words omit."""
    name = f"quiet_{tmp_path.name}"[:60]
    (tmp_path / f"{name}.py").write_text(QUIET)
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module(name).Quiet
    sys.modules.pop(name, None)


def test_every_setting_counts_and_is_told_also_one_that_the_repr_omits(quiet):
    move = sys.modules[quiet.__module__].move
    values = (0.2, 0.001, "0.2", (0.2,), [0.2], {"a": 0.2}, None, move, sky.MVO, sky.MVO(universes=3), quiet(size=3))
    planners = [quiet(size=value) for value in values]
    assert len({job(planner).key for planner in planners}) == len(values)
    assert "size=0.001" in plan_job(job(quiet(size=0.001))).settings
    assert settings_of(quiet(size=move)) == settings_of(quiet(size=move))


@pytest.mark.parametrize("value", [lambda x: x, np.zeros(3), object(), [np.zeros(3)], {"a": lambda x: x}])
def test_settings_that_no_other_process_finds_again_are_refused(quiet, value):
    name = f"{quiet.__module__}:Quiet"
    for said in (quiet(size=value), {"planner": name, "size": value, "label": "q"}):
        with pytest.raises(ValueError, match="expected settings that are numbers"):
            Study(scenarios=["map1"], planners=[said])


def test_a_class_of_the_script_itself_is_not_written_into_a_file(quiet, tmp_path, monkeypatch, refuses):
    monkeypatch.setattr(quiet, "__module__", "__main__")
    monkeypatch.setattr(sys.modules["__main__"], "Quiet", quiet, raising=False)
    monkeypatch.setattr(sys.modules["__main__"], "__file__", __file__, raising=False)  # also in a worker of pytest
    study = Study(scenarios=["map1"], planners=[quiet()], seeds=1)
    with refuses():
        write_study(study, tmp_path / "study.yaml")
    assert not (tmp_path / "study.yaml").exists()


def test_a_planner_that_is_refused_as_an_option_is_told_where_it_can_stand(capsys):
    assert code(["compare", "map1", "--planner", "nowhere:Shake"]) == 2
    assert "study file" in capsys.readouterr().err


@pytest.mark.parametrize("called_in", [".", "sub"])
def test_a_study_finds_the_module_beside_it_wherever_it_is_called(tmp_path, monkeypatch, called_in):
    (tmp_path / "sub").mkdir()
    (tmp_path / "whose.py").write_text(QUIET.replace("0.2", "1"))
    (tmp_path / "sub" / "whose.py").write_text(QUIET.replace("0.2", "2"))
    (tmp_path / "sub" / "s.yaml").write_text("scenarios: [map1]\nplanners: ['whose:Quiet']\n")
    monkeypatch.chdir(tmp_path / called_in)
    for front in ([], [""], [str(tmp_path / called_in)]):  # as the command and python -m have it
        monkeypatch.setattr(sys, "path", front + sys.path)
        study = study_of([os.path.relpath(tmp_path / "sub" / "s.yaml")], StudyOptions())
        assert study.planners[0].make().size == 2
        sys.modules.pop("whose")


def test_versions_name_the_packages_and_the_module(shake):
    own = make_planner(f"{shake}:Shake")
    assert f"{shake} (" in versions(own)
    pytest.importorskip("cma", reason="needs skyverse[optimisers]")
    assert "cma" not in versions(sky.MVO())
    for planner, package in ((sky.CMAES(), "cma"), (sky.DE(), "pymoo"), (sky.LSHADE(), "niapy")):
        told = versions(planner)
        for each in (package, "scipy", "numba"):
            assert f"{each} {version(each)}" in told
        assert f"{datetime.now(UTC):%Y-%m-%d}" in told
        assert f"{package} {version(package)}" in versions((planner,))


@pytest.mark.parametrize(
    "name",
    ["nowhere:Shake", "math:pi", "skyverse:Missing", "skyverse:Scenario", "skyverse:Metaheuristic", ":"],
)
def test_what_is_no_planner_is_refused_by_name(name, refuses):
    with refuses():
        make_planner(name)
    with pytest.raises(ValueError, match="planners"):
        Study(scenarios=["map1"], planners=[name])


def test_a_planner_that_its_settings_do_not_make_anew_is_refused():
    class Local(sky.AStar):
        pass

    @dataclass(frozen=True)
    class Nameless(sky.MVO):
        size: int = 3

    for planner in (Local(), Nameless()):
        with pytest.raises(ValueError, match="expected a Planner as module:Class"):
            Study(scenarios=["map1"], planners=[planner])
