"""What the shell completes when TAB is pressed, asked of bash itself where there is one."""

import shutil
import subprocess
import sys

import pytest
from cyclopts.completion import ShellDetectionError

from skyverse.cli import app
from skyverse.files import BUILTIN_NAMES
from skyverse.planners import PLANNER_NAMES

BASH = shutil.which("bash")
VERBS = ("plan", "check", "show", "export", "fly", "compare", "reproduce", "scenarios", "scenario", "cache")


@pytest.fixture
def shell(tmp_path, monkeypatch):
    """Return a function that types words into bash, presses TAB, and returns what bash proposes."""
    if BASH is None:
        pytest.skip("no bash to press TAB in")
    script = tmp_path / "completion.bash"
    script.write_text(app.generate_completion(prog_name="skyverse", shell="bash"), encoding="utf-8")
    program = tmp_path / "bin" / "skyverse"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m skyverse "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)

    def press_tab(*words):
        line = f"""
            PATH="{program.parent}:$PATH"
            source "{script}"
            COMP_WORDS=(skyverse "$@")
            COMP_CWORD=$#
            _skyverse
            printf '%s\\n' "${{COMPREPLY[@]}}"
        """
        said = subprocess.run([BASH, "-c", line, "bash", *words], capture_output=True, text=True, check=True)
        assert said.stderr == ""
        return said.stdout.split()

    return press_tab


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell_knows_verbs_options_and_planners(name):
    script = app.generate_completion(prog_name="skyverse", shell=name)
    for word in (*VERBS, *PLANNER_NAMES, "minimum-snap", "apart-in-space", "__complete"):
        assert word in script


def test_verbs_options_and_planners_are_completed(shell):
    assert set(shell("")) >= set(VERBS)
    assert shell("pl") == ["plan"]
    assert shell("plan", "--planner", "m") == ["mvo", "mfo"]
    assert shell("plan", "map1", "--sh") == ["--shape"]
    assert shell("compare", "map1", "--planner", "gso", "--planner", "l") == ["l-shade"]


def test_scenarios_and_files_are_completed(shell, tmp_path):
    assert set(shell("plan", "")) == set(BUILTIN_NAMES)
    for file in ("mapped.yaml", "out/fleet.json", "out/other.json", ".hidden"):
        path = tmp_path / "here" / file
        path.parent.mkdir(exist_ok=True)
        path.touch()
    assert shell("plan", "map") == ["map1", "map2", "map3", "mapped.yaml"]
    assert shell("check", "") == ["mapped.yaml", "out/"]
    assert shell("check", "o") == ["out/", "out/fleet.json", "out/other.json"]
    assert shell("check", "out/f") == ["out/fleet.json"]
    assert shell("check", "out/fleet.json", "--scenario", "j") == ["jacksboro"]
    assert shell("check", "nowhere/") == []


def test_the_script_is_installed_where_the_shell_looks_for_it(skyverse, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    code, out, err = skyverse("--install-completion", "--shell", "bash")
    script = tmp_path / ".local" / "share" / "bash-completion" / "completions" / "skyverse"
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == str(script)
    assert "complete -F _skyverse skyverse" in script.read_text(encoding="utf-8")
    assert str(script) in (tmp_path / ".bashrc").read_text(encoding="utf-8")


def test_a_shell_that_is_not_known_is_bad_input(skyverse, monkeypatch):
    def lost():
        raise ShellDetectionError

    monkeypatch.setattr("cyclopts.completion.detect.detect_shell", lost)
    expected = "skyverse: --shell: expected bash, zsh, fish or powershell, as this shell is not known\n"
    assert skyverse("--install-completion") == (2, "", expected)
    code, _, err = skyverse("--install-completion", "--shell", "tcsh")
    assert code == 2
    assert 'Invalid value "tcsh" for --shell' in err
