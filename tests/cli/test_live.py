"""The verb `live`, run as another program runs it: over pipes and over sockets."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack, contextmanager

import pytest

import skyverse as sky
from patience import PATIENCE_S

PROGRAM = (sys.executable, "-m", "skyverse", "live")
LINES = [b'{"t": 0}', b"nonsense", b'{"t": 0.1}', b""]
posix = pytest.mark.skipif(os.name == "nt", reason="signals to a process are POSIX here")


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    path = tmp_path_factory.mktemp("mission") / "map1.json"
    sky.write(sky.plan_mission(sky.read_scenario("map1"), sky.AStar()), path)
    return str(path)


@contextmanager
def started(mission, *words):
    """The program, which is killed after ten minutes if it has not ended by itself."""
    pipe = subprocess.PIPE
    with subprocess.Popen([*PROGRAM, mission, *words], stdin=pipe, stdout=pipe, stderr=pipe) as run:
        late = threading.Timer(PATIENCE_S, run.kill)
        late.start()
        try:
            yield run
            run.wait(PATIENCE_S)
        finally:
            late.cancel()
            run.kill()


def heard(stream):
    return json.loads(stream.readline())


def test_lines_are_answered_one_by_one_until_the_input_ends(mission):
    with started(mission) as run:
        assert heard(run.stdout)["format"] == "skyverse/live/1"  # before anything is sent
        for k, line in enumerate(LINES, 1):
            run.stdin.write(line + b"\n")
            run.stdin.flush()
            if line:
                answer = heard(run.stdout)  # before the next line is sent
                assert answer.get("line", answer.get("error", {}).get("line")) == k
        out, err = run.communicate(b'{"t": 0.2}', timeout=PATIENCE_S)  # the last line has no end
        assert json.loads(out)["line"] == 5
    assert run.returncode == 0
    assert err.decode().startswith(
        "3 observations answered, 3 of them with a proven way out for every UAV, the slowest"
    )
    assert err.decode().endswith("ms; 1 refused.\n")


@posix
def test_ctrl_c_ends_it_with_what_it_did(mission):
    with started(mission) as run:
        heard(run.stdout)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=PATIENCE_S)
    assert (run.returncode, out) == (130, b"")
    assert err.decode() == "No observations answered, no lines refused.\nskyverse: interrupted\n"


@posix
def test_a_reader_that_has_gone_ends_it_in_silence(mission):
    with started(mission) as run:
        heard(run.stdout)
        run.stdout.close()
        run.stdin.write(b'{"t": 0}\n')
        run.stdin.flush()
        assert run.stderr.read() == b""
        assert run.wait(PATIENCE_S) == 141


@contextmanager
def connected(where):
    """A client, and what it is told."""
    if "/" in where:
        client = socket.socket(socket.AF_UNIX)
        client.connect(where)
    else:
        host, _, port = where.rpartition(":")
        client = socket.create_connection((host, int(port)))
    client.settimeout(PATIENCE_S)
    with client, client.makefile("rb") as told:
        yield client, told


@posix
@pytest.mark.parametrize("where", ["0", "socket"])
def test_clients_share_a_mission_and_all_are_told_its_answers(mission, where, tmp_path):
    where = str(tmp_path / "socket") if where == "socket" else where
    with started(mission, "--listen", where) as run, ExitStack() as all_closed:
        where = run.stderr.readline().decode().removeprefix("Listening at ").strip()
        clients = [all_closed.enter_context(connected(where)) for _ in range(3)]
        for _, answers in clients:
            assert heard(answers)["format"] == "skyverse/live/1"
        (sender, said), (_, other), (gone, _) = clients
        gone.shutdown(socket.SHUT_RDWR)
        sender.sendall(b'{"t": 0}\nnonsense\n{"t"')
        assert heard(said)["line"] == 1
        assert heard(said)["error"]["line"] == 2
        sender.sendall(b": 0.1}\n")
        assert heard(said)["line"] == 3
        for t in (0.0, 0.1):
            answer = heard(other)
            assert (answer["line"], answer["t"]) == (None, t)
        run.send_signal(signal.SIGINT)
        assert said.readline() == b""
        err = run.stderr.read().decode()
    assert run.returncode == 130
    assert err.startswith("2 observations answered")
    assert err.endswith("1 refused.\nskyverse: interrupted\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [
        "--listen here",
        "--listen :80",
        "--listen 127.0.0.1:65536",
        "--listen /nowhere/socket",
        "--listen 0.0.0.0:0",
        "--token token",
        "--listen 0 --token token",
        "--listen 0 --token /nowhere/token",
        "--setpoints -1",
        "--wgs84",
        "--lead nan",
        "--candidates 0",
        "--schema",
    ],
)
def test_bad_options_are_refused_in_one_sentence(refused, mission, tmp_path, words):
    (tmp_path / "token").write_text("a token\nof two lines")
    refused("live", mission, *words.split())


def test_the_schema_stands_alone(skyverse):
    code, out, _ = skyverse("live", "--schema")
    assert code == 0
    assert {"ObservationMessage", "Answer", "Refusal", "Hello"} <= json.loads(out)["$defs"].keys()
    assert skyverse("live")[0] == 2
