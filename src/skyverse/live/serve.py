"""Steers a mission by what stands on a stream, or by what clients send over sockets, each of whom is told all answers.

Web pages can make browsers send what they like to any address, after lines of HTTP. So a connection whose first line is
no JSON object is closed before anything that it sent is taken.
"""

import asyncio
import hmac
import os
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager, suppress
from ipaddress import ip_address
from pathlib import Path
from typing import BinaryIO, NamedTuple

from skyverse.errors import InputError
from skyverse.interrupt import on_interrupt
from skyverse.live.messages import MAX_LINE, Answer, Hello, LineFault, LineSplitter, Refusal, json_of_line
from skyverse.live.session import LiveSession
from skyverse.model.quantities import derived

CHUNK = 2**16
"""Bytes that are read at once at most."""


def message_line(message: Hello | Answer | Refusal) -> bytes:
    """Return a message as a line of JSON; what is not there is left out only where nothing could be."""
    return message.model_dump_json().encode() + b"\n"


class _Interrupt:
    """Ctrl-C, which ends the program while it waits for input, or else after the line that is being answered.

    If it is pressed again, the program ends at once.
    """

    def __init__(self) -> None:
        self.waiting = self.asked = False

    def __call__(self, *_: object) -> None:
        if self.waiting or self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def read(self, source: BinaryIO) -> bytes:
        """Wait for input and return it, empty at its end."""
        self.waiting = True
        if self.asked:
            raise KeyboardInterrupt
        chunk = source.read1(CHUNK)  # type: ignore[attr-defined]
        self.waiting = False
        return chunk


def serve_streams(session: LiveSession, source: BinaryIO, sink: BinaryIO) -> None:
    """Answer all lines of a stream, one after another, until it ends; each answer is written as soon as it is known.

    Parameters
    ----------
    session
        The mission.
    source
        Where lines come from.
    sink
        Where a hello and the answers go.

    Raises
    ------
    KeyboardInterrupt
        If Ctrl-C was pressed; then the last line is whole.
    OSError
        If nothing can be written.
    """
    splitter, interrupt, number = LineSplitter(), _Interrupt(), 0
    with on_interrupt(interrupt):
        _send(sink, session.hello())
        ended = False
        while not ended:
            chunk = interrupt.read(source)
            ended = not chunk
            for line in splitter.end() if ended else splitter.lines(chunk):
                number += 1
                answer = session.answer(line, number)
                if answer is not None:
                    _send(sink, answer)
                if interrupt.asked:
                    raise KeyboardInterrupt


def _send(sink: BinaryIO, message: Hello | Answer | Refusal) -> None:
    sink.write(message_line(message))
    sink.flush()


MAX_UNREAD = 2**25
"""Bytes of answers that may wait for a client, 34 MB; one that leaves more of them unread is dropped."""


MAX_CLIENTS = 64
"""Clients at a time at most."""
MAX_TOKEN_LINE = 4096
"""Bytes that are held of the line of a client who has not given the token."""
TOKEN_SECONDS = 10.0
"""Seconds within which a client gives the token."""


