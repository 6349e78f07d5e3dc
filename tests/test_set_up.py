"""``run.py`` installs the package editable, and notices where something else has put a copy in its place."""

import importlib.util
import sys
import sysconfig
from pathlib import Path

import pytest


@pytest.fixture
def run(tmp_path, monkeypatch):
    """The module ``run.py`` with an empty environment, and the commands that it would have run."""
    spec = importlib.util.spec_from_file_location("run_to_set_up", Path(__file__).parents[1] / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.calls = []
    monkeypatch.setattr(module, "call", lambda *words: module.calls.append(words))
    monkeypatch.setattr(module, "VENV", tmp_path)
    monkeypatch.setattr(module, "PYTHON", Path(sys.executable))
    return module


def test_a_copy_is_replaced_by_an_editable_install_in_one_line_and_all_else_stays(run, tmp_path, capsys):
    run.set_up("run")
    assert [words[2] for words in run.calls] == ["venv", "pip", "pip"]
    run.calls.clear()
    run.set_up("run")
    assert run.calls == []
    (Path(sysconfig.get_path("purelib", "venv", {"base": str(tmp_path)})) / "skyverse").mkdir(parents=True)
    capsys.readouterr()
    run.set_up("run")
    ((*_, no_others, _, editable, _),) = run.calls
    assert (no_others, editable) == ("--no-deps", "--editable")
    assert capsys.readouterr().out == f"{run.COPIED}\n"
