"""Who may steer over sockets: no browser, nobody without the token, and not too many at a time."""

import asyncio
import json
import os
import stat

import pytest

from patience import PATIENCE_S, come
from skyverse.live import Address, Hello, Server, serve

TOKEN = "a word that is long".replace(" ", "-")
LOCAL = Address("127.0.0.1", 0)
posix = pytest.mark.skipif(os.name == "nt", reason="signals to a process are POSIX here")


class Session:
    """A session that takes note of the lines that it is asked to answer."""

    def __init__(self):
        self.lines = []

    def hello(self):
        return Hello(version="1", mission="m", uavs=(), horizon=1.0, lead=0.1, memory=1.0, origin=None)

    def answer(self, line, number):
        self.lines.append((number, line))


def served(talk, where=LOCAL, token=None):
    """Run `talk(connect)` beside a server, and return the lines that were taken; `connect()` makes a connection."""
    session, found, writers = Session(), [], []

    async def run():
        taking = Server(session, token)
        server = asyncio.create_task(taking.serve(where, found.append))
        await come(lambda: found or server.done())
        if server.done():
            server.result()

        async def connect():
            if isinstance(where, Address):
                made = await asyncio.open_connection(where.host, int(found[0].rpartition(":")[2]))
            else:
                made = await asyncio.open_unix_connection(where)
            writers.append(made[1])
            return made

        try:
            await asyncio.wait_for(talk(connect), PATIENCE_S)
        finally:
            for writer in writers:
                writer.close()
            await come(lambda: not taking.connected)
            server.cancel()

    asyncio.run(run())
    return session.lines


def said(first, then=b"", token=None):
    """What a client is told until it is sent away, or has sent all, and which lines were taken."""
    told = []

    async def talk(connect):
        reader, writer = await connect()
        writer.write(first + then)
        writer.write_eof()
        told.extend((await reader.read()).splitlines())

    taken = served(talk, token=token)
    return [json.loads(line) for line in told], taken


SEEN = b'\n{"t": 0.2, "targets": {"0": [2, -3, 1]}}\n'
POST = (
    b"POST / HTTP/1.1\r\nHost: 127.0.0.1:5770\r\nContent-Type: text/plain\r\nContent-Length: %d\r\n"
    b"Origin: https://evil.example\r\n\r\n" % len(SEEN)
)


@pytest.mark.parametrize(
    "first",
    [
        POST,
        b"GET /?q={} HTTP/1.1\r\nUpgrade: websocket\r\n\r\n",
        b"\n",
        b" \r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\n",
        b"[1]\n",
        b"nonsense\n",
        b"PUT {\n",
    ],
    ids=["post", "websocket", "blank", "spaces", "tls", "list", "word", "other"],
)
def test_a_connection_whose_first_line_is_no_json_object_is_closed_before_anything_is_taken(first):
    told, taken = said(first, SEEN)
    assert taken == []
    assert "error" in told[-1]
    assert len(told) == 2  # the hello comes first


def test_lines_after_a_first_json_object_are_taken_whatever_they_hold():
    _, taken = said(b'{"t": 0}\n', b"nonsense\n\n" + SEEN[1:])
    assert [number for number, _ in taken] == [1, 2, 3, 4]


@pytest.mark.parametrize("first", [b"", b"{}\n", b'{"token": 5}\n', b'{"token": "another word"}\n', POST, b"x" * 9000])
def test_without_the_token_nothing_is_told_or_taken(first):
    told, taken = said(first, SEEN, token=TOKEN)
    assert taken == []
    assert [set(one) for one in told] == [{"error"}]
    assert TOKEN not in json.dumps(told)


def test_with_the_token_a_client_steers():
    told, taken = said(json.dumps({"token": TOKEN}).encode() + b"\n", SEEN[1:], token=TOKEN)
    assert [set(one) >= {"format", "uavs"} for one in told] == [True]
    assert [number for number, _ in taken] == [2]


def test_a_client_that_does_not_give_the_token_in_time_is_sent_away(monkeypatch):
    monkeypatch.setattr(serve, "TOKEN_SECONDS", 0.05)

    async def talk(connect):
        reader, _ = await connect()
        assert b"expected the token within" in await reader.read()

    assert served(talk, token=TOKEN) == []


def test_clients_beyond_the_most_are_sent_away_until_one_leaves(monkeypatch):
    monkeypatch.setattr(serve, "MAX_CLIENTS", 2)

    async def talk(connect):
        there = [await connect() for _ in range(2)]
        for reader, _ in there:
            await reader.readline()
        reader, _ = await connect()
        assert b"at most 2 clients" in await reader.read()
        there[0][1].close()
        while b"format" not in await (await connect())[0].readline():  # until it is noticed that one has left
            pass

    served(talk)


async def nothing(connect):
    """Send nothing."""


def test_where_other_machines_can_connect_a_token_is_needed(refuses):
    with refuses() as refused:
        served(nothing, Address("0.0.0.0", 0))
    assert refused.value.sentence.field == "listen"
    served(nothing, Address("0.0.0.0", 0), TOKEN)
    served(nothing, Address("localhost", 0))


@posix
def test_a_unix_socket_is_open_to_its_user_alone(tmp_path):
    path, before = tmp_path / "socket", os.umask(0)
    modes = []

    async def talk(connect):
        modes.append(stat.S_IMODE(path.stat().st_mode))

    try:
        served(talk, path)
    finally:
        os.umask(before)
    assert modes == [0o600]