class Address(NamedTuple):
    """Where to listen: a host and a port, 0 for any free one."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


OnListening = Callable[[str], None]
"""Called with where clients find the server, once they do."""


def serve_sockets(
    session: LiveSession, where: Address | Path, *, token: str | None = None, on_listening: OnListening | None = None
) -> None:
    """Answer what clients send, until the program is interrupted.

    Any number of clients may be there at a time, and come and go. Their observations are taken in as they arrive. Every
    client is told every answer, since it says what all UAVs fly from now on; why a line is refused is told to the one
    that sent it.

    Parameters
    ----------
    session
        The mission.
    where
        A host and a port; or the path of a Unix socket, which only this user can connect to, and which is removed at
        the end.
    token
        What clients must give in their first line, as in ``{"token": "..."}``, before they are told anything; needed
        where other machines can connect.
    on_listening
        Called with where clients find the server, once they do.

    Raises
    ------
    InputError
        If nobody can listen there, or other machines can connect and there is no token.
    """
    try:
        asyncio.run(Server(session, token).serve(where, on_listening))
    finally:
        if isinstance(where, Path) and where.is_socket():
            where.unlink(missing_ok=True)


class Server:
    """A session and its clients."""

    def __init__(self, session: LiveSession, token: str | None) -> None:
        self.session, self.token = session, token
        self.connected = 0
        self.clients: set[asyncio.StreamWriter] = set()

    async def serve(self, where: Address | Path, on_listening: OnListening | None) -> None:
        """Answer what clients send until this is cancelled; see `serve_sockets`."""
        try:
            if isinstance(where, Path):
                with _private_files():
                    server: asyncio.Server = await asyncio.start_unix_server(self.client, where, start_serving=False)
                found = str(where)
            else:
                server = await asyncio.start_server(self.client, where.host, where.port, start_serving=False)
                self.require_token(server, where)
                found = "{}:{}".format(*server.sockets[0].getsockname()[:2])
            await server.start_serving()
        except (OSError, OverflowError) as error:
            said = getattr(error, "strerror", None) or error
            raise InputError(f"{where}: nobody can listen there: {said}", field="listen") from None
        if on_listening is not None:
            on_listening(found)
        async with server:
            await server.serve_forever()

    def require_token(self, server: asyncio.Server, where: Address) -> None:
        """Raise `InputError` if other machines can connect, and there is no token."""
        local = all(ip_address(one.getsockname()[0]).is_loopback for one in server.sockets)
        if self.token is None and not local:
            server.close()
            said = f"{where}: other machines can connect there, so a token is needed, which is not given"
            raise InputError(said, field="listen")

    async def client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it closes the connection, or is sent away."""
        self.connected += 1
        with suppress(ConnectionError, asyncio.CancelledError):
            sent_away = await self.answer_all(reader, writer)
            if sent_away:
                writer.write(message_line(Refusal(error=LineFault(line=1, field=None, message=sent_away))))
        self.connected -= 1
        self.clients.discard(writer)
        writer.close()

    async def answer_all(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> str:
        """Answer all lines of a client; return why it is sent away, empty if it is not."""
        if self.connected > MAX_CLIENTS:
            return f"expected at most {MAX_CLIENTS} clients at a time, found one more"
        splitter, number = LineSplitter(), 0
        lines = _lines(reader, splitter)
        if self.token is not None:
            splitter.most = MAX_TOKEN_LINE
            try:
                number, line = 1, await asyncio.wait_for(anext(lines, b""), TOKEN_SECONDS)
            except TimeoutError:
                return f"expected the token within {TOKEN_SECONDS:g} s"
            if not _gives(line, self.token):
                return "expected the token in the first line, found something else"
            splitter.most = MAX_LINE + 1
        writer.write(message_line(self.session.hello()))
        self.clients.add(writer)
        async for line in lines:
            number += 1
            if number == 1 and _object_in(line) is None:
                return "expected a JSON object in the first line, found something else"
            self.answer(line, number, writer)
            await writer.drain()  # a client that does not read is not answered further
            await asyncio.sleep(0)  # it is the others' turn
        return ""

    def answer(self, line: bytes, number: int, sender: asyncio.StreamWriter) -> None:
        """Answer a line of one client, to all of them if it was taken in."""
        message = self.session.answer(line, number)
        if message is None:
            return
        sender.write(message_line(message))
        if not isinstance(message, Answer) or len(self.clients) == 1:
            return
        told = message_line(derived(message, line=None))
        for other in self.clients - {sender}:
            if other.transport.get_write_buffer_size() > MAX_UNREAD:
                other.transport.abort()
            elif not other.is_closing():
                other.write(told)


async def _lines(reader: asyncio.StreamReader, splitter: LineSplitter) -> AsyncIterator[bytes]:
    """Yield the lines that a client sends."""
    ended = False
    while not ended:
        chunk = await reader.read(CHUNK)
        ended = not chunk
        for line in splitter.end() if ended else splitter.lines(chunk):
            yield line


def _object_in(line: bytes) -> dict[str, object] | None:
    """Return the JSON object that a line holds; ``None`` if it holds none."""
    try:
        data = json_of_line(line)
    except InputError:
        return None
    return data if isinstance(data, dict) else None


def _gives(line: bytes, token: str) -> bool:
    """Tell whether a line gives a token; how long that takes tells nothing of it."""
    given = (_object_in(line) or {}).get("token")
    return isinstance(given, str) and hmac.compare_digest(given.encode(), token.encode())


@contextmanager
def _private_files() -> Iterator[None]:
    """Let files that are made meanwhile be read and written by this user alone."""
    before = os.umask(0o177)
    try:
        yield
    finally:
        os.umask(before)
