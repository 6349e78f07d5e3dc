"""Planners of one's own in studies: by name, as objects, edited, refused."""

import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version

import pytest

import skyverse as sky
from own_planner import MODULE
from skyverse.cli import main
from skyverse.lab.code_digest import code_digest, versions
from skyverse.lab.study import Study, read_study, write_study
from skyverse.planners import PLANNER_NAMES, make_planner, name_of


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
    assert "found 2 of others, or made by code that has been edited since" in capsys.readouterr().err


def test_the_digest_follows_the_package_of_a_planner_and_of_its_settings(tmp_path, monkeypatch):
    package = tmp_path / "own_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "search.py").write_text(MODULE)
    (package / "steps.py").write_text("SIZE = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    own, plain = make_planner("own_package.search:Shake"), code_digest(sky.MVO())
    seeded = sky.HybridMVO(seeds=(own,))
    before = [code_digest(own), code_digest(seeded)]
    assert before == [code_digest(replace(own, size=0.3)), code_digest(seeded)]  # settings are told by the planner
    (package / "steps.py").write_text("SIZE = 22\n")
    assert code_digest(own) != before[0]
    assert code_digest(seeded) != before[1]
    assert code_digest(sky.MVO()) == plain != before[0]
    sys.modules.pop("own_package.search")
    sys.modules.pop("own_package")


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
        assert f"{package} {version(package)}" in versions(sky.HybridMVO(seeds=(planner,)))


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("nowhere:Shake", "'nowhere' cannot be imported"),
        ("math:pi", "'math:pi', which is 3.14"),
        ("skyverse:Missing", "which is None"),
        ("skyverse:Scenario", "expected a Planner as module:Class"),
        ("skyverse:Metaheuristic", "expected a Planner as module:Class"),
        (":", "cannot be imported"),
    ],
)
def test_what_is_no_planner_is_refused_by_name(name, says):
    with pytest.raises(sky.InputError, match=says):
        make_planner(name)
    with pytest.raises(ValueError, match=says):
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
