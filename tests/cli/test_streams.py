"""What the program reads from and writes to, when that is no ordinary file: one sentence, and the right exit code."""

import json
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import skyverse as sky
from patience import PATIENCE_S, wait_until

PROGRAM = (sys.executable, "-m", "skyverse")
pytestmark = pytest.mark.skipif(os.name == "nt", reason="devices, pipes and signals are POSIX here")


def said(*words, **how):
    """Return the exit code of a command line in a process of its own, and what it wrote to standard error."""
    done = subprocess.run([*PROGRAM, *map(str, words)], stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S, **how)
    return done.returncode, done.stderr


EACH = """
import contextlib, io, json, sys
from skyverse.cli import main

for words in json.load(sys.stdin):
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        try:
            main(words)
        except SystemExit as ended:
            print(json.dumps([ended.code, said.getvalue()]))
"""


def said_of_each(commands, folder):
    """Return the same as `said` of many command lines, run in one process: what hangs ends with it."""
    given = json.dumps([[str(word) for word in words] for words in commands])
    how = {"input": given, "capture_output": True, "text": True, "timeout": PATIENCE_S, "cwd": folder}
    done = subprocess.run([sys.executable, "-c", EACH], check=True, **how)
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def mission_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mission") / "map1.json"
    sky.write(sky.plan_mission(sky.read_scenario("map1"), sky.AStar()), path)
    return path


COMMANDS = [(), ("--help",), ("scenarios",), ("scenarios", "map3"), ("scenarios", "--schema"), ("plan", "--help")]


@pytest.mark.parametrize("words", COMMANDS)
def test_a_reader_that_has_gone_ends_the_program_in_silence(words):
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as gone:
        assert said(*words, stdout=gone) == (141, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
@pytest.mark.parametrize("words", COMMANDS)
def test_output_that_is_full_is_told(words):
    with Path("/dev/full").open("w") as full:
        assert said(*words, stdout=full) == (
            2,
            "skyverse: the output cannot be written: No space left on device\n",
        )


def test_a_check_that_is_piped_away_is_not_taken_for_a_bad_mission(mission_file):
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as gone:
        assert said("check", mission_file, stdout=gone) == (141, "")


def test_ctrl_c_while_modules_load_is_one_sentence(tmp_path):
    (tmp_path / "cyclopts.py").write_text("import pathlib, time\npathlib.Path('loading').touch()\ntime.sleep(600)\n")
    path = os.pathsep.join([str(tmp_path), *sys.path])
    run = subprocess.Popen(
        [*PROGRAM, "scenarios"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path}, stderr=subprocess.PIPE, text=True
    )
    wait_until((tmp_path / "loading").exists, run)
    run.send_signal(signal.SIGINT)
    assert run.communicate(timeout=PATIENCE_S)[1] == "skyverse: interrupted\n"
    assert run.returncode == 130


@pytest.mark.parametrize(
    "words",
    [
        ("plan", "/dev/null"),
        ("check", "/dev/null"),
        ("show", "/dev/null"),
        ("export", "/dev/null", "out.plan"),
        ("fly", "/dev/null"),
        ("scenarios", "/dev/null"),
        ("compare", "/dev/null"),
    ],
)
def test_a_device_is_no_file_to_read(refused, words, tmp_path):
    refused(*words)
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    assert not list(tmp_path.iterdir())


def test_a_pipe_is_no_file_to_read_or_write(tmp_path, mission_file):
    for name in ("a.yaml", "a.json", "a.html", "a.plan", "a.txt", "a.tif", "a.geojson", "a.las", "a.bt"):
        os.mkfifo(tmp_path / name)
    refused = "expected a file, found a device or a pipe\n"
    commands = (
        ("plan", "a.yaml"),
        ("plan", "a.txt"),
        ("plan", "a.bt"),
        ("plan", "map1", "-o", "a.json"),
        ("check", "a.json"),
        ("show", mission_file, "-o", "a.html"),
        ("export", mission_file, "a.plan"),
        ("scenarios", "map1", "-o", "a.yaml"),
        ("scenario", "build", "--terrain", "a.tif", "-o", "b.yaml"),
        ("scenario", "build", "--zones", "a.geojson", "-o", "b.yaml"),
        ("scenario", "build", "--voxels", "a.las", "-o", "b.yaml"),
        ("scenario", "build", "--terrain", mission_file, "-o", "a.yaml"),
    )
    for words, (code, sentence) in zip(commands, said_of_each(commands, tmp_path), strict=True):
        assert code == 2, words
        assert sentence.endswith(refused), (words, sentence)
        assert sentence.count("\n") == 1
    assert all(stat.S_ISFIFO(path.stat().st_mode) for path in tmp_path.iterdir())


def test_the_library_never_replaces_a_device(tmp_path, refuses):
    os.mkfifo(tmp_path / "a.yaml")
    with refuses():
        sky.write(sky.read("map1"), tmp_path / "a.yaml")
    assert stat.S_ISFIFO((tmp_path / "a.yaml").stat().st_mode)


def test_words_of_thousands_of_characters_are_not_printed(skyverse):
    long = "1" * 5000
    for words in (
        ("plan", long),
        (long,),
        ("plan", "map1", "--seed", long),
        ("plan", "map1", "--planner", long),
        ("plan", "map1", "--set", long),
        ("plan", "map1", "--uav", f"{long},0,0"),
        ("plan", "map1", "--assignment", long),
        ("plan", "map1", f"--{long}"),
        ("plan", "map1", long),
        ("plan", "map1", "-o", f"{long}.json"),
        ("scenarios", "--schema", "-o", long),
    ):
        code, _, sentence = skyverse(*words)
        assert code == 2, words
        assert sentence.startswith("skyverse: ")
        assert sentence.count("\n") == 1
        assert len(sentence) < 400, sentence


def test_a_mission_that_does_not_say_its_format_is_told_so(refused, mission_file, tmp_path):
    data = json.loads(mission_file.read_text())
    del data["format"]
    bare = tmp_path / "bare.json"
    bare.write_text(json.dumps(data))
    for words in (("check", bare), ("show", bare), ("plan", bare)):
        refused(*words)
