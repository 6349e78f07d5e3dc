"""Steers a mission by what clients send over local sockets, and tells each of them all answers."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from skyverse.errors import InputError
from skyverse.live.messages import Answer
from skyverse.live.observation_lines import LineSplitter
from skyverse.live.serve_streams import CHUNK, message_line
from skyverse.live.session import LiveSession

MAX_UNREAD = 2**25
"""Bytes of answers that may wait for a client, 34 MB; one that leaves more of them unread is dropped."""


class Address(NamedTuple):
    """Where to listen: a host and a port, 0 for any free one."""

    host: str
    port: int


OnListening = Callable[[str], None]
"""Called with where clients find the server, once they do."""


def serve_sockets(session: LiveSession, where: Address | Path, *, on_listening: OnListening | None = None) -> None:
    """Answer what clients send, until the program is interrupted.

    Any number of clients may be there at a time, and come and go. Their observations are taken in as they arrive. Every
    client is told every answer, since it says what all UAVs fly from now on; why a line is refused is told to the one
    that sent it.

    Parameters
    ----------
    session
        The mission.
    where
        A host and a port; or the path of a Unix socket, which is removed at the end.
    on_listening
        Called with where clients find the server, once they do.

    Raises
    ------
    InputError
        If nobody can listen there.
    """
    try:
        asyncio.run(_Server(session).serve(where, on_listening))
    finally:
        if isinstance(where, Path) and where.is_socket():
            where.unlink(missing_ok=True)


class _Server:
    """A session and its clients."""

    def __init__(self, session: LiveSession) -> None:
        self.session = session
        self.clients: set[asyncio.StreamWriter] = set()

    async def serve(self, where: Address | Path, on_listening: OnListening | None) -> None:
        try:
            if isinstance(where, Path):
                server: asyncio.Server = await asyncio.start_unix_server(self.client, where)
                found = str(where)
            else:
                server = await asyncio.start_server(self.client, where.host, where.port)
                found = "{}:{}".format(*server.sockets[0].getsockname()[:2])
        except (OSError, OverflowError) as error:
            said = getattr(error, "strerror", None) or error
            raise InputError(f"{_told(where)}: nobody can listen there: {said}", field="listen") from None
        if on_listening is not None:
            on_listening(found)
        async with server:
            await server.serve_forever()

    async def client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it closes the connection."""
        splitter, number = LineSplitter(), 0
        writer.write(message_line(self.session.hello()))
        self.clients.add(writer)
        with suppress(ConnectionError, asyncio.CancelledError):
            ended = False
            while not ended:
                chunk = await reader.read(CHUNK)
                ended = not chunk
                for line in splitter.end() if ended else splitter.lines(chunk):
                    number += 1
                    self.answer(line, number, writer)
                    await writer.drain()  # a client that does not read is not answered further
                    await asyncio.sleep(0)  # it is the others' turn
        self.clients.discard(writer)
        writer.close()

    def answer(self, line: bytes, number: int, sender: asyncio.StreamWriter) -> None:
        """Answer a line of one client, to all of them if it was taken in."""
        message = self.session.answer(line, number)
        if message is None:
            return
        sender.write(message_line(message))
        if not isinstance(message, Answer) or len(self.clients) == 1:
            return
        told = message_line(message.model_copy(update={"line": None}))
        for other in self.clients - {sender}:
            if other.transport.get_write_buffer_size() > MAX_UNREAD:
                other.transport.abort()
            elif not other.is_closing():
                other.write(told)


def _told(where: Address | Path) -> str:
    return str(where) if isinstance(where, Path) else f"{where.host}:{where.port}"
