"""What README and docs say of the code is what the code is."""

import doctest
import importlib
import io
import re
import shlex
import tomllib
from pathlib import Path

import pytest

import skyverse
from skyverse.cli import main

ROOT = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CONTRIBUTING = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")


def blocks(page):
    """Return the language, python, pycon or console, and the text of each block of a page that may be run."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(r"^```(python|pycon|console)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def run_session(page, text, names):
    """Run a session at the prompt, and require that it prints what stands there."""
    test = doctest.DocTestParser().get_doctest(text, names, page, page, 0)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS, verbose=False)
    said = io.StringIO()
    runner.run(test, out=said.write, clear_globs=False)
    assert runner.summarize(verbose=False).failed == 0, said.getvalue()
    names.update(test.globs)


def run_command(text, capsys):
    """Run a command of the shell below which its output stands, and require that it prints that; dots stand for any."""
    command, _, said = text.partition("\n")
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(shlex.split(command.removeprefix("$ skyverse ")))
    printed = "".join(f"{line.rstrip()}\n" for line in capsys.readouterr().out.splitlines())
    if said.startswith("...\n"):
        assert doctest.OutputChecker().check_output(said, printed, doctest.ELLIPSIS), printed
    else:
        assert printed.splitlines() == said.splitlines()


def test_the_layers_that_are_drawn_are_the_contract():
    contract = next(c for c in PYPROJECT["tool"]["importlinter"]["contracts"] if c["name"] == "data flows one way")
    drawn = re.search(r"^```text\n(cli\n.*?)^```", CONTRIBUTING, re.MULTILINE | re.DOTALL)
    assert drawn is not None
    assert drawn[1].splitlines() == [layer.replace("skyverse.", "") for layer in contract["layers"]]


def test_every_package_is_explained():
    packages = {folder.name for folder in Path(skyverse.__file__).parent.iterdir() if (folder / "__init__.py").exists()}
    assert set(re.findall(r"^\| `(\w+)` \|", CONTRIBUTING, re.MULTILINE)) == packages


def test_every_file_on_the_way_of_a_scenario_is_there():
    way = CONTRIBUTING.split("## The way of a scenario")[1].split("\n## ")[0]
    files = re.findall(r"`((?:\w+/)*\w+\.py|\w+/(?:\w+/)*)`", way)
    assert len(files) > 15
    assert [file for file in files if not (Path(skyverse.__file__).parent / file).exists()] == []


def test_the_glossary_has_sixty_nouns_at_most_and_each_class_is_where_it_says():
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    nouns = re.findall(r"^\| ([\w ]+) \| (?:`([\w.]+)`)? ?\| [^-]", text.split("## Where")[0], re.MULTILINE)
    nouns = [(noun, name) for noun, name in nouns if noun != "noun"]
    assert 40 < len(dict(nouns)) == len(nouns) <= 60
    for module, _, name in (name.rpartition(".") for _, name in nouns if name):
        assert getattr(importlib.import_module(module), name).__module__ == module


def test_every_file_that_the_glossary_names_is_there():
    where = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").split("## Where")[1]
    files = re.findall(r"`([\w/]+\.py)`", where)
    assert len(files) > 10
    assert [file for file in files if not (Path(skyverse.__file__).parent / file).exists()] == []


@pytest.mark.parametrize(
    "page", ["README.md", "docs/quickstart.md", "docs/check.md", "docs/tours.md", "docs/survey.md"]
)
def test_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys):
    pytest.importorskip("rotorpy", reason="the extra flight is not installed")
    monkeypatch.chdir(tmp_path)
    names = {"print": lambda *_: None}
    for language, block in blocks(page):
        if language == "pycon":
            run_session(page, block, names)
        elif language == "console":
            _, *said = block.splitlines()
            if said and not any(line.startswith("$") for line in said) and block.startswith("$"):
                run_command(block, capsys)
        else:
            exec(compile(block, page, "exec"), names)


def test_every_extra_is_named_on_the_page_about_installing():
    conf = (ROOT / "docs" / "conf.py").read_text(encoding="utf-8")
    listed = conf.split("EXTRAS = {")[1].split("\n}")[0]
    assert set(re.findall(r'^    "(\w+)":', listed, re.MULTILINE)) == set(PYPROJECT["project"]["optional-dependencies"])
    assert "generated/extras.md" in (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
